"""A kind in the daemon whose person first chooses a spot in the camera's picture.

A spot starts nothing: its process reports what it would do there, the pages show it, and only while
that is valid is there a mode to press. Each spot has its own mode, so a press never starts a motion
to an earlier spot.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gazechair.config.settings import LidarConfig
from gazechair.driving.mode_context import ModeContext
from gazechair.producers import exchange
from gazechair.producers.places import Target
from gazechair.producers.service import ProducerService

At = tuple[float, float]
_MOST = 100_000  # so that a mode's name stays short


class SpotService(ProducerService):
    """One kind. Its targets are tiles, by name; a tile's `more` has the picture's "aspect"
    and "top", as sent to the pages."""

    _number = 0
    _ask: Mapping[str, Any] | None = None
    _tile = ""
    _answer: exchange.Record | None = None

    def choose(self, tile: str, at: At | None, at_s: float) -> bool:
        """Choose a spot for that tile, as fractions of the picture's width and height; None:
        discard it. False: the tile is not of this kind, or does not work now."""
        with self._lock:
            settings = self._settings()
            if tile not in self._shown or settings is None or not self._lives:
                return False
            self.forget()
            if at is not None:
                self._number = self._number % _MOST + 1
                sees = self._port.mode_context().view["backward"] != "unseen"
                rest = {"at": at, "settings": dict(settings), "may_reverse": sees, "at_s": at_s}
                self._ask, self._tile = {"number": self._number, **rest}, tile
            return True

    def forget(self, stopped: bool = True) -> None:
        """Discard the spot; a press for it ends: stopped, or because it no longer works."""
        with self._lock:
            if self._ask is not None:
                self._ask = self._answer = None
                self._message_s = float("-inf")
                self._offer(stopped)

    def spot(self) -> dict[str, Any] | None:
        """For the pages: the spot, its result, and the mode that can be pressed."""
        with self._lock:
            if self._ask is None:
                return None
            answer = self._answer
            shown = {} if answer is None else dict(answer.shown)
            return {
                **shown,
                "kind": self.kind,
                "tile": self._tile,
                "mode": self._mode if self._mode in self._offered else "",
                "at": shown.get("at", list(self._ask["at"])),
                "state": "thinks" if answer is None else answer.state,
                "reason": "" if answer is None else answer.reason,
            }

    def rows(self) -> list[dict[str, Any]]:
        """Its tiles: not modes; they open the choice of a spot."""
        none = {"aspect": 1.0, "top": 0.0}
        pictures = {tile: target.more for tile, target in self._shown.items()}
        return [
            {**row, "kind": "spot", "of": self.kind, **none, **pictures.get(row["name"], {})}
            for row in super().rows()
        ]

    def renew(self, lidars: tuple[LidarConfig, ...]) -> None:
        """As InboxService.renew: also starts a new process."""
        self.forget(stopped=False)
        super().renew(lidars)

    @property
    def _mode(self) -> str:
        return f"{self._tile}-{self._number}"

    def _choices(self) -> Mapping[str, Target]:
        ready = self.rides or (self._answer is not None and self._answer.state == "ready")
        target = self._shown.get(self._tile)
        if self._ask is None or not ready or target is None:
            return {}
        more = {**target.more, "ask": self._ask["number"]}
        return {self._mode: Target(target.name, target.icon, more, target.english)}

    def _follow(self, context: ModeContext, now_s: float) -> None:
        if self._tile not in self._shown:
            self.forget(stopped=False)
        elif not context.armed:
            self.forget()
        super()._follow(context, now_s)

    def _extra_fields(self) -> Mapping[str, Any]:
        return {"ask": self._ask}

    def _take_answer(self, record: exchange.Record) -> None:
        if self._ask is None or self.rides or record.ask != self._ask["number"]:
            return
        before, self._answer = self._answer, record
        if before is None or before.state != record.state:
            self._offer()

    def _child_lost(self) -> None:
        with self._lock:
            self._ask = self._answer = None  # the new process does not know the spot
            super()._child_lost()
