# Obstacle limits: per direction free, slow or blocked, and the highest permitted output.
# Pure: one tick of 1 ms, no I/O, no clock, no allocation, integers only. Only ever reduces.
#
# The distances of the newest clearance, less what the chair may have moved since they were
# measured, are compared with the stopping distance. Less: blocked. A little more: as much output
# as leaves time to slow down. The work is spread over the ticks, an eighth each; but a new
# clearance that is too near blocks in the tick that sees it.

from array import array

from gazeboard.core import zone
from gazeboard.core.arcs import Arcs
from gazeboard.core.bypass import Bypass
from gazeboard.core.directions import ARC_BLOCKED
from gazeboard.core.speed import SpeedBound
from gazeboard.core.stopping import Stopping
from gazelink.const import const
from gazelink.native import micropython, ptr32

# Numbers of other files once more: const() puts them into the code, where looking them up in their
# module would take a fifth of this file's time. tests/firmware/test_obstacle_numbers.py compares.
_FORWARD = const(0)
_BACKWARD = const(1)
_LEFT = const(2)
_RIGHT = const(3)
_DECIDED_FREE = const(0)
_DECIDED_SLOW = const(1)
_DECIDED_BLOCKED = const(2)
_LEVELS = const(16)
_AGE_MAX_MS = const(60000)
_CLEAR_MS = const(300)
_AUTO = const(3)

_PERIOD_MS = const(8)  # each direction's turn comes round; well below any chair's dead time
_BLOCKED = const(-1)  # level below all outputs
_ALL_BLOCKED = const(15)
_BLOCKED_BITS = const(17)  # of a direction: blocked, and as creep is more than it may be
_ALL_DECIDED = const(0xAA)
# The turns of a period: forward and backward each are felt, then judged; both sides are felt at
# once and judged one after the other; then the arcs.
_FEEL_SIDES = const(4)
_JUDGE_RIGHT = const(6)
_JUDGE_ARCS = const(7)


class Way:
    # One direction. `level` is an index of Stopping.permille, or _BLOCKED.

    def __init__(self):
        self._bound = SpeedBound(_PERIOD_MS)
        self._better_ms = 0  # how long a higher level has been possible
        self.level = _BLOCKED
        self.rolls = 0  # upper bound of the speed from what was put out, units/s
        self.speed = 0  # the same, or what is measured
        self.stop = 0  # units it takes to stop from that, margin included

    # `permille` is the highest output since the last time, `measured` a speed that is seen.
    @micropython.viper
    def feel(self, stopping, permille: int, measured: int):
        speed = int(self._bound.update(stopping, permille))
        self.rolls = speed
        if measured > speed:
            speed = measured
        self.speed = speed
        # As Stopping.stop(): written out, a call is dear here.
        stop = int(stopping.margin)
        if speed:
            stop += speed * int(stopping.time_ms) // 1000
            stop += speed * speed // int(stopping.two_brake)
        self.stop = stop

    # `distance` was free `age_ms` ago; `ceiling` is the highest level that other things permit.
    # Down at once, up only after CLEAR_MS of a better view.
    @micropython.viper
    def judge(self, stopping, distance: int, age_ms: int, ceiling: int):
        begin = ptr32(stopping.begin)
        stop = int(self.stop)
        was = int(self.level)
        level = was
        distance -= int(self.speed) * age_ms // 1000
        if level > ceiling:
            level = ceiling
        if level >= 0 and (distance < stop or distance < begin[level]):
            level = _BLOCKED
            if distance >= stop:
                level = int(_level(stopping.begin, distance))
        if level < was:
            self.level = level
            self._better_ms = 0
        elif level < ceiling:
            distance -= int(stopping.band)
            if distance < stop or distance < begin[level + 1]:
                self._better_ms = 0
            else:
                better_ms = int(self._better_ms) + _PERIOD_MS
                if better_ms >= _CLEAR_MS:
                    better_ms = 0
                    level = int(_level(stopping.begin, distance))
                    if level > ceiling:
                        level = ceiling
                    self.level = level
                self._better_ms = better_ms

    # A new clearance is shorter than the stopping distance.
    @micropython.native
    def block(self):
        self.level = _BLOCKED
        self._better_ms = 0


