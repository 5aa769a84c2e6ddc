# `@micropython.native` and viper names, so that the same code runs on CPython.
#
# Native is machine code instead of bytecode, a sixth fewer instructions in the tick;
# `@micropython.viper` with ptr32(array("i")), ptr8(bytearray) and ints is machine words, a tenth of
# the instructions. MicroPython's compiler recognises these names by their spelling; on CPython they
# have no effect, so viper code stays within 31 bits and divides nothing negative.

import sys

# The architecture that MicroPython's compiler makes machine code for; 0 where it makes none. There,
# as on CPython, the plain form runs: a loader drops the decorators, which it would not take.
if getattr(sys.implementation, "_mpy", 0) >> 10:
    import micropython

    ptr32 = ptr8 = None  # the compiler's own
else:

    class micropython:
        @staticmethod
        def native(function):
            return function

        @staticmethod
        def viper(function):
            return function

    def ptr32(words):
        return words

    def ptr8(octets):
        return octets


__all__ = ("micropython", "ptr8", "ptr32")
