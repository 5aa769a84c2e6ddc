"""The committed record of what was proven: docs/proof.json.

`parts` has a row for each part: whether it was proved, its figures, and `of`, one hash of all that
it proved: sources, tests, the prover's own files. `files` says of what such a hash is made.
"""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import Any

from gazeprove import (
    equivalents,
    part_core,
    part_costly,
    part_fuzz,
    part_long,
    part_tests,
    record_file,
)
from gazeprove.modules import MODULES, file_of, suite_files
from gazeprove.sources import digest_of, digests

_SAYS = "Written by tools/prove. Whatever changes one of these files makes it out of date."

# part -> where its imports begin
_CORE = (Path(part_core.__file__),)
_TESTS = (Path(part_tests.__file__), *map(file_of, MODULES), *suite_files(), *equivalents.files())
_FUZZ = (Path(part_fuzz.__file__),)
_BEGINS = {
    "enumeration": _CORE,
    "everything at once": _CORE,
    "decisions": _CORE,
    "coverage": _TESTS,
    "mutation": _TESTS,
    "fuzz": _FUZZ,
    "planted": _FUZZ,
    **part_long.begins(),
}


def files_of(part: str) -> dict[str, str]:
    """What a part proves now: the digest of each file."""
    return part_costly.digests() if part == part_costly.NAME else digests(_BEGINS[part])


def write(
    part: str,
    figures: dict[str, Any],
    short: list[str],
    files: dict[str, str],
    file: Path = record_file.FILE,
) -> None:
    """Put one part's row in; the others stay."""
    record = record_file.read(file)
    row = {"proved": not short, "of": digest_of(files), "figures": figures}
    rows = {**record["parts"], part: {**row, "short": short} if short else row}
    parts = {name: rows[name] for name in (*_BEGINS, part_costly.NAME) if name in rows}
    known = {**record["files"], digest_of(files): files}
    used = {row["of"]: known[row["of"]] for row in parts.values()}
    text = json.dumps({"says": _SAYS, "parts": parts, "files": used}, indent=1) + "\n"
    with tempfile.NamedTemporaryFile("w", dir=file.parent, delete=False) as temporary:
        temporary.write(text)
    os.chmod(temporary.name, 0o644)
    os.replace(temporary.name, file)


def why_not(part: str, record: dict[str, Any], now: dict[str, str]) -> str:
    """In a sentence why the record does not say that the part is proved; "" when it does."""
    row = record["parts"].get(part)
    if row is None:
        return f"{part}: never proven: run tools/prove"
    was = record["files"][row["of"]]
    changed = sorted(name for name in {*was, *now} if was.get(name) != now.get(name))
    if changed:
        names = ", ".join(Path(name).name for name in changed)
        return f"{part}: {names} changed since it was proven: run tools/prove"
    if row["of"] != digest_of(now):
        return f"{part}: the record does not fit itself: run tools/prove"
    if not row["proved"]:
        return f"{part}: NOT PROVED: {'; '.join(row['short'])}"
    return ""


def why_not_now(part: str) -> str:
    """The same of the committed record and the files as they are."""
    return why_not(part, record_file.read(), files_of(part))
