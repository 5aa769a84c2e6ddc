"""Decodes an RPLIDAR S2's dense scan stream in bulk, and rejects damaged capsules.

A capsule is 84 bytes: 0xA0 | low nibble of the checksum, 0x50 | its high nibble, u16 start angle
in 1/64 degree (bit 15: the encoder was reset), 40 x u16 distance in mm (0 = no return). The
checksum is the XOR of bytes 2..83 (Slamtec protocol, "dense capsule"). The angles between two
starts are interpolated, so a capsule is complete only when the next one has arrived.

XOR lets 1 in 256 damaged capsules through, so a capsule must also be followed by a capsule's head,
its start must match the mirror's steady rotation, and its distances must not look damaged (an XOR
cannot detect the same bits flipped in two places).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from gazechair.base.arrays import BoolArray, FloatArray, IntArray
from gazechair.sensing.lidar.nodes import Nodes, our_angle

CAPSULE_SIZE = 84
POINTS = 40
POINT_PERIOD_S = 1.0 / 32_000.0

# Rotation from one capsule to the next, at 5 to 20 turns per second.
_STEP_DEG = (2.25, 9.0)
_STEP_TOLERANCE = 0.2  # share of `step_deg`
# Across a gap of more capsules, any two angles would agree within that tolerance.
_WIDEST_GAP = 8
_FOLLOW = 0.1  # weight of a new step in `step_deg`
_FORGET = 200  # capsules in a row that do not fit: the mirror's speed has changed
# Spikes, see _looks_hit.
_SPIKE_M = 0.1
_HIGH_M = 1.0
_SPIKE_NOISE = 5.0  # times the capsule's own median step
# Spikes may drop one capsule in 50: where isolated returns are common, spikes mean nothing.
_SPIKE_BUDGET = 4.0
_SPIKE_MEMORY = 250  # capsules: some three turns
_SPIKE_EARN = 1.0 / 50.0
_MAX_PENDING = 1 << 16
_LEFT = np.arange(POINTS - 1, -1, -1)  # nodes behind each node in its capsule
_THREE = np.arange(3)[:, None]
_SHARES = np.arange(POINTS) / POINTS  # of the angle from one capsule's start to the next one's

Rows = NDArray[np.uint8]


class CapsuleDecoder:
    """Feed it bytes as they arrive; it returns the nodes of every trusted capsule.

    Counters: `fed` bytes read, `resyncs` places where the stream had to be realigned, `dropped`
    bytes discarded there, `implausible` capsules with a good checksum at a wrong angle, `spiky`
    ones whose distances looked damaged.
    `step_deg`: the mirror's rotation from one capsule to the next, 0 before it is known.
    """

    NODE_BYTES = CAPSULE_SIZE / POINTS

    def __init__(self) -> None:
        self.fed = 0
        self.resyncs = 0
        self.dropped = 0
        self.implausible = 0
        self.spiky = 0
        self.step_deg = 0.0
        self._pending = b""
        self._at = 0  # place in the stream where the pending bytes begin
        self._searching = True
        self._waiting: tuple[Rows, IntArray, bool] | None = None  # waits for the next start angle
        self._misfits = 0
        self._spikes_left = _SPIKE_BUDGET
        self._believed = 0  # capsules evaluated so far
        self._spike_at = np.full(360, -_SPIKE_MEMORY - 1, dtype=np.int64)  # by degree: its newest
        self._last_m: FloatArray = np.zeros(1)
        self._last_deg: FloatArray | None = None  # of the newest node, by the lidar's own count

    @property
    def rate_hz(self) -> float:
        """Turns of the mirror per second, 0 before they are known."""
        return self.step_deg / 360.0 / (POINTS * POINT_PERIOD_S)

    def wants(self, turn_deg: float) -> int:
        """Bytes still needed for the nodes of the next `turn_deg`, if none is lost."""
        # The waiting capsule is the first; the last one needs its successor, and a head after that.
        capsules = math.ceil(turn_deg / self.step_deg) if self.step_deg else 1
        return max(CAPSULE_SIZE, capsules * CAPSULE_SIZE + 2 - len(self._pending))

    def feed(self, data: bytes) -> Nodes:
        """Decode the bytes left over, followed by `data`."""
        self.fed += len(data)
        buf = self._pending + data
        if len(buf) > _MAX_PENDING:
            cut = len(buf) - _MAX_PENDING
            self.dropped += cut
            self._at += cut
            buf = buf[cut:]
            self._searching = True
        rows, places, used = self._cut(np.frombuffer(buf, dtype=np.uint8))
        end = self._at + len(buf)
        self._pending = buf[used:]
        self._at += used
        if not len(rows):
            return _nodes(np.zeros(0), np.zeros((0, POINTS)), places, 0, None)
        return self._believe(rows, places, end)

    def _cut(self, octets: Rows) -> tuple[Rows, IntArray, int]:
        """Capsules with valid head, checksum and next head; their places; number of bytes used."""
        pieces: list[Rows] = []
        places: list[IntArray] = []
        at = 0
        while True:
            if self._searching:
                found, at_next = _find(octets, at)
                self.dropped += at_next - at
                at = at_next
                if not found:
                    break
                self._searching = False
            count = (len(octets) - at - 2) // CAPSULE_SIZE
            if count <= 0:
                break
            stop = at + count * CAPSULE_SIZE
            rows = octets[at:stop].reshape(-1, CAPSULE_SIZE)
            marks = np.ndarray((count + 1,), "<u2", octets, at, (CAPSULE_SIZE,))
            heads = (marks & 0xF0F0) == 0x50A0
            whole = heads[:-1] & heads[1:] & _checksum_fits(rows)
            good = count if np.count_nonzero(whole) == count else int(whole.argmin())
            pieces.append(rows[:good])
            first = self._at + at
            at += good * CAPSULE_SIZE
            places.append(np.arange(first, self._at + at, CAPSULE_SIZE, dtype=np.int64))
            if good == count:
                break
            self.resyncs += 1
            self._searching = True
        if len(pieces) == 1:
            return pieces[0], places[0], at
        if not pieces:
            return np.zeros((0, CAPSULE_SIZE), np.uint8), np.zeros(0, np.int64), at
        return np.concatenate(pieces), np.concatenate(places), at

    def _believe(self, rows: Rows, places: IntArray, end: int) -> Nodes:
        fits_before = False
        if self._waiting is not None:
            waiting_row, waiting_place, fits_before = self._waiting
            rows = np.concatenate((waiting_row, rows))
            places = np.concatenate((waiting_place, places))
        words = rows.view("<u2")
        starts_deg = ((words[:, 1] & 0x7FFF) / 64.0) % 360.0
        step, trusted = self._steps(starts_deg, places, fits_before)
        self._waiting = (rows[-1:], places[-1:], bool(trusted[-1]))
        distances_m = words[:, 2:] / 1000.0
        trusted = trusted[:-1]
        if len(trusted):
            hit = self._looks_hit(distances_m, starts_deg)
            if hit is not None:
                self.spiky += int(np.count_nonzero(hit & trusted))
                trusted &= ~hit
        if np.count_nonzero(trusted) == len(trusted):
            starts_deg, distances_m, places = starts_deg[:-1], distances_m[:-1], places[:-1]
        else:
            kept = trusted.nonzero()[0]
            starts_deg, step = starts_deg.take(kept), step.take(kept)
            distances_m, places = distances_m.take(kept, axis=0), places.take(kept)
        angles = starts_deg[:, None] + step[:, None] * _SHARES
        nodes = _nodes(angles, distances_m, places, end, self._last_deg)
        if len(angles):
            self._last_deg = angles[-1, -1:]
        return nodes

    def _steps(
        self, starts_deg: FloatArray, places: IntArray, fits_before: bool
    ) -> tuple[FloatArray, BoolArray]:
        """Steps from each capsule to the next, degrees; and which capsules fit a neighbour (of the
        last one: the one before it)."""
        steps = (starts_deg[1:] - starts_deg[:-1]) % 360.0
        count = len(steps)
        if count and int(places[-1]) - int(places[0]) == count * CAPSULE_SIZE:
            ordered = sorted(steps.tolist())
            if self._fits(ordered[0]) and self._fits(ordered[-1]):  # as nearly always
                self._follow(ordered[count // 2], count)
                return steps, np.ones(count + 1, dtype=np.bool_)
        return self._checked_steps(steps, places, fits_before)

    def _fits(self, step_deg: float) -> bool:
        """True if `step_deg` matches the mirror's rotation; False before that is known."""
        if not _STEP_DEG[0] <= step_deg <= _STEP_DEG[1]:
            return False
        return abs(step_deg - self.step_deg) <= _STEP_TOLERANCE * self.step_deg

    def _checked_steps(
        self, steps: FloatArray, places: IntArray, fits_before: bool
    ) -> tuple[FloatArray, BoolArray]:
        """As _steps, if a capsule does not fit or is missing."""
        apart = places[1:] - places[:-1]
        count = np.maximum(np.rint(apart / CAPSULE_SIZE), 1.0)
        adjacent = count == 1.0
        expected = self.step_deg or _middle(steps[adjacent & _possible(steps)])
        # Across a gap the mirror kept turning: one step for each lost capsule.
        each = (steps + 360.0 * np.rint((count * expected - steps) / 360.0)) / count
        fits = np.abs(each - expected) <= _STEP_TOLERANCE * expected
        fits &= _possible(each) & (count <= _WIDEST_GAP)
        steady = fits & adjacent
        self._follow(_middle(each[steady]), len(fits))
        left = np.concatenate(([fits_before], fits))
        trusted = left[:-1] | fits
        self.implausible += len(trusted) - int(np.count_nonzero(trusted))
        return np.where(steady, each, self.step_deg), np.concatenate((trusted, left[-1:]))

    def _follow(self, middle_deg: float, pairs: int) -> None:
        if not middle_deg:
            self._misfits += pairs
            if self._misfits > _FORGET:
                self.step_deg = 0.0
                self._misfits = 0
            return
        self._misfits = 0
        self.step_deg += (middle_deg - self.step_deg) * (_FOLLOW if self.step_deg else 1.0)

    def _looks_hit(self, distances_m: FloatArray, starts_deg: FloatArray) -> BoolArray | None:
        """For every capsule but the last, True if its distances look damaged; None: no capsule.

        Signs are one high spike or two lower ones: single distances that stand out from both
        neighbours. A thin object looks the same, but in every turn; then it is accepted.
        """
        line = np.concatenate((self._last_m, distances_m.reshape(-1)[: 1 - POINTS]))
        self._last_m = distances_m[-2, -1:]
        count = len(distances_m) - 1
        self._believed += count
        self._spikes_left = min(self._spikes_left + count * _SPIKE_EARN, _SPIKE_BUDGET)
        jumps = line[1:] - line[:-1]
        sizes = np.abs(jumps)
        height = np.minimum(sizes[:-1], sizes[1:])
        high = (height > _SPIKE_M).nonzero()[0]
        # Most are edges: both jumps go the same way, or one of the three distances is no return.
        jumped = jumps.take(high) * jumps.take(high + 1) < 0.0
        high = high.compress(jumped)
        if len(high):
            high = high.compress(line.take(high + _THREE).all(axis=0))
        if not len(high):
            return None
        stands_out = np.zeros(len(height), dtype=np.bool_)
        stands_out[high] = True
        height = (height * stands_out).reshape(-1, POINTS)
        middle = POINTS // 2
        noise_m = np.partition(sizes[:-1].reshape(-1, POINTS), middle, axis=1)[:, middle]
        spikes = height > np.maximum(_SPIKE_M, _SPIKE_NOISE * noise_m)[:, None]
        counts = np.count_nonzero(spikes, axis=1)
        hit: BoolArray = (counts >= 2) | ((counts == 1) & (height.max(axis=1) > _HIGH_M))
        angles_deg = starts_deg[:-1, None] + self.step_deg * _SHARES
        degrees = angles_deg.astype(np.int64) % 360
        highest = degrees[np.arange(len(hit)), height.argmax(axis=1)]
        known = self._believed - self._spike_at[(highest[:, None] + (-1, 0, 1)) % 360]
        self._spike_at[degrees[spikes & hit[:, None]]] = self._believed
        hit &= known.min(axis=1) > _SPIKE_MEMORY
        if np.count_nonzero(hit) > self._spikes_left:
            hit[:] = False
        self._spikes_left -= np.count_nonzero(hit)
        return hit


