# Ages of the safety core's inputs, durations of conditions, and the faults that follow from them.
# Counted in ticks of 1 ms, saturating. Pure: no clock, no allocation, integers.
#
# All are in one array of machine words for viper: as attributes, each would cost the tick a hundred
# instructions to read.

from array import array

from gazeboard.core import limits
from gazelink import codes
from gazelink.const import const
from gazelink.native import micropython, ptr32

# Indices of the words. Ages of the inputs, ms:
HOST = const(0)
SERVICE = const(1)
CLEARANCE = const(2)
HEADING = const(3)
# How long something has lasted, ms:
IDLE = const(4)  # nothing commanded
CLOSED = const(5)  # the relay's contact
OPEN = const(6)
OFF = const(7)  # the enable line
STEADY = const(8)  # no tick late
BUTTON = const(9)  # pressed
_GROWING = const(10)  # those above grow by themselves
NEUTRAL = const(10)  # read back
ARMING = const(11)
TTL = const(12)  # what is left of the command
# Counters of the inputs as last seen:
HOST_COUNT = const(13)
SERVICE_COUNT = const(14)
CLEARANCE_COUNT = const(15)
HEADING_COUNT = const(16)
COMMAND_COUNT = const(17)
SESSION_COUNT = const(18)
DISARM_COUNT = const(19)
ARM_COUNT = const(20)
RESET_COUNT = const(21)
STOP_COUNT = const(22)
EMERGENCY_COUNT = const(23)
PRESS_COUNT = const(24)
SUPERVISION_COUNT = const(25)
ARMS = const(26)  # orders to arm that came with this tick
PRESSES = const(27)  # presses that came with this tick
# What is fitted and what boot found:
STANDING = const(28)  # faults that stand until the next boot
SIMULATED = const(29)  # the board: it takes any source of obstacle data
RELAY_FITTED = const(30)  # a contact tells what the relay does
CONTACT = const(31)  # with none fitted: bit 0 it was open for a while, bit 1 closed
# Of an auto motion:
SUPERVISED = const(32)  # what is left of its supervision, ms
SUPERVISION_MOST = const(33)  # so long it lasts, from the settings; before them, not at all
_WORDS = const(34)
_AUTO = const(3)  # codes.AUTO; a test compares

LATCHED = 0
for _row in codes.FAULTS:
    if _row[3]:
        LATCHED |= 1 << _row[0]

# Bits of what count() returns.
SESSION = const(1)
DISARM = const(2)
ARM = const(4)
RESET = const(8)
STOPPED = const(16)
EMERGENCY = const(32)
PRESSED = const(64)  # the button at the chair, for long enough


