"""The report of a benchmark: figures with their limits, as a table or JSON; and distributions."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field

_BAR = 40


@dataclass(frozen=True)
class Figure:
    """One measured number. `limit`: its maximum (None: for information only)."""

    name: str
    value: float
    unit: str
    limit: float | None = None
    at_least: bool = False
    """True: `limit` is its minimum."""

    @property
    def ok(self) -> bool:
        """True if it keeps its limit; NaN never does."""
        if self.limit is None:
            return True
        return self.value >= self.limit if self.at_least else self.value <= self.limit


@dataclass
class Report:
    """All figures of one benchmark, in reading order."""

    title: str
    figures: list[Figure] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def add(
        self,
        name: str,
        value: float,
        unit: str,
        limit: float | None = None,
        at_least: bool = False,
    ) -> None:
        """Append a figure."""
        self.figures.append(Figure(name, round(float(value), 3), unit, limit, at_least))

    def note(self, text: str) -> None:
        """Append a line of explanation."""
        self.notes.append(text)

    @property
    def ok(self) -> bool:
        """True if every figure keeps its limit."""
        return all(figure.ok for figure in self.figures)

    def table(self) -> str:
        """The report as a table for people."""
        width = max(len(figure.name) for figure in self.figures)
        lines = [self.title, ""]
        for figure in self.figures:
            line = f"  {figure.name:<{width}}  {figure.value:>12,.2f} {figure.unit:<8}"
            if figure.limit is not None:
                sign = ">=" if figure.at_least else "<="
                verdict = "ok" if figure.ok else "FALLS SHORT"
                line += f" {sign} {figure.limit:g}  {verdict}"
            lines.append(line.rstrip())
        return "\n".join([*lines, "", *self.notes]).rstrip() + "\n"

    def json(self) -> str:
        """The report as one line of JSON."""
        figures = [asdict(figure) | {"ok": figure.ok} for figure in self.figures]
        return json.dumps(
            {"title": self.title, "ok": self.ok, "figures": figures, "notes": self.notes}
        )


def percentile(values: Sequence[float], share: float) -> float:
    """The smallest value that `share` (0..1) of all values do not exceed; NaN for no values."""
    if not values:
        return float("nan")
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, max(0, int(share * len(ordered) + 0.999999) - 1))]


def histogram(values: Sequence[float], edges: Sequence[float], unit: str) -> str:
    """Counts between the edges, one bar each; values above the last edge have their own line."""
    lines = []
    low = 0.0
    for high in [*edges, float("inf")]:
        count = sum(1 for value in values if low <= value < high)
        bar = "#" * round(_BAR * count / max(1, len(values)))
        name = f"{low:g}..{high:g}" if high != float("inf") else f"over {low:g}"
        lines.append(f"    {name:>12} {unit} {count:>5}  {bar}".rstrip())
        low = high
    return "\n".join(lines)