def _middle(values: FloatArray) -> float:
    """The median, the upper one of two; 0 for none."""
    half = len(values) // 2
    return float(np.partition(values, half)[half]) if len(values) else 0.0


def _possible(steps_deg: FloatArray) -> BoolArray:
    """True where a mirror can turn this far from one capsule to the next."""
    possible: BoolArray = (steps_deg >= _STEP_DEG[0]) & (steps_deg <= _STEP_DEG[1])
    return possible


def _heads(first: Rows, second: Rows) -> BoolArray:
    """True where a capsule may begin: pairs of octets, as many as there are of `first`."""
    second = second[: len(first)]
    heads: BoolArray = ((first & 0xF0) == 0xA0) & ((second & 0xF0) == 0x50)
    return heads


def _checksum_fits(rows: Rows) -> BoolArray:
    checksum = np.bitwise_xor.reduce(rows[:, 2:], axis=1)
    fits: BoolArray = ((rows[:, 0] & 0x0F) | ((rows[:, 1] & 0x0F) << 4)) == checksum
    return fits


def _find(octets: Rows, at: int) -> tuple[bool, int]:
    """(True, place of the next capsule with a head after it), or (False, where to continue)."""
    head = _heads(octets[:-1], octets[1:])
    for place in (np.flatnonzero(head[at:]) + at).tolist():
        behind = place + CAPSULE_SIZE
        if behind >= len(head):
            return False, place
        if head[behind] and _checksum_fits(octets[None, place:behind])[0]:
            return True, place
    return False, max(at, len(octets) - 1)


def _nodes(
    angles: FloatArray,
    distances_m: FloatArray,
    places: IntArray,
    end: int,
    last_deg: FloatArray | None,
) -> Nodes:
    """The nodes of capsules; wraps `angles` in place. `last_deg`: angle of the node before."""
    raw_deg = angles.reshape(-1)
    np.subtract(raw_deg, 360.0, out=raw_deg, where=raw_deg >= 360.0)  # always below 720
    before = raw_deg
    if len(raw_deg):
        before = np.concatenate((raw_deg[:1] if last_deg is None else last_deg, raw_deg[:-1]))
    behind = (end - places - CAPSULE_SIZE) * POINTS // CAPSULE_SIZE
    return Nodes(
        angles_deg=our_angle(raw_deg),
        distances_m=distances_m.reshape(-1),
        starts=raw_deg - before < -180.0,
        backlog=(behind[:, None] + _LEFT).reshape(-1),
    )