# The highest level whose distance is there; _BLOCKED for none.
@micropython.viper
def _level(begins, distance: int) -> int:
    begin = ptr32(begins)
    low = 0
    high = _LEVELS + 1
    while low < high:
        middle = (low + high) >> 1
        if begin[middle] <= distance:
            low = middle + 1
        else:
            high = middle
    return low - 1


class Obstacles:
    # settings: a Settings; configure() again whenever they change.

    def __init__(self, settings):
        self.bypass = Bypass()
        # Bits per direction, and four above them: blocked only because it cannot creep. Then
        # ARC_BLOCKED.
        self.blocked = _ALL_BLOCKED
        self.decisions = _ALL_DECIDED  # 2 bits per direction
        self.caps = [0] * 4  # most output per direction, permille
        self.auto_caps = [0] * 4  # the same of an auto motion, which has a speed of its own
        self._bypassed = 0  # bits per direction: not blocked only because of the bypass
        self._ways = [Way() for _ in range(4)]
        # Highest output of each direction since its last turn.
        self._most = array("i", [0] * 4)
        self._phase = 0
        self._age_ms = _AGE_MAX_MS
        self._count = 0
        self._looked = False
        self._extra_ms = 0  # ticks that looking took, beyond a turn's period
        self._make_tables(settings)
        self.arcs = Arcs(settings, self._stopping)

    # Not in the tick: makes new tables.
    def configure(self, settings):
        self._make_tables(settings)
        self.arcs.configure(settings, self._stopping)

    def _make_tables(self, settings):
        self._stopping = [
            Stopping(settings, direction, trusted)
            for trusted in (False, True)
            for direction in range(4)
        ]
        # What stopping takes per direction, for the host: see gazelink/zone.py.
        self.zone = [
            zone.points(self._stopping[direction], self._stopping[4 + direction])
            for direction in range(4)
        ]

    # `ms` passed without a tick.
    @micropython.native
    def missed(self, ms):
        self._extra_ms += ms
        self._age_ms = min(_AGE_MAX_MS, self._age_ms + ms)

    # `i` is an Inputs: the newest clearance, bypass and turn rate. linear_permille, turn_permille:
    # what was put out in the tick before. armed: the chair may be driven. trusted: it turns as the
    # selected profile says. sluggish: that holds at least for how turns start.
    @micropython.native
    def step(self, i, linear_permille, turn_permille, armed, trusted, sluggish=False):
        if linear_permille or turn_permille:
            self._put_out(linear_permille, turn_permille)
        arcs = self.arcs
        judges = arcs.changed(i)
        count = i.clearance_count
        looks = count != self._count
        if looks:
            self._count = count
            self._age_ms = i.clearance_age_ms
            self._look(i)
        if judges:
            self._judge_arcs(i, trusted)
        if judges or looks:
            # Enough work for one tick; but new data in every tick must not delay the rest.
            self._looked = not self._looked
            if self._looked:
                self._extra_ms += 1
                return
        elif self._looked:
            self._looked = False
        phase = (self._phase + 1) & 7
        self._phase = phase
        if phase == _JUDGE_ARCS:
            if not judges:
                self._judge_arcs(i, trusted)
            return
        at = phase >> 1
        way = self._ways[at]
        stopping = self._stopping[at + 4 if trusted or (sluggish and at >= _LEFT) else at]
        if phase & 1 or phase == _JUDGE_RIGHT:
            self._judge(i, at, way, stopping)
            return
        most = self._most
        measured = 0
        if at == _FORWARD:
            self.bypass.step(i, armed, _PERIOD_MS + self._extra_ms)
            self._extra_ms = 0
        elif phase == _FEEL_SIDES:
            measured = i.rate_q4
        way.feel(stopping, most[at], measured)
        arcs.feel(at, way)
        most[at] = 0
        if phase == _FEEL_SIDES:
            way = self._ways[_RIGHT]
            stopping = self._stopping[_RIGHT + 4 if trusted or sluggish else _RIGHT]
            way.feel(stopping, most[_RIGHT], -measured)
            arcs.feel(_RIGHT, way)
            most[_RIGHT] = 0

    # Records the outputs of a tick.
    @micropython.viper
    def _put_out(self, linear_permille: int, turn_permille: int):
        most = ptr32(self._most)
        at = _FORWARD
        if linear_permille < 0:
            at = _BACKWARD
            linear_permille = 0 - linear_permille
        if linear_permille > most[at]:
            most[at] = linear_permille
        at = _LEFT
        if turn_permille < 0:
            at = _RIGHT
            turn_permille = 0 - turn_permille
        if turn_permille > most[at]:
            most[at] = turn_permille

    # A turn of the arcs, and whenever another command comes: before it moves anything.
    @micropython.native
    def _judge_arcs(self, i, trusted):
        arcs = self.arcs
        bypass_ms = 0 if i.mode == _AUTO else self.bypass.left_ms
        arcs.judge(i, 4 if trusted else 0, self._age_ms, bypass_ms)
        if arcs.blocked:
            self.blocked |= ARC_BLOCKED
        else:
            self.blocked &= ~ARC_BLOCKED

    # A new clearance: what it forbids is blocked in this tick.
    @micropython.native
    def _look(self, i):
        near = i.clearance_blocked & _ALL_BLOCKED
        age_ms = self._age_ms
        ways = self._ways
        way = ways[_FORWARD]
        if i.clearance_forward_mm < way.stop + way.speed * age_ms // 1000:
            near |= 1 << _FORWARD
        way = ways[_BACKWARD]
        if i.clearance_backward_mm < way.stop + way.speed * age_ms // 1000:
            near |= 1 << _BACKWARD
        way = ways[_LEFT]
        if i.clearance_left_q4 < way.stop + way.speed * age_ms // 1000:
            near |= 1 << _LEFT
        way = ways[_RIGHT]
        if i.clearance_right_q4 < way.stop + way.speed * age_ms // 1000:
            near |= 1 << _RIGHT
        near &= ~self.blocked
        if near:
            for at in range(4):
                if near & (1 << at):
                    ways[at].block()
                    if self.bypass.left_ms:
                        self._decide(at, ways[at], self._stopping[at])
                    else:  # the same decision, sooner
                        self.blocked |= 1 << at
                        self.caps[at] = 0
                        self.auto_caps[at] = 0
                        self.decisions = (
                            self.decisions & ~(3 << 2 * at) | _DECIDED_BLOCKED << 2 * at
                        )
        arcs = self.arcs
        bypassed = self.bypass.left_ms and i.mode != _AUTO
        if not (arcs.blocked or bypassed) and arcs.too_near(i, age_ms):
            arcs.block()
            self.blocked |= ARC_BLOCKED

    @micropython.native
    def _judge(self, i, at, way, stopping):
        age_ms = min(_AGE_MAX_MS, self._age_ms + 2)  # two phases
        self._age_ms = age_ms
        ceiling = _LEVELS
        if i.clearance_blocked & (1 << at):
            ceiling = _BLOCKED
        elif i.clearance_unseen & (1 << at):
            ceiling = 0
        if at == _FORWARD:
            distance = i.clearance_forward_mm
        elif at == _BACKWARD:
            distance = i.clearance_backward_mm
        elif at == _LEFT:
            distance = i.clearance_left_q4
        else:
            distance = i.clearance_right_q4
        way.judge(stopping, distance, age_ms, ceiling)
        self._decide(at, way, stopping)

    # The decision of one direction, from its level and the bypass, which makes every direction
    # creep and none blocked, unless the chair is still too fast for that.
    @micropython.native
    def _decide(self, at, way, stopping):
        level = way.level
        if self._bypassed:
            self._bypassed &= ~(1 << at)
        if self.bypass.left_ms and way.speed <= 2 * stopping.creep:
            if level < 0:
                self._bypassed |= 1 << at
            level = 0
        cap = 0
        bits = 1 << at
        if level >= 0:
            cap = stopping.permille[level]
            bits = _BLOCKED_BITS << at
        decision = _DECIDED_BLOCKED
        if cap:
            bits = 0
            decision = _DECIDED_FREE if level == _LEVELS else _DECIDED_SLOW
        self.blocked = self.blocked & ~(_BLOCKED_BITS << at) | bits
        self.caps[at] = cap
        most = stopping.auto
        self.auto_caps[at] = most if most < cap else cap
        at += at
        self.decisions = self.decisions & ~(3 << at) | (decision << at)

    # What is blocked for an auto motion: also what no lidar sees, and what a bypass permits.
    @micropython.native
    def auto_blocked(self, i):
        return self.blocked | self._bypassed | i.clearance_unseen & _ALL_BLOCKED

    # Upper bound of the speed forward or backward, mm/s.
    def speed_mm_s(self):
        return max(self._ways[_FORWARD].speed, self._ways[_BACKWARD].speed)
