# const(): MicroPython's compiler puts such numbers into the code; on CPython it changes nothing.

import sys

if sys.implementation.name == "micropython":
    from micropython import const
else:

    def const(value):
        return value


__all__ = ("const",)
