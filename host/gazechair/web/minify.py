"""Removes comments and indentation from the pages' files, so that a tablet loads less.

Scripts keep their lines, so an error's line number is still right.
"""

from __future__ import annotations

import json

_MINIFIED = (".js", ".css", ".html")


def minified(text: str, suffix: str) -> str:
    """`text` of a page's file without whole-line comments and indentation.

    Relies on two rules that tests/web/test_web_files.py checks: comments have lines of
    their own, and no text continues over a line's end.
    """
    if suffix == ".json":
        return json.dumps(json.loads(text), ensure_ascii=False, separators=(",", ":"))
    if suffix not in _MINIFIED:
        return text
    lines = []
    inside = ""  # what ends the comment we are in
    for line in text.splitlines():
        bare = line.strip()
        if inside:
            inside = "" if bare.endswith(inside) else inside
            bare = ""
        elif bare.startswith("/*"):
            inside = "" if bare.endswith("*/") else "*/"
            bare = ""
        elif bare.startswith("<!--"):
            inside = "" if bare.endswith("-->") else "-->"
            bare = ""
        elif bare.startswith("//"):
            bare = ""
        if bare or suffix == ".js":
            lines.append(bare)
    return "\n".join(lines) + "\n"
