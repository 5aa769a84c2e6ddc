"""The list of cores by which a log of another version is recognised."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from gazeboard.core.motion import Motion
from gazereplay import layouts


def test_each_core_of_a_version_is_listed_and_no_two_have_as_many_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    listed = layouts.listed()
    how = "python -m gazereplay.layouts"
    assert layouts.ours().items() <= listed.items(), f"the core changed; run {how}"
    other = tmp_path / "layouts.txt"
    other.write_bytes(layouts.FILE.read_bytes())
    monkeypatch.setattr(layouts, "FILE", other)
    layouts.add()
    assert layouts.listed() == listed
    init = Motion.__init__

    def renamed(self: Any, settings: Any, turn: Any) -> None:
        init(self, settings, turn)
        name = next(key for key, value in sorted(vars(self).items()) if isinstance(value, int))
        setattr(self, f"{name}_renamed", vars(self).pop(name))

    monkeypatch.setattr(Motion, "__init__", renamed)
    assert layouts.ours().keys() <= listed.keys()
    with pytest.raises(ValueError, match="raise the patch of VERSION"):
        layouts.add()
