"""Which core each version of the firmware has: a trace's snapshots do not name their words.

A log names its board's version and table of messages, and a snapshot how many words it has.
`layouts.txt` lists what these three mean, so that no two cores share them: a test fails until a
changed core is listed, or has another version. `python -m gazereplay.layouts` lists this one.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from gazelink import VERSION, frame
from gazereplay.core import layouts

FILE = Path(__file__).with_name("layouts.txt")
CHANGE = (
    "another core of this version has as many words, so its logs would be read wrongly:"
    " raise the patch of VERSION in protocol/gazelink/__init__.py"
)


def ours() -> dict[str, str]:
    """{version, table, number of words: digest of their names} of this core."""
    found = {}
    for names in layouts():
        version = ".".join(map(str, VERSION))
        key = f"{version} {frame.schema_hash():08x} {len(names)}"
        found[key] = hashlib.sha256("\n".join(names).encode()).hexdigest()[:16]
    return found


def listed() -> dict[str, str]:
    """The same of all cores in `layouts.txt`."""
    rows = (line.rpartition(" ") for line in FILE.read_text().splitlines())
    return {key: digest for key, _, digest in rows}


def add() -> None:
    """List this core. Raises ValueError when another one has its version and number of words."""
    known = listed()
    for key, digest in ours().items():
        if known.setdefault(key, digest) != digest:
            raise ValueError(CHANGE)
    FILE.write_text("".join(f"{key} {digest}\n" for key, digest in known.items()))


if __name__ == "__main__":
    add()
