"""Line plots as small SVG files: axes, lines, marks, a legend; readable on light and dark."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

WIDTH, HEIGHT = 720, 320
_LEFT, _RIGHT, _TOP, _BOTTOM = 62, 16, 34, 48
_MOST_POINTS = 700  # more than the plot has pixels shows nothing more
# Colours that colour-blind eyes distinguish too (Okabe and Ito); each line also has its own dashes.
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
_DASHES = ("", "7 3", "2 3", "10 3 2 3", "4 2", "12 4")
_STYLE = """<style>
text{font:12px sans-serif;fill:#222}.title{font-size:14px;font-weight:bold}
.axis{stroke:#666;fill:none}.grid{stroke:#ccc;fill:none}.band{fill:#88888833}
.mark{stroke:#222;fill:none}.line{fill:none;stroke-width:1.8}
@media(prefers-color-scheme:dark){text{fill:#ddd}.axis{stroke:#999}.grid{stroke:#444}
.mark{stroke:#eee}}
</style>"""


@dataclass(frozen=True)
class Line:
    """One curve."""

    name: str
    xs: Sequence[float]
    ys: Sequence[float]


@dataclass(frozen=True)
class Mark:
    """A cross with a label, for one published or measured point."""

    x: float
    y: float
    text: str


@dataclass
class Plot:
    """One pair of axes. A range of None follows from the lines; `band` shades y from..to."""

    title: str
    x_label: str
    y_label: str
    lines: list[Line] = field(default_factory=list)
    marks: list[Mark] = field(default_factory=list)
    band: tuple[float, float] | None = None
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None

    def elements(self) -> str:
        """The plot as SVG elements within WIDTH x HEIGHT. ValueError without any finite point."""
        points = [p for line in self.lines for p in zip(line.xs, line.ys, strict=True)]
        points += [(mark.x, mark.y) for mark in self.marks]
        points = [p for p in points if math.isfinite(p[0]) and math.isfinite(p[1])]
        if not points:
            raise ValueError(f"plot {self.title!r} has no finite point to show")
        x_low, x_high = self.x_range or _widened([p[0] for p in points], 0.0)
        y_low, y_high = self.y_range or _widened([p[1] for p in points], 0.05)

        def at_x(x: float) -> float:
            return _LEFT + (x - x_low) / (x_high - x_low) * (WIDTH - _LEFT - _RIGHT)

        def at_y(y: float) -> float:
            return HEIGHT - _BOTTOM - (y - y_low) / (y_high - y_low) * (HEIGHT - _TOP - _BOTTOM)

        right, bottom = WIDTH - _RIGHT, HEIGHT - _BOTTOM
        out = [f'<text class="title" x="{_LEFT}" y="20">{escape(self.title)}</text>']
        if self.band is not None:
            low, high = max(y_low, self.band[0]), min(y_high, self.band[1])
            height = at_y(low) - at_y(high)
            out.append(
                f'<rect class="band" x="{_LEFT}" y="{at_y(high):.1f}" '
                f'width="{right - _LEFT}" height="{height:.1f}"/>'
            )
        for x in _ticks(x_low, x_high):
            out.append(f'<path class="grid" d="M{at_x(x):.1f} {_TOP}V{bottom}"/>')
            out.append(
                f'<text x="{at_x(x):.1f}" y="{bottom + 16}" text-anchor="middle">{x:g}</text>'
            )
        for y in _ticks(y_low, y_high):
            out.append(f'<path class="grid" d="M{_LEFT} {at_y(y):.1f}H{right}"/>')
            out.append(
                f'<text x="{_LEFT - 6}" y="{at_y(y) + 4:.1f}" text-anchor="end">{y:g}</text>'
            )
        out.append(f'<path class="axis" d="M{_LEFT} {_TOP}V{bottom}H{right}"/>')
        middle = (_TOP + bottom) / 2
        out.append(
            f'<text x="{(_LEFT + right) / 2}" y="{HEIGHT - 12}" text-anchor="middle">'
            f"{escape(self.x_label)}</text>"
        )
        out.append(
            f'<text x="16" y="{middle}" text-anchor="middle" '
            f'transform="rotate(-90 16 {middle})">{escape(self.y_label)}</text>'
        )
        for k, line in enumerate(self.lines):
            shown = [
                (at_x(x), at_y(y))
                for x, y in zip(line.xs, line.ys, strict=True)
                if x_low <= x <= x_high and y_low <= y <= y_high
            ]
            out.append(_curve(shown, k))
            out.append(_legend(line, k))
        for mark in self.marks:
            x, y = at_x(mark.x), at_y(mark.y)
            out.append(f'<path class="mark" d="M{x - 5:.1f} {y:.1f}h10m-5-5v10"/>')
            side, anchor = (-8, "end") if x > 0.7 * WIDTH else (8, "start")
            out.append(
                f'<text x="{x + side:.1f}" y="{y - 6:.1f}" text-anchor="{anchor}">'
                f"{escape(mark.text)}</text>"
            )
        return "\n".join(out)


def write(path: Path, plots: Sequence[Plot]) -> None:
    """Write the plots below each other into one SVG file at `path`."""
    height = HEIGHT * len(plots)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" role="img">',
        _STYLE,
    ]
    for k, plot in enumerate(plots):
        parts.append(f'<g transform="translate(0 {k * HEIGHT})">\n{plot.elements()}\n</g>')
    path.write_text("\n".join([*parts, "</svg>\n"]), encoding="utf-8")


def _widened(values: Sequence[float], share: float) -> tuple[float, float]:
    low, high = min(values), max(values)
    room = share * (high - low) or (0.5 if low == high else 0.0)
    return low - room, high + room


def _ticks(low: float, high: float) -> list[float]:
    # Round numbers, four to nine of them.
    raw = (high - low) / 6
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(power * m for m in (1, 2, 5, 10) if power * m >= raw)
    first = math.ceil(low / step - 1e-9)
    last = math.floor(high / step + 1e-9)
    return [round(k * step, 10) for k in range(first, last + 1)]


def _curve(points: list[tuple[float, float]], k: int) -> str:
    colour = _COLOURS[k % len(_COLOURS)]
    every = max(1, math.ceil(len(points) / _MOST_POINTS))
    kept = points[:-1:every] + points[-1:]
    way = " ".join(f"{x:.1f},{y:.1f}" for x, y in kept)
    dash = _DASHES[k % len(_DASHES)]
    return f'<polyline class="line" stroke="{colour}" stroke-dasharray="{dash}" points="{way}"/>'


def _legend(line: Line, k: int) -> str:
    x, y = WIDTH - _RIGHT - 210, _TOP + 14 + 16 * k
    colour = _COLOURS[k % len(_COLOURS)]
    dash = _DASHES[k % len(_DASHES)]
    key = f'<path class="line" stroke="{colour}" stroke-dasharray="{dash}" d="M{x} {y - 4}h24"/>'
    return f'{key}<text x="{x + 30}" y="{y}">{escape(line.name)}</text>'
