# Small text files in one folder of the flash, each replaced as a whole.
#
# A file is written under a temporary name, then renamed: a power cut leaves the old one. A line is
# sealed with its CRC-32. Reading never raises, so no content prevents the board from starting.

import os

from gazelink import crc

SIZE_MAX = 16384  # characters; the largest is settings.json with some 3000
UNREADABLE = ""  # what load() returns for a file that is no text

_NO_SUCH_FILE = 2


class Files:
    def __init__(self, folder):
        self._folder = folder

    # The text; None when there is no such file; UNREADABLE when it cannot be read, is empty, too
    # large or not ASCII.
    def load(self, name):
        try:
            with open(self._folder + "/" + name, "rb") as f:
                data = f.read(SIZE_MAX + 1)
            if not data or len(data) > SIZE_MAX or max(data) > 127:
                return UNREADABLE
            return data.decode()
        except OSError as error:
            return None if error.args and error.args[0] == _NO_SUCH_FILE else UNREADABLE
        except Exception:  # no memory for it
            return UNREADABLE

    # Raises OSError when the flash does not take it; the old file stands then.
    def store(self, name, text):
        path = self._folder + "/" + name
        data = text.encode()
        try:
            with open(path + ".new", "wb") as f:
                if f.write(data) != len(data):
                    raise OSError(28)
            os.rename(path + ".new", path)
        except OSError:
            _removed(path + ".new")
            raise

    # Raises OSError when it is still there.
    def remove(self, name):
        path = self._folder + "/" + name
        if not _removed(path) and self.load(name) is not None:
            raise OSError(5)


def _removed(path):
    try:
        os.remove(path)
        return True
    except OSError:
        return False


# One line as it is stored: a second line has its CRC-32.
def sealed(line):
    return line + "\n" + _crc_of(line) + "\n"


# The line of a stored text; None when it is damaged.
def unsealed(text):
    line, _, rest = text.partition("\n")
    return line if rest.strip() == _crc_of(line) else None


def _crc_of(line):
    seed = crc.make_seed(line.encode())
    return "%02x%02x%02x%02x" % (seed[3], seed[2], seed[1], seed[0])
