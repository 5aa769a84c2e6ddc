# For `@micropython.native`: machine code instead of bytecode, a sixth fewer instructions in the
# tick. `@micropython.viper` with ptr32(array("i")), ptr8(bytearray) and ints: machine words, a
# tenth of them.
# MicroPython's compiler knows these words by their spelling; on CPython they change nothing, so
# what is written in viper keeps within 31 bits and divides nothing negative.

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
