"""The languages of the pages: one file of texts each."""

from __future__ import annotations

import importlib
import json
from functools import cache
from pathlib import Path
from typing import Any


def web_folder() -> Path:
    """The folder of index.html: package `gazeweb` when installed, else web/ next to host/.

    Raises FileNotFoundError with what to do when neither exists.
    """
    try:
        package = importlib.import_module("gazeweb")
    except ModuleNotFoundError:
        folder = Path(__file__).resolve().parents[3] / "web"
    else:
        folder = Path(str(package.__file__)).parent
    if not (folder / "index.html").is_file():
        raise FileNotFoundError(
            f"the page's files are not at {folder}: install gazechair again, or run it from a clone"
        )
    return folder


def languages() -> list[str]:
    """All languages that have a file of texts, two letters each, Dutch first."""
    found = sorted(path.stem for path in (web_folder() / "strings").glob("??.json"))
    return sorted(found, key=lambda language: language != "nl")


def label(language: str, key: str) -> str:
    """A label of the pages. Raises FileNotFoundError, KeyError."""
    return str(_texts(web_folder(), language)["labels"][key])


def message(language: str, key: str) -> tuple[str, str]:
    """The text for `key`, and what to do about it. Raises FileNotFoundError, KeyError.

    A message of the pages, or a label about plug-ins or for caretakers.
    """
    folder = web_folder()
    own, care, plugins = (_texts(folder, language + more) for more in ("", "-care", "-plugins"))
    found = own["messages"].get(key) or care["messages"].get(key)
    if found:
        return str(found["text"]), str(found["do"])
    if key in plugins["labels"]:
        return str(plugins["labels"][key]), str(plugins["labels"]["plugin_people"])
    return str(care["labels"][key]), ""


def sentence(language: str, key: str) -> str:
    """The text for `key`. Raises as message does."""
    return message(language, key)[0]


def advice(key: str) -> str:
    """What to do about `key`, for a terminal; "" when the tables have no advice."""
    try:
        return message("en", key)[1]
    except (FileNotFoundError, KeyError):
        return ""


@cache  # /health asks for each of its parts
def _texts(folder: Path, name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((folder / "strings" / f"{name}.json").read_text("utf-8"))
    return found
