"""docs/privacy.md lists all that is stored: each file that a module of the host keeps."""

from __future__ import annotations

import re
from pathlib import Path

from gazechair.base.sole_daemon import LOCK_NAME
from gazechair.people.pairing.local import SOCKET_NAME
from gazechair.sensing.mapping.stored.store import FOLDER as MAPS
from gazechair.service import hotspot

ROOT = Path(__file__).parents[2]
HOST = ROOT / "host" / "gazechair"
MAPPING = HOST / "sensing" / "mapping"


def listed() -> set[str]:
    """What the table's second column names."""
    text = (ROOT / "docs" / "privacy.md").read_text("utf-8")
    rows = [line.split("|")[2] for line in text.splitlines() if line.startswith("|")]
    return set(re.findall(r"`([^`]+)`", " ".join(rows)))


def test_every_file_of_the_state_folder_is_listed() -> None:
    folders = {"log/", "tls/", f"{MAPS}/", f"{MAPS}/older/", f"{MAPS}/drives/"}
    found = folders | {LOCK_NAME, SOCKET_NAME}
    for path in HOST.rglob("*.py"):
        text = path.read_text("utf-8")
        names = re.findall(r'^FILE_NAME = "(.+)"', text, re.MULTILINE)
        found |= set(names)
        # A module that writes a file names it so, else this test would not know of it. The
        # hotspot's is NetworkManager's.
        others = path.name in ("state_folder.py", "state_file.py", "hotspot.py")
        if re.search(r"\b(replace_file|StateFile)\(", text) and not others:
            assert names or path.is_relative_to(MAPPING), path
    found.add(str(hotspot._file(hotspot.FOLDER)))
    assert len(found) >= 15
    assert found - listed() == set()
