"""Parts of the core's tick written plainly: attributes instead of machine words.

The twins of tests/firmware/test_tick_twins.py: what the board runs must decide as these do.
"""

# mypy: ignore-errors
from gazeboard.core import ages, limits
from gazelink import codes


def older(age_ms):
    """The age one tick later."""
    return age_ms + 1 if age_ms < limits.AGE_MAX_MS else age_ms


class PlainAges:
    """Ages, and the faults they are: see gazeboard/core/ages.py."""

    def __init__(self, standing, simulated, relay_fitted):
        """Nothing was ever heard."""
        self.standing, self.simulated, self.relay_fitted = standing, simulated, relay_fitted
        self.host = self.service = self.clearance = self.heading = limits.AGE_MAX_MS
        self.steady = self.button = limits.AGE_MAX_MS
        self.idle = self.closed = self.open = self.off = self.ttl = self.contact = 0
        self.supervised = self.supervision_most = self.presses = 0
        self.seen = dict.fromkeys(
            (
                *("host", "service", "clearance", "heading", "command"),
                *("session", "disarm", "arm", "reset", "stop", "emergency"),
                *("supervision", "press"),
            ),
            0,
        )
        self.arms = 0

    def _is_new(self, i, name):
        count = getattr(i, name + "_count")
        new = count != self.seen[name]
        self.seen[name] = count
        return new

    def count(self, i, relay_closed, button_pressed, late, on, missed_ms):
        """One tick; returns which orders are new."""
        self.host = 0 if self._is_new(i, "host") else older(self.host)
        self.service = 0 if self._is_new(i, "service") else older(self.service)
        old = older(self.clearance)
        self.clearance = i.clearance_age_ms if self._is_new(i, "clearance") else old
        self.heading = 0 if self._is_new(i, "heading") else older(self.heading)
        if self._is_new(i, "command"):
            longest = limits.AUTO_TTL_MS if i.mode == codes.AUTO else limits.COMMAND_TTL_MS
            self.ttl = max(0, min(i.ttl_ms, longest) - limits.MARGIN_MS)
        elif self.ttl > 0:
            self.ttl -= 1
        if missed_ms:
            for name in ("host", "service", "clearance", "heading"):
                setattr(self, name, min(limits.AGE_MAX_MS, getattr(self, name) + missed_ms))
        self.ttl = max(0, self.ttl - missed_ms)
        if self._is_new(i, "supervision"):
            left = self.supervision_most - i.supervision_age_ms
        else:
            left = self.supervised - 1
        self.supervised = max(0, left - missed_ms)
        presses = self.seen["press"]
        self._is_new(i, "press")
        self.presses = (i.press_count - presses) & 0xFFFF
        commanded = i.verb != codes.STOP and self.ttl > 0
        self.idle = 0 if commanded else older(self.idle)
        self.closed = older(self.closed) if relay_closed else 0
        self.open = 0 if relay_closed else older(self.open)
        self.off = 0 if on else older(self.off)
        self.steady = 0 if late else older(self.steady)
        self.button = older(self.button) if button_pressed else 0
        before = self.seen["arm"]
        news = ages.SESSION if self._is_new(i, "session") else 0
        news |= ages.DISARM if self._is_new(i, "disarm") else 0
        if self._is_new(i, "arm"):
            self.arms = (i.arm_count - before) & 0xFFFF
            news |= ages.ARM
        news |= ages.RESET if self._is_new(i, "reset") else 0
        news |= ages.STOPPED if self._is_new(i, "stop") else 0
        news |= ages.EMERGENCY if self._is_new(i, "emergency") else 0
        return news | (ages.PRESSED if self.button == limits.RESET_PRESS_MS else 0)

    def faults(self, i, old, state, emergency, reset):
        """All fault bits of this tick."""
        latched = sum(1 << row[0] for row in codes.FAULTS if row[3])
        faults = self.standing if reset else old & latched | self.standing
        if self.host >= limits.HOST_SILENT_MS - limits.MARGIN_MS:
            faults |= 1 << codes.HOST_SILENT
        if self.service >= limits.SERVICE_STALLED_MS - limits.MARGIN_MS:
            faults |= 1 << codes.SERVICE_STALLED
        was_old = old & (1 << codes.OBSTACLE_DATA_OLD)
        limit = limits.CLEARANCE_FRESH_MS if was_old else limits.CLEARANCE_OLD_MS
        if self.clearance >= limit - limits.MARGIN_MS:
            faults |= 1 << codes.OBSTACLE_DATA_OLD
        elif i.clearance_source != codes.REAL and not self.simulated:
            faults |= 1 << codes.SIMULATED_SOURCE
        faults |= i.heading_faults & codes.HEADING_FAULTS | i.service_faults
        if self.heading >= limits.HEADING_OLD_MS - limits.MARGIN_MS:
            faults |= 1 << codes.HEADING_BUS
        faults |= 1 << codes.TILT if i.tilted else 0
        faults |= 0 if i.calibrated else 1 << codes.CALIBRATION
        if self.steady < limits.TICK_STEADY_MS:
            faults |= 1 << codes.TICK_STALLED
        faults |= 1 << codes.EMERGENCY if emergency else 0
        return faults | (self._relay(old, state) if self.relay_fitted else self._no_relay(reset))

    def _no_relay(self, reset):
        if reset:
            self.contact = 0
        if self.open >= limits.RELAY_RELEASE_MS:
            self.contact |= 1
        elif self.closed >= limits.RELAY_RELEASE_MS:
            self.contact |= 2
        return 1 << codes.RELAY_UNEXPECTED if self.contact == 3 else 0

    def _relay(self, old, state):
        if state == codes.ARMED:
            return 1 << codes.RELAY_OPEN if self.open >= limits.RELAY_RELEASE_MS else 0
        if state == codes.ARMING:
            late = self.arming >= limits.RELAY_CLOSE_MS and self.closed == 0
            return 1 << codes.RELAY_OPEN if late else 0
        if min(self.closed, self.off) >= limits.RELAY_STUCK_MS:
            return 1 << codes.RELAY_STUCK
        if min(self.open, self.off) < limits.RELAY_CLEAR_MS:
            return old & ((1 << codes.RELAY_OPEN) | (1 << codes.RELAY_STUCK))
        return 0

    arming = 0
