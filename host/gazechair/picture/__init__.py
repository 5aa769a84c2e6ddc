"""The picture on its way to a page: how large it may be, and making it that small."""

from gazechair.picture.pacing import Pacing
from gazechair.picture.reducer import LEVELS, Reducer

__all__ = ["LEVELS", "Pacing", "Reducer"]
