# For `@micropython.native`: machine code instead of bytecode, a sixth fewer instructions in the
# tick. MicroPython's compiler knows the decorator by its spelling; on CPython it changes nothing.

import sys

if sys.implementation.name == "micropython":
    import micropython
else:

    class micropython:
        @staticmethod
        def native(function):
            return function


__all__ = ("micropython",)
