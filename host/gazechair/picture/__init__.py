"""The camera's picture for the pages: reduced to the size that each viewer's link carries."""

from gazechair.picture.pacing import Pacing
from gazechair.picture.reducer import LEVELS, Reducer

__all__ = ["LEVELS", "Pacing", "Reducer"]
