# Data shared by service loop and tick: a double buffer down, counters up. No allocation.

from gazelink import arcs


class Inputs:
    # Everything the tick reads. Counters change when their value is new; 16 bits, any difference
    # counts. stop_edge: the newest press when the last stop came. reset_count: the caretaker's.

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
    )

    def __init__(self):
        for name in self.FIELDS:
            setattr(self, name, 0)
        # Bytes of gazelink/arcs.py, never changed while they can be read: see Incoming.
        self.clearance_arcs = bytearray(arcs.SIZE)

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


class Inbox:
    # The service loop fills `back`, then publish() makes it `front` by one assignment; the tick,
    # which interrupts the service loop and never the other way round, reads `front` only.

    def __init__(self):
        self.front = Inputs()
        self.back = Inputs()
        self._dirty = False

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
            old = self.front
            self.front = self.back
            self.back = old
            old.copy_from(self.front)


class Outbox:
    # What the tick counts, for the service loop; `ticks` is advanced last.

    def __init__(self):
        self.ticks = 0  # the board's clock: ticks since start, 30 bits
        self.relay_closed = False
        self.tick_max_us = 0  # since the service loop last set it to 0
        self.late_ticks = 0
