# Data shared by service loop and tick: a double buffer down, counters up. No allocation.

from gazelink import arcs
from gazelink.native import micropython, ptr8, ptr32


class Inputs:
    # Everything the tick reads. Counters change when their value is new; 16 bits, any difference
    # counts. stop_edge: the newest press when the last stop came. reset_count: the caretaker's.
    # press_count: presses by anyone, a bypass included.

    FIELDS = (
        "host_count",
        "service_count",
        "session_count",
        "verb",
        "mode",
        "edge",
        "owner",
        "ttl_ms",
        "linear_permille",
        "turn_permille",
        "cap_permille",
        "pulse_ms",
        "command_count",
        "stop_count",
        "stop_edge",
        "disarm_count",
        "arm_count",
        "arm_owner",
        "reset_count",
        "emergency_count",
        "clearance_blocked",
        "clearance_unseen",
        "clearance_forward_mm",
        "clearance_backward_mm",
        "clearance_left_q4",
        "clearance_right_q4",
        "clearance_source",
        "clearance_age_ms",
        "clearance_arc_views",
        "clearance_count",
        "bypass_number",
        "bypass_ttl_ms",
        "bypass_count",
        "heading_q4",
        "rate_q4",
        "heading_faults",
        "heading_count",
        "tilted",
        "service_faults",  # what the service loop finds: bits of codes.FAULTS
        "calibrated",
        "press_count",
        "supervision_edge",
        "supervision_age_ms",
        "supervision_count",
    )

    def __init__(self):
        for name in self.FIELDS:
            setattr(self, name, 0)
        # Bytes of gazelink/arcs.py, never changed while they can be read: see Incoming.
        self.clearance_arcs = bytearray(arcs.SIZE)
        self.taken_at = -1  # the first tick that took these, when traced

    # Written out, because looping over names would be slow and getattr is no faster to read.
    def copy_from(self, o):
        self.host_count = o.host_count
        self.service_count = o.service_count
        self.session_count = o.session_count
        self.verb = o.verb
        self.mode = o.mode
        self.edge = o.edge
        self.owner = o.owner
        self.ttl_ms = o.ttl_ms
        self.linear_permille = o.linear_permille
        self.turn_permille = o.turn_permille
        self.cap_permille = o.cap_permille
        self.pulse_ms = o.pulse_ms
        self.command_count = o.command_count
        self.stop_count = o.stop_count
        self.stop_edge = o.stop_edge
        self.disarm_count = o.disarm_count
        self.arm_count = o.arm_count
        self.arm_owner = o.arm_owner
        self.reset_count = o.reset_count
        self.emergency_count = o.emergency_count
        self.clearance_blocked = o.clearance_blocked
        self.clearance_unseen = o.clearance_unseen
        self.clearance_forward_mm = o.clearance_forward_mm
        self.clearance_backward_mm = o.clearance_backward_mm
        self.clearance_left_q4 = o.clearance_left_q4
        self.clearance_right_q4 = o.clearance_right_q4
        self.clearance_source = o.clearance_source
        self.clearance_age_ms = o.clearance_age_ms
        self.clearance_arc_views = o.clearance_arc_views
        self.clearance_arcs = o.clearance_arcs
        self.clearance_count = o.clearance_count
        self.bypass_number = o.bypass_number
        self.bypass_ttl_ms = o.bypass_ttl_ms
        self.bypass_count = o.bypass_count
        self.heading_q4 = o.heading_q4
        self.rate_q4 = o.rate_q4
        self.heading_faults = o.heading_faults
        self.heading_count = o.heading_count
        self.tilted = o.tilted
        self.service_faults = o.service_faults
        self.calibrated = o.calibrated
        self.press_count = o.press_count
        self.supervision_edge = o.supervision_edge
        self.supervision_age_ms = o.supervision_age_ms
        self.supervision_count = o.supervision_count

    # All but service_count, and the arcs, as words; written out as well.
    @micropython.viper
    def as_words(self, words):
        w = ptr32(words)
        w[0] = int(self.host_count)
        w[1] = int(self.session_count)
        w[2] = int(self.verb)
        w[3] = int(self.mode)
        w[4] = int(self.edge)
        w[5] = int(self.owner)
        w[6] = int(self.ttl_ms)
        w[7] = int(self.linear_permille)
        w[8] = int(self.turn_permille)
        w[9] = int(self.cap_permille)
        w[10] = int(self.pulse_ms)
        w[11] = int(self.command_count)
        w[12] = int(self.stop_count)
        w[13] = int(self.stop_edge)
        w[14] = int(self.disarm_count)
        w[15] = int(self.arm_count)
        w[16] = int(self.arm_owner)
        w[17] = int(self.reset_count)
        w[18] = int(self.emergency_count)
        w[19] = int(self.clearance_blocked)
        w[20] = int(self.clearance_unseen)
        w[21] = int(self.clearance_forward_mm)
        w[22] = int(self.clearance_backward_mm)
        w[23] = int(self.clearance_left_q4)
        w[24] = int(self.clearance_right_q4)
        w[25] = int(self.clearance_source)
        w[26] = int(self.clearance_age_ms)
        w[27] = int(self.clearance_arc_views)
        w[28] = int(self.clearance_count)
        w[29] = int(self.bypass_number)
        w[30] = int(self.bypass_ttl_ms)
        w[31] = int(self.bypass_count)
        w[32] = int(self.heading_q4)
        w[33] = int(self.rate_q4)
        w[34] = int(self.heading_faults)
        w[35] = int(self.heading_count)
        w[36] = int(self.tilted)
        w[37] = int(self.service_faults)
        w[38] = int(self.calibrated)
        w[39] = int(self.press_count)
        w[40] = int(self.supervision_edge)
        w[41] = int(self.supervision_age_ms)
        w[42] = int(self.supervision_count)
        ways = ptr8(self.clearance_arcs)
        k = 0
        while k < int(arcs.SIZE):
            w[43 + k] = ways[k]
            k += 1


class Inbox:
    # The service loop fills `back`, then publish() makes it `front` by one assignment; the tick,
    # which interrupts the service loop and never the other way round, reads `front` only.

    def __init__(self):
        self.front = Inputs()
        self.back = Inputs()
        self._dirty = False
        self.trace = None  # learns of each replacement, while it is on

    def touch(self):
        self._dirty = True

    # Signs of life of the service loop: one atomic store each, without a copy.
    def beat(self):
        count = (self.back.service_count + 1) & 0xFFFF
        self.back.service_count = count
        self.front.service_count = count

    def publish(self):
        if self._dirty:
            self._dirty = False
            trace = self.trace
            traced = trace is not None and trace.on
            if traced:
                trace.hold()
            old = self.front
            self.front = self.back
            self.back = old
            if traced:
                trace.replaced(old, self.front)
            old.copy_from(self.front)
            old.taken_at = -1


class Outbox:
    # What the tick counts, for the service loop; `ticks` is advanced last.

    def __init__(self):
        self.ticks = 0  # the board's clock: ticks since start, 30 bits
        self.relay_closed = False
        self.tick_max_us = 0  # since the service loop last set it to 0
        self.late_ticks = 0
