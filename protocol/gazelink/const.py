# const(): MicroPython's compiler inlines such numbers; on CPython it has no effect.

import sys

if sys.implementation.name == "micropython":
    from micropython import const
else:

    def const(value):
        return value


__all__ = ("const",)
