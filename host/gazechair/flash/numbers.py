"""The firmware's texts with the numbers of its tables put in, as a compiler would.

Looking a number up in its module takes the board longer than most things that are done with it: the
tick runs a tenth fewer instructions without.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

# Name in the code -> path of the module: plain numbers only, written as NAME = 1 or const(1).
_TABLES = {"codes": "gazelink/codes.py", "limits": "gazeboard/limits.py"}
_ROW = re.compile(r"^([A-Z][A-Z0-9_]*) = (?:const\((\d+)\)|(\d+))(?:\s*#.*)?$", re.MULTILINE)


def put_in(texts: Mapping[str, str]) -> dict[str, str]:
    """The same texts {path: text}, `codes.NAME` and `limits.NAME` replaced by their numbers."""
    numbers = {
        f"{name}.{row[1]}": row[2] or row[3]
        for name, path in _TABLES.items()
        for row in _ROW.finditer(texts.get(path, ""))
    }
    used = re.compile(rf"(?<![\w.])(?:{'|'.join(_TABLES)})\.[A-Z][A-Z0-9_]*\b")
    return {
        path: used.sub(lambda match: numbers.get(match[0], match[0]), text)
        for path, text in texts.items()
    }
