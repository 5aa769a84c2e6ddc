"""The outline that plans keep clear: the body, grown where a margin is wider than the default one.

All limits of clearance in this package contain the default margins. Where the configured ones are
wider, the board keeps as much more clear.
"""

from __future__ import annotations

from gazechair.base.arrays import FloatArray
from gazechair.base.footprint import Footprint, Margins


def wider(margins: Margins) -> Margins:
    """By how much each margin exceeds the default one."""
    pairs = zip(margins.widths_m, Margins().widths_m, strict=True)
    return Margins(*(max(0.0, margin - default) for margin, default in pairs))


def outline(footprint: Footprint) -> list[FloatArray]:
    """Polygons (N, 2) in the chair's frame; together they are the outline."""
    margins = wider(footprint.margins)
    if not any(margins.widths_m):
        return [footprint.body]
    return Footprint(footprint.body.tolist(), margins).parts


def own_place(footprint: Footprint) -> Footprint:
    """Where the chair itself is, with all that is fixed to it, however wide its margins are."""
    return Footprint(footprint.body.tolist())
