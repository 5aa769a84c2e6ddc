"""Reads JSON from a person, a file or another program."""

from __future__ import annotations

import json
from typing import Any

_MARK = "\ufeff"  # a byte order mark, with which editors on Windows begin a file


def parse(text: str | bytes) -> Any:
    """Its value, whether or not it begins with a byte order mark.

    Raises ValueError for all that is no JSON, and for what is nested too deeply.
    """
    try:
        return json.loads(text.removeprefix(_MARK) if isinstance(text, str) else text)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
