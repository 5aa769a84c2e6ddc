"""A map as an SVG picture: free floor, what stands there, and the track of the drive."""

from __future__ import annotations

from html import escape

import numpy as np

from gazechair.base.footprint import BoolArray
from gazechair.sensing.mapping.home_map import HomeMap

_PIXELS_PER_M = 40.0
_STYLE = (
    "<style>.floor{fill:#dbe7f0}.stands{fill:#222}.track{fill:none;stroke:#d55e00}"
    ".bar{stroke:#666}text{font:14px sans-serif;fill:#666}</style>"
)


def svg(home: HomeMap) -> str:
    """The whole picture, y upwards; the bar at its foot is one metre."""
    grid = home.grid
    nx, ny = grid.hits.shape
    scale = grid.cell_m * _PIXELS_PER_M
    width, height = nx * scale, ny * scale + 30.0
    points = (home.track[:, :2] - grid.low_m) / grid.cell_m
    track = " ".join(f"{x:.1f},{ny - y:.1f}" for x, y in points)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}">{_STYLE}'
        f"<title>{escape(home.name)}</title>"
        f'<g transform="scale({scale:g})" shape-rendering="crispEdges">'
        f'<path class="floor" d="{_runs(grid.free)}"/>'
        f'<path class="stands" d="{_runs(grid.occupied)}"/>'
        f'<polyline class="track" stroke-width="{0.04 / grid.cell_m:g}" points="{track}"/></g>'
        f'<path class="bar" d="M10 {height - 12:.0f}h{_PIXELS_PER_M:g}"/>'
        f'<text x="{20 + _PIXELS_PER_M:g}" y="{height - 8:.0f}">1 m &#183; {escape(home.name)}'
        "</text></svg>\n"
    )


def _runs(cells: BoolArray) -> str:
    """One rectangle for each run of cells along x."""
    ny = cells.shape[1]
    edges = np.diff(np.pad(cells.T, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    rows, begins = np.nonzero(edges == 1)
    ends = np.nonzero(edges == -1)[1]
    return "".join(
        f"M{begin} {ny - 1 - row}h{end - begin}v1h{begin - end}z"
        for row, begin, end in zip(rows, begins, ends, strict=True)
    )
