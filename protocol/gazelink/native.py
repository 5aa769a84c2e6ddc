# `@micropython.native` and viper names, so that the same code runs on CPython.
#
# Native is machine code instead of bytecode, a sixth fewer instructions in the tick;
# `@micropython.viper` with ptr32(array("i")), ptr8(bytearray) and ints is machine words, a tenth of
# the instructions. MicroPython's compiler recognises these names by their spelling; on CPython they
# have no effect, so viper code stays within 31 bits and divides nothing negative.

import sys

if sys.implementation.name == "micropython":
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