class Ages:
    # At boot nothing has been received. A button that is pressed at boot is stuck: no reset.

    def __init__(self):
        self.words = w = array("i", [0] * _WORDS)
        for at in (HOST, SERVICE, CLEARANCE, HEADING, STEADY, BUTTON):
            w[at] = limits.AGE_MAX_MS

    # One tick. `i` is an Inputs; missed_ms passed without a tick before it: they count in every
    # age, also in those that begin now, but in no duration that proves something. Returns which
    # orders are new, in bits.
    @micropython.viper
    def count(
        self, i, relay_closed: int, button_pressed: int, late: int, on: int, missed_ms: int
    ) -> int:
        w = ptr32(self.words)
        most_ms = int(limits.AGE_MAX_MS)
        at = 0
        while at < _GROWING:
            if w[at] < most_ms:
                w[at] += 1
            at += 1
        count = int(i.host_count)
        if count != w[HOST_COUNT]:
            w[HOST_COUNT] = count
            w[HOST] = 0
        count = int(i.service_count)
        if count != w[SERVICE_COUNT]:
            w[SERVICE_COUNT] = count
            w[SERVICE] = 0
        count = int(i.clearance_count)
        if count != w[CLEARANCE_COUNT]:
            w[CLEARANCE_COUNT] = count
            w[CLEARANCE] = int(i.clearance_age_ms)
        count = int(i.heading_count)
        if count != w[HEADING_COUNT]:
            w[HEADING_COUNT] = count
            w[HEADING] = 0
        ttl_ms = w[TTL]
        count = int(i.command_count)
        if count != w[COMMAND_COUNT]:
            w[COMMAND_COUNT] = count
            ttl_ms = int(i.ttl_ms)
            if int(i.mode) == _AUTO:
                longest_ms = int(limits.AUTO_TTL_MS)
            else:
                longest_ms = int(limits.COMMAND_TTL_MS)
            if ttl_ms > longest_ms:
                ttl_ms = longest_ms
            ttl_ms -= int(limits.MARGIN_MS)
        else:
            ttl_ms -= 1
        supervised_ms = w[SUPERVISED]
        count = int(i.supervision_count)
        if count != w[SUPERVISION_COUNT]:
            w[SUPERVISION_COUNT] = count
            supervised_ms = w[SUPERVISION_MOST] - int(i.supervision_age_ms)
        else:
            supervised_ms -= 1
        if missed_ms:
            ttl_ms -= missed_ms
            supervised_ms -= missed_ms
            at = 0
            while at <= HEADING:
                w[at] += missed_ms
                if w[at] > most_ms:
                    w[at] = most_ms
                at += 1
        if ttl_ms < 0:
            ttl_ms = 0
        w[TTL] = ttl_ms
        if supervised_ms < 0:
            supervised_ms = 0
        w[SUPERVISED] = supervised_ms
        count = int(i.press_count)
        w[PRESSES] = (count - w[PRESS_COUNT]) & 0xFFFF
        w[PRESS_COUNT] = count
        if ttl_ms and int(i.verb) != int(codes.STOP):
            w[IDLE] = 0
        if relay_closed:
            w[OPEN] = 0
        else:
            w[CLOSED] = 0
        if late:
            w[STEADY] = 0
        if on:
            w[OFF] = 0
        if not button_pressed:
            w[BUTTON] = 0
        found = 0
        count = int(i.session_count)
        if count != w[SESSION_COUNT]:
            w[SESSION_COUNT] = count
            found = SESSION
        count = int(i.disarm_count)
        if count != w[DISARM_COUNT]:
            w[DISARM_COUNT] = count
            found |= DISARM
        count = int(i.arm_count)
        if count != w[ARM_COUNT]:
            w[ARMS] = (count - w[ARM_COUNT]) & 0xFFFF
            w[ARM_COUNT] = count
            found |= ARM
        count = int(i.reset_count)
        if count != w[RESET_COUNT]:
            w[RESET_COUNT] = count
            found |= RESET
        count = int(i.stop_count)
        if count != w[STOP_COUNT]:
            w[STOP_COUNT] = count
            found |= STOPPED
        count = int(i.emergency_count)
        if count != w[EMERGENCY_COUNT]:
            w[EMERGENCY_COUNT] = count
            found |= EMERGENCY
        if w[BUTTON] == int(limits.RESET_PRESS_MS):
            found |= PRESSED
        return found

    # All fault bits of this tick: each condition of the faults table, in one place. A reset clears
    # the latched ones first, so that a cause which stands or comes in this very tick is not lost.
    # `old` are the faults, `state` the state before.
    @micropython.viper
    def faults(self, i, old: int, state: int, emergency: int, reset: int) -> int:
        w = ptr32(self.words)
        margin_ms = int(limits.MARGIN_MS)
        faults = w[STANDING]
        if reset:
            w[CONTACT] = 0
        else:
            faults |= old & int(LATCHED)
        if w[HOST] >= int(limits.HOST_SILENT_MS) - margin_ms:
            faults |= 1 << int(codes.HOST_SILENT)
        if w[SERVICE] >= int(limits.SERVICE_STALLED_MS) - margin_ms:
            faults |= 1 << int(codes.SERVICE_STALLED)
        limit_ms = int(limits.CLEARANCE_OLD_MS)
        if old & (1 << int(codes.OBSTACLE_DATA_OLD)):
            limit_ms = int(limits.CLEARANCE_FRESH_MS)
        if w[CLEARANCE] >= limit_ms - margin_ms:
            faults |= 1 << int(codes.OBSTACLE_DATA_OLD)
        elif w[SIMULATED] == 0 and int(i.clearance_source) != int(codes.REAL):
            faults |= 1 << int(codes.SIMULATED_SOURCE)
        faults |= int(i.heading_faults) & int(codes.HEADING_FAULTS)
        faults |= int(i.service_faults)
        if w[HEADING] >= int(limits.HEADING_OLD_MS) - margin_ms:
            faults |= 1 << int(codes.HEADING_BUS)
        if int(i.tilted):
            faults |= 1 << int(codes.TILT)
        if int(i.calibrated) == 0:
            faults |= 1 << int(codes.CALIBRATION)
        if w[STEADY] < int(limits.TICK_STEADY_MS):
            faults |= 1 << int(codes.TICK_STALLED)
        if emergency:
            faults |= 1 << int(codes.EMERGENCY)
        # The relay's contact.
        if w[RELAY_FITTED] == 0:
            # The settings say that none is fitted, so no contact may move.
            if w[OPEN] >= int(limits.RELAY_RELEASE_MS):
                w[CONTACT] |= 1
            elif w[CLOSED] >= int(limits.RELAY_RELEASE_MS):
                w[CONTACT] |= 2
            if w[CONTACT] == 3:
                faults |= 1 << int(codes.RELAY_UNEXPECTED)
        elif state == int(codes.ARMED):
            if w[OPEN] >= int(limits.RELAY_RELEASE_MS):
                faults |= 1 << int(codes.RELAY_OPEN)
        elif state == int(codes.ARMING):
            if w[ARMING] >= int(limits.RELAY_CLOSE_MS) and w[CLOSED] == 0:
                faults |= 1 << int(codes.RELAY_OPEN)
        elif w[CLOSED] >= int(limits.RELAY_STUCK_MS) and w[OFF] >= int(limits.RELAY_STUCK_MS):
            faults |= 1 << int(codes.RELAY_STUCK)
        elif w[OPEN] < int(limits.RELAY_CLEAR_MS) or w[OFF] < int(limits.RELAY_CLEAR_MS):
            # Remains until the contact has been open, as it should be, for a while.
            faults |= old & (1 << int(codes.RELAY_OPEN) | 1 << int(codes.RELAY_STUCK))
        return faults
