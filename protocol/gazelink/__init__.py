# The wire between host and board: framing, CRC, message table, codes; the same files on both ends.

VERSION = (0, 1, 0)
