"""Where the pages' texts are found."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from gazechair.base.languages import languages, web_folder

ROOT = Path(__file__).resolve().parents[3]


def test_a_clone_that_is_not_installed_shows_its_own_pages(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "gazeweb", None)
    assert web_folder() == ROOT / "web"
    assert languages()[0] == "nl"
