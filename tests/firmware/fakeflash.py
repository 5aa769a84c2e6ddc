# A flash for tests of storage.py, in memory: it loses its power at any operation, or refuses.

from gazeboard.io import storage


class PowerCut(Exception):
    pass


class _Open:
    def __init__(self, flash, path, mode):
        self._flash = flash
        self._path = path
        if mode == "wb":
            flash.operate(True)
            flash.data[path] = b""
        elif path not in flash.data:
            raise OSError(2)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return False

    def read(self, limit):
        return self._flash.data[self._path][:limit]

    def write(self, data):
        flash = self._flash
        flash.data[self._path] = data[: len(data) // 2]  # what a power cut leaves
        flash.operate(True)
        flash.data[self._path] = data
        return len(data)


class Flash:
    # cut_at: power is lost before this operation, counted from 1; full: no file can be written;
    # dead: none can be renamed or removed either.

    def __init__(self):
        self.data = {}
        self.cut_at = 0
        self.full = False
        self.dead = False
        self._count = 0

    def use(self):
        storage.open = lambda path, mode: _Open(self, path, mode)
        storage.os = self

    def operate(self, writes):
        self._count += 1
        if self._count == self.cut_at:
            raise PowerCut
        if self.dead or (self.full and writes):
            raise OSError(28)

    def rename(self, old, new):
        self.operate(False)
        self.data[new] = self.data.pop(old)

    def remove(self, path):
        if path not in self.data:
            raise OSError(2)
        self.operate(False)
        del self.data[path]

    # The power is back.
    def again(self):
        self.cut_at = 0
        self._count = 0

    def text(self, name):
        data = self.data.get("/" + name)
        return None if data is None else data.decode()

    def put(self, name, data):
        self.data["/" + name] = data


def files_on(flash):
    flash.use()
    return storage.Files("")


def real():
    # Afterwards: the computer's own files again.
    import os

    storage.os = os
    storage.open = open
