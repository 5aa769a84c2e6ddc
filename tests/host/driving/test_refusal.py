"""What a refusal may name is what the pages' contract lists."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any, get_args
from unittest.mock import MagicMock

import pytest

from gazechair.driving.refusal import What
from gazechair.first_drive.port import FirstDrivePort

DOC = Path(__file__).parents[3] / "docs" / "developing-pages.md"


def test_the_pages_contract_lists_what_can_be_refused() -> None:
    told = re.search(r'"k":"refused".*?`what`: ([\w,\s]+);', DOC.read_text(), re.S)
    assert told is not None
    assert tuple(re.findall(r"\w+", told[1].replace(" or ", " "))) == get_args(What)


@pytest.mark.parametrize(
    ("kind", "what"),
    [(kind, kind) for kind in ("cmd", "drive", "bypass", "reset")] + [("mode", "drive")],
)
def test_what_must_wait_for_a_step_of_the_first_drive_is_refused_by_its_listed_name(
    kind: str, what: str
) -> None:
    control: Any = MagicMock()
    control.role.return_value = "driver"
    guide: Any = SimpleNamespace(moving="turn")
    refused = FirstDrivePort(control, guide).receive(1, {"k": kind})
    assert [(one["k"], one["what"]) for one in refused] == [("refused", what)]
