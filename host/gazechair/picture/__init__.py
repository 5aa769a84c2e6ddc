"""The camera's picture: for the pages as each link carries it, for processes, over the floor."""

from gazechair.picture.pacing import Pacing
from gazechair.picture.reducer import LEVELS, Reducer

__all__ = ["LEVELS", "Pacing", "Reducer"]
