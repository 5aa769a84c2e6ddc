"""What ends a motion that nobody holds, from the promises' text (P17-P20), for the oracle."""

from __future__ import annotations

from gazelink import codes
from gazeprove.fuzz_facts import MS, Facts
from gazeprove.fuzz_host import Sent


class AutoFacts(Facts):
    """What went in, and what of it an auto motion depends on."""

    def _auto_ends(self, command: Sent, moved: bool, now: int) -> str:
        """What ends an auto motion besides what ends any."""
        if command.fields["verb"] != codes.DRIVE:
            return "P19: auto, and no drive"
        edge, seen_us = self.watched
        if edge != command.fields["edge"]:
            return "P18: nobody watches this press"
        if now - seen_us > self._stretch(self.rules.supervision_ms * MS, now) + MS:
            return "P18: nobody watches any more"
        if moved and now - self.step[1] > self.late(self.rules.auto_limit_s * 1000, now):
            return "P20: longer than its limit"
        return ""

    def _waits(self, command: Sent, cause: str, now: int) -> bool:
        """An auto motion that an obstacle overrules goes on when that passes within 10 s."""
        if command.fields["mode"] != codes.AUTO or not cause.startswith(("P5", "P19")):
            return False
        if self.waits_us < 0:
            self.waits_us = now
        return now - self.waits_us <= self.late(10_000, now)

    def _stretch(self, us: int, now: int) -> int:
        return us if now - self.slow_us > 2_000_000 else us * 105 // 100 + self.period_us
