"""The enable line's charge pump and relay, with the switches at the chair: pins D2..D5."""

from __future__ import annotations

from gazesim.bank import Bank

ENABLE_PIN = 2
FEEDBACK_PIN = 3  # normally closed mirror contact to ground; high: relay closed
EMERGENCY_PIN = 4  # normally closed to ground; high: emergency
BUTTON_PIN = 5  # low: pressed

PULL_IN_MS = 5  # toggling for that long fills the pump and closes the relay
DROP_OUT_MS = 20  # that long without a toggle and it opens


class Relay:
    """Closed while the board toggles the enable line.

    Drop-out is counted in the board's own ticks while these advance (a stalled PC is not stalled
    firmware); a board whose ticks stand still for `tick_stall_s` is stopped, and the relay opens.
    """

    def __init__(self, bank: Bank, tick_stall_s: float) -> None:
        self._bank = bank
        self._enable = bank.pin(ENABLE_PIN)
        self._feedback = bank.pin(FEEDBACK_PIN)
        self._emergency = bank.pin(EMERGENCY_PIN)
        self._button = bank.pin(BUTTON_PIN)
        self._tick_stall_s = tick_stall_s
        self._last_tick = bank.tick_ms
        self._last_count = self._enable.out_count
        self._last_latch = self._enable.latch
        self._was_backwards = False
        self._still_s = 0.0
        self._quiet_ms = DROP_OUT_MS
        self._toggling_ms = 0
        self._stuck: bool | None = None
        self.closed = False
        self.press_emergency(False)
        self.press_button(False)
        self._show()

    def step(self, dt_s: float) -> None:
        """Look at the enable line after another `dt_s` seconds."""
        ticks = self._ticks()
        self._still_s = 0.0 if ticks else self._still_s + dt_s
        if self._toggled():
            self._quiet_ms = 0
            self._toggling_ms += ticks
        elif ticks:
            self._quiet_ms = min(self._quiet_ms + ticks, DROP_OUT_MS)
        if self._quiet_ms >= DROP_OUT_MS or self._still_s >= self._tick_stall_s:
            self._toggling_ms = 0
        closed = self._toggling_ms >= PULL_IN_MS if self._stuck is None else self._stuck
        if closed != self.closed:
            self.closed = closed
            self._show()

    def _ticks(self) -> int:
        """The board's ticks since the last step."""
        tick = self._bank.tick_ms
        ticks = (tick - self._last_tick) & 0xFFFFFFFF
        backwards = ticks > 0x7FFFFFFF
        if backwards and not self._was_backwards:
            # Either a counter read between two of its bytes, or a restart: the next read shows.
            self._was_backwards = True
            return 0
        self._was_backwards = False
        self._last_tick = tick
        return tick if backwards else ticks

    def _toggled(self) -> bool:
        # Writing the same level again pumps nothing: each write must have flipped the latch.
        count, latch = self._enable.out_count, self._enable.latch
        writes = (count - self._last_count) & 0xFFFFFFFF
        flipped = latch != self._last_latch
        self._last_count, self._last_latch = count, latch
        return writes > 0 and flipped == bool(writes & 1) and self._enable.mode == 1

    def _show(self) -> None:
        self._feedback.drive(None if self.closed else 0)

    def press_emergency(self, pressed: bool) -> None:
        """Open the normally-closed emergency input, or close it again."""
        self._emergency.drive(None if pressed else 0)

    def press_button(self, pressed: bool) -> None:
        """Press or release the reset button at the chair."""
        self._button.drive(0 if pressed else None)

    def set_stuck(self, closed: bool | None) -> None:
        """Fault: the contact stays closed (True) or open (False); None lets it work again."""
        self._stuck = closed
