"""Line plots as small SVG files: axes, lines, marks, a legend; readable on light and dark."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

WIDTH, HEIGHT = 720, 320
_LEFT, _TOP = 62, 34
_END, _FLOOR = WIDTH - 16, HEIGHT - 48  # right and lower edges of the plot
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
        axes = self._axes()
        out = [f'<text class="title" x="{_LEFT}" y="20">{escape(self.title)}</text>']
        if self.band is not None:
            low, high = max(axes.y_low, self.band[0]), min(axes.y_high, self.band[1])
            height = axes.at_y(low) - axes.at_y(high)
            out.append(
                f'<rect class="band" x="{_LEFT}" y="{axes.at_y(high):.1f}" '
                f'width="{_END - _LEFT}" height="{height:.1f}"/>'
            )
        out += axes.grid()
        out += self._labels()
        for k, line in enumerate(self.lines):
            out.append(_curve(axes.within(line), k))
            out.append(_legend(line, k))
        for mark in self.marks:
            x, y = axes.at_x(mark.x), axes.at_y(mark.y)
            out.append(f'<path class="mark" d="M{x - 5:.1f} {y:.1f}h10m-5-5v10"/>')
            side, anchor = (-8, "end") if x > 0.7 * WIDTH else (8, "start")
            out.append(
                f'<text x="{x + side:.1f}" y="{y - 6:.1f}" text-anchor="{anchor}">'
                f"{escape(mark.text)}</text>"
            )
        return "\n".join(out)

    def _axes(self) -> _Axes:
        points = [p for line in self.lines for p in zip(line.xs, line.ys, strict=True)]
        points += [(mark.x, mark.y) for mark in self.marks]
        points = [p for p in points if math.isfinite(p[0]) and math.isfinite(p[1])]
        if not points:
            raise ValueError(f"plot {self.title!r} has no finite point to show")
        x_range = self.x_range or _widened([p[0] for p in points], 0.0)
        y_range = self.y_range or _widened([p[1] for p in points], 0.05)
        return _Axes(*x_range, *y_range)

    def _labels(self) -> list[str]:
        centre, middle = (_LEFT + _END) / 2, (_TOP + _FLOOR) / 2
        below = f'<text x="{centre}" y="{HEIGHT - 12}" text-anchor="middle">'
        beside = (
            f'<text x="16" y="{middle}" text-anchor="middle" transform="rotate(-90 16 {middle})">'
        )
        return [
            f"{below}{escape(self.x_label)}</text>",
            f"{beside}{escape(self.y_label)}</text>",
        ]


@dataclass(frozen=True)
class _Axes:
    """From the plot's values to places in the picture."""

    x_low: float
    x_high: float
    y_low: float
    y_high: float

    def at_x(self, x: float) -> float:
        return _LEFT + (x - self.x_low) / (self.x_high - self.x_low) * (_END - _LEFT)

    def at_y(self, y: float) -> float:
        return _FLOOR - (y - self.y_low) / (self.y_high - self.y_low) * (_FLOOR - _TOP)

    def within(self, line: Line) -> list[tuple[float, float]]:
        """The places of the line's points, without those beyond the axes."""
        return [
            (self.at_x(x), self.at_y(y))
            for x, y in zip(line.xs, line.ys, strict=True)
            if self.x_low <= x <= self.x_high and self.y_low <= y <= self.y_high
        ]

    def grid(self) -> Iterator[str]:
        for x in _ticks(self.x_low, self.x_high):
            at = self.at_x(x)
            yield f'<path class="grid" d="M{at:.1f} {_TOP}V{_FLOOR}"/>'
            yield f'<text x="{at:.1f}" y="{_FLOOR + 16}" text-anchor="middle">{x:g}</text>'
        for y in _ticks(self.y_low, self.y_high):
            at = self.at_y(y)
            yield f'<path class="grid" d="M{_LEFT} {at:.1f}H{_END}"/>'
            yield f'<text x="{_LEFT - 6}" y="{at + 4:.1f}" text-anchor="end">{y:g}</text>'
        yield f'<path class="axis" d="M{_LEFT} {_TOP}V{_FLOOR}H{_END}"/>'


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
    x, y = _END - 210, _TOP + 14 + 16 * k
    colour = _COLOURS[k % len(_COLOURS)]
    dash = _DASHES[k % len(_DASHES)]
    key = f'<path class="line" stroke="{colour}" stroke-dasharray="{dash}" d="M{x} {y - 4}h24"/>'
    return f'{key}<text x="{x + 30}" y="{y}">{escape(line.name)}</text>'
