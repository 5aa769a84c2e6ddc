"""The tile that follows a person."""

from __future__ import annotations

from gazechair.producers.places import Target


def people(allowed: bool) -> dict[str, Target]:
    """The tile, by its mode; `allowed`: this driver may use auto motions."""
    if not allowed:
        return {}
    return {"follow-person": Target("Volg persoon", "person", {}, "Follow person")}
