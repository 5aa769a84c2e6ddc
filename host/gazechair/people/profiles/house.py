"""Profile fields that depend on this installation: its languages and configured defaults."""

from __future__ import annotations

from gazechair.base.languages import label, languages
from gazechair.config.settings import Config
from gazechair.people.profiles.fields import Field, fields


def house_fields(config: Config) -> dict[str, Field]:
    """The fields of a profile with [driver] and [web].language as defaults."""
    driver = config.driver
    return fields(
        languages(),
        {
            # Name of the first profile until somebody renames it.
            "name": label(config.web.language, "role_driver"),
            "mode": driver.mode,
            "dwell_ms": driver.dwell_ms,
            "leave_grace_ms": driver.leave_grace_ms,
            "pointer_stale_ms": driver.pointer_stale_ms,
            "assist": driver.assist,
            "language": config.web.language,
        },
    )
