"""A board's flash in memory, whose power can be cut at the n-th request."""

import hashlib

from gazechair.service.flash.board_files import Facts
from gazechair.service.flash.errors import FlashError

TEENSY = Facts("mimxrt", "Teensy 4.0 with MIMXRT1062DVJ6A", (1, 29, 0), 6 | 3 << 8 | 8 << 10, True)


class FakeBoardFiles:
    """Implements BoardFiles. `power_cut_at`: which change fails, half done; None for none."""

    def __init__(self, facts: Facts = TEENSY) -> None:
        self.files: dict[str, bytes] = {}
        self.made: set[str] = {"/flash"}
        self.free = 900_000
        self.power_cut_at: int | None = None
        self.changes: list[str] = []
        self.feeds = 0
        self.resets = 0
        self._facts = facts

    def _change(self, what: str) -> None:
        self.changes.append(what)
        if self.power_cut_at is not None and len(self.changes) > self.power_cut_at:
            raise FlashError("the board stopped answering")

    def facts(self) -> Facts:
        return self._facts

    def hashes(self, folder: str) -> dict[str, str]:
        return {
            path: hashlib.sha256(content).hexdigest()
            for path, content in self.files.items()
            if path.startswith(folder + "/")
        }

    def folders(self, folder: str) -> list[str]:
        inside = [path[len(folder) + 1 :] for path in [*self.files, *self.made] if path != folder]
        return sorted({name.split("/")[0] for name in inside if "/" in name or name in self.made})

    def read(self, path: str) -> bytes | None:
        return self.files.get(path)

    def make_folder(self, path: str) -> None:
        self._change(f"make {path}")
        parts = path.split("/")
        self.made |= {"/".join(parts[:n]) for n in range(2, len(parts) + 1)}

    def write(self, path: str, content: bytes) -> None:
        assert path.rpartition("/")[0] in self.made, f"no folder for {path}"
        self.files[path] = content[: len(content) // 2]
        self._change(f"write {path}")
        self.files[path] = content

    def rename(self, path: str, new_path: str) -> None:
        self._change(f"rename {path} {new_path}")
        self.files[new_path] = self.files.pop(path)

    def remove(self, path: str) -> None:
        self._change(f"remove {path}")
        for each in [p for p in self.files if p == path or p.startswith(path + "/")]:
            del self.files[each]
        self.made = {p for p in self.made if p != path and not p.startswith(path + "/")}

    def free_bytes(self) -> int:
        return self.free

    def feed_watchdog(self) -> None:
        self.feeds += 1

    def reset(self) -> None:
        self.resets += 1

    def close(self) -> None:
        pass
