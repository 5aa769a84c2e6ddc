# The wire protocol between host and board: framing, CRC, message table, codes.
# The same files run on both ends.

VERSION = (0, 2, 0)
