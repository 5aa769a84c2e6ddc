"""The fields of this house: its languages, and the defaults of its configuration."""

from __future__ import annotations

import json

from gazechair.config import Config
from gazechair.profiles.fields import Field, fields
from gazechair.web.files import web_folder


def languages() -> list[str]:
    """Every language there is a file of words for, two letters each, Dutch first."""
    found = sorted(path.stem for path in (web_folder() / "strings").glob("??.json"))
    return sorted(found, key=lambda language: language != "nl")


def house_fields(config: Config) -> dict[str, Field]:
    """The fields of a profile with [driver] and [web].language as defaults."""
    driver = config.driver
    return fields(
        languages(),
        {
            "name": _name(config.web.language),
            "mode": driver.mode,
            "dwell_ms": driver.dwell_ms,
            "leave_grace_ms": driver.leave_grace_ms,
            "pointer_stale_ms": driver.pointer_stale_ms,
            "language": config.web.language,
        },
    )


def _name(language: str) -> str:
    # Until somebody gives the first profile a name of a person.
    words = json.loads((web_folder() / "strings" / f"{language}.json").read_text("utf-8"))
    return str(words["labels"]["role_driver"])
