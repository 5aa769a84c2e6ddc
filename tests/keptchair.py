"""A simulated chair brought into a state once, from which each test continues with its own copy."""

from __future__ import annotations

import io
import pickle
import sys
import threading
import types
from collections.abc import Callable
from typing import Any, Generic, TypeVar

Chair = TypeVar("Chair")
_OURS = ("gazeboard", "gazechair", "gazelink", "gazesim")
# Nobody holds or waits for these in virtual time, and no thread is started: another is as good.
_EMPTY: dict[type, Callable[[], object]] = {
    type(threading.Lock()): threading.Lock,
    type(threading.RLock()): threading.RLock,
    threading.Condition: threading.Condition,
    threading.Thread: threading.Thread,
}
_PLAIN = (int, float, str, bytes, tuple, frozenset, type(None))


class KeptChair(Generic[Chair]):
    """Gives copies of a chair as it is now; the chair itself must not be used any more.

    What modules hold (constants, buffers) is shared by the copies, as it is by all chairs.
    """

    def __init__(self, chair: Chair) -> None:
        self._chair = chair  # its World knows arrays by their addresses, which stay taken
        self._shared: list[object] = []
        file = io.BytesIO()
        _Saver(file, self._shared).dump(chair)
        self._saved = file.getvalue()

    def copy(self) -> Chair:
        """Another one, which shares nothing that changes with the others."""
        chair: Chair = _Loader(io.BytesIO(self._saved), self._shared).load()
        return chair


class _Saver(pickle.Pickler):
    def __init__(self, file: io.BytesIO, shared: list[object]) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._shared = shared
        modules = [m for name, m in sys.modules.items() if name.partition(".")[0] in _OURS]
        held = [thing for module in modules for thing in vars(module).values()]
        self._held = {id(thing) for thing in held if not isinstance(thing, _PLAIN)}

    def persistent_id(self, thing: object) -> int | None:
        if isinstance(thing, types.FunctionType):
            for cell in thing.__closure__ or ():
                known = cell.cell_contents
                assert isinstance(known, (*_PLAIN, types.FunctionType)), f"{thing} knows {known}"
        elif not isinstance(thing, io.TextIOBase) and id(thing) not in self._held:
            return None
        self._shared.append(thing)
        return len(self._shared) - 1

    def reducer_override(self, thing: object) -> Any:
        make = _EMPTY.get(type(thing))
        return NotImplemented if make is None else (make, ())


class _Loader(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, shared: list[object]) -> None:
        super().__init__(file)
        self._shared = shared

    def persistent_load(self, number: int) -> object:
        return self._shared[number]
