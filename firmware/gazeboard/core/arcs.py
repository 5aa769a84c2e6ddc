# Obstacle limits for a chair that drives and turns at once.
#
# Pure: integers only, no clock, no allocation. Only ever reduces. Its two axes start and stop in
# their own time, so its path is no known curve. Known are how far it travels and how far it turns
# at most until it stands (Way.stop). The newest clearance gives how far it may travel while it
# turns by so much, either first or both at once (gazelink/arcs.py): that must be at least the
# travel, margins included. Both axes are slowed down together, so that the driver's curve stays the
# same. The check covers the command, and coasting from before it.

from array import array

from gazeboard.core import limits
from gazelink import arcs
from gazelink.const import const
from gazelink.native import micropython, ptr8, ptr32

# Numbers of other files once more, as in obstacles.py; tests/firmware/test_obstacle_numbers.py.
_DRIVE = const(5)
_AUTO = const(3)
_LEVELS = const(16)
_ROWS = const(8)
_BOTH_ROWS = const(3)
_BOTH_AT = const(32)
_UNIT_MM = const(10)
_CLEAR_MS = const(300)
_BAND_MM = const(60)
_BAND_Q4 = const(48)

_PERIOD_MS = const(8)
_BLOCKED = const(-1)
_FULL = const(1000)
_ROLLS_MM_S = const(20)  # the margins cover what is slower
_TURNS_Q4_DPS = const(48)

# The state and the numbers are arrays: machine words for viper. Of each direction, as Way says:
_ROLLS = const(0)
_SPEED = const(1)
_STOP = const(2)
_OF_WAY = const(4)
# then:
_WANTED = const(16)  # which command it is; of a drive, its mode in the bits above 6
_KEY = const(17)  # bits of the directions in which the chair may move; 0: not both axes
_LEVEL = const(18)
_BETTER_MS = const(19)
_LINEAR = const(20)  # what the command asks for, permille, and the least of it
_LINEAR_LEAST = const(21)
_TURN = const(22)
_TURN_LEAST = const(23)
_AT = const(24)  # the first row that counts, and the other side's or 0
_OTHER_AT = const(25)
_COUNT = const(26)  # so many rows
_TURNS_AT = const(27)  # and their turns, in the numbers
_ALONG = const(28)  # the directions' Stoppings
_ASIDE = const(29)
_STOP_MM = const(30)  # until it stands, from where the clearance was measured
_STOP_Q4 = const(31)
_STATE_SIZE = const(32)

# The numbers: turns of the rows, what the settings let out, and of each Stopping: what holding the
# heading may turn, the creep's output, twice its speed, then by output in steps of 32 permille,
# rounded up, its stops and where slowing down begins.
_MOST_AT = const(11)
_STOPPING_AT = const(14)
_HELD = const(0)
_CREEP = const(1)
_CREEPS = const(2)
_STOPS = const(3)
_STEPS = const(33)
_OF_STOPPING = const(69)


class Arcs:
    # settings: a Settings; stopping: Obstacles' eight Stoppings. configure() again when they
    # change.

    def __init__(self, settings, stopping):
        self.blocked = False  # both axes are asked for, or roll on, and must not
        self.linear_cap = _FULL  # most output of each axis, permille
        self.turn_cap = _FULL
        self.state = array("i", [0] * _STATE_SIZE)
        self.configure(settings, stopping)

    # Not in the tick.
    def configure(self, settings, stopping):
        numbers = [16 * turn for turn in arcs.TURNS_DEG + arcs.BOTH_TURNS_DEG]
        most_turn = max(settings.turn_permille, settings.step_turn_permille)
        numbers += [settings.linear_permille, settings.turn_permille, most_turn]
        for s in stopping:
            numbers += [s.speed(settings.hold_permille), s.permille[0], 2 * s.creep]
            speeds = [s.speed(min(_FULL, 32 * step)) for step in range(_STEPS)]
            numbers += [s.stop(v) for v in speeds]
            numbers += [s.stop(v) + v * limits.ARC_AHEAD_MS // 1000 for v in speeds]
        self._numbers = array("i", numbers)

    # What the chair may be doing in one direction.
    @micropython.viper
    def feel(self, at: int, way):
        s = ptr32(self.state)
        at *= _OF_WAY
        s[at + _ROLLS] = int(way.rolls)
        s[at + _SPEED] = int(way.speed)
        s[at + _STOP] = int(way.stop)

    # All eight ms, and when the command changes. `trusted`: 4 or 0, as the Stoppings lie.
    @micropython.native
    def judge(self, i, trusted, age_ms, bypass):
        if not self._rolling(trusted):
            self.blocked = False
            self.linear_cap = _FULL
            self.turn_cap = _FULL
            return
        self._ask(i, trusted)
        self._weigh(i, age_ms)
        self._permit(bypass and self._slow(trusted))

    # A clearance has come that is nearer than it takes to stop.
    @micropython.native
    def block(self):
        s = self.state
        s[_LEVEL] = _BLOCKED
        s[_BETTER_MS] = 0
        self._permit(0)

    # Each tick: is this another command?
    @micropython.viper
    def changed(self, i) -> int:
        s = ptr32(self.state)
        wanted = int(i.verb)
        if wanted == _DRIVE:
            linear = int(i.linear_permille)
            turn = int(i.turn_permille)
            if linear > 0:
                wanted += 8
            elif linear < 0:
                wanted += 16
            if turn > 0:
                wanted += 32
            elif turn < 0:
                wanted += 64
            wanted += int(i.mode) << 7
        if wanted == s[_WANTED]:
            return 0
        s[_WANTED] = wanted
        return 1

    # Finds the directions in which the chair may move: commanded, or rolling on. Returns 1 when
    # both axes are among them. A command of one axis counts as straight, or on the spot, within
    # what holding the heading may turn.
    @micropython.viper
    def _rolling(self, trusted: int) -> int:
        s = ptr32(self.state)
        n = ptr32(self._numbers)
        wanted = s[_WANTED]
        key = wanted >> 3 & 15
        if key == 0:
            key = (1 << (wanted & 7)) >> 1 & 15
        if wanted:
            what = _ROLLS
            left = _STOPPING_AT + _OF_STOPPING * (2 + trusted) + _HELD
            turns_left = n[left]
            turns_right = n[left + _OF_STOPPING]
            if key & 3 and key & 12:
                what = _SPEED
                turns_left = _TURNS_Q4_DPS
                turns_right = _TURNS_Q4_DPS
            if s[what] > _ROLLS_MM_S:
                key |= 1
            if s[_OF_WAY + what] > _ROLLS_MM_S:
                key |= 2
            if s[2 * _OF_WAY + what] > turns_left:
                key |= 4
            if s[3 * _OF_WAY + what] > turns_right:
                key |= 8
        if key & 3 == 0 or key & 12 == 0:
            s[_KEY] = 0
            return 0
        if key != s[_KEY]:
            s[_KEY] = key
            s[_LEVEL] = _LEVELS  # not judged yet
        return 1

    # The command's outputs, the least of them, and which rows of the clearance count.
    @micropython.viper
    def _ask(self, i, trusted: int):
        s = ptr32(self.state)
        n = ptr32(self._numbers)
        key = s[_KEY]
        verb = int(i.verb)
        linear = 0
        turn = 0
        along = int(key & 3 == 2)
        aside = 2 + int(key & 12 == 8)
        if verb == _DRIVE:
            linear = int(i.linear_permille)
            turn = int(i.turn_permille)
            if linear < 0:
                linear = 0 - linear
                along = 1
            if turn < 0:
                turn = 0 - turn
                aside = 3
            if linear > n[_MOST_AT]:
                linear = n[_MOST_AT]
            if turn > n[_MOST_AT + 1]:
                turn = n[_MOST_AT + 1]
        elif verb <= 2:
            linear = n[_MOST_AT]
            along = verb - 1
        else:
            turn = n[_MOST_AT + 2]
            aside = verb - 1
        cap = int(i.cap_permille)
        if linear > cap:
            linear = cap
        if turn > cap:
            turn = cap
        s[_OTHER_AT] = 0
        if key & 3 == 3 or key & 12 == 12:
            s[_AT] = _BOTH_AT
            if key & 3 == 2:
                s[_AT] = _BOTH_AT + _BOTH_ROWS
            if key & 3 == 3:
                s[_OTHER_AT] = _BOTH_AT + _BOTH_ROWS
            s[_COUNT] = _BOTH_ROWS
            s[_TURNS_AT] = _ROWS
        else:
            s[_AT] = _ROWS * (along + 2 * (aside - 2))
            s[_COUNT] = _ROWS
            s[_TURNS_AT] = 0
        along = _STOPPING_AT + _OF_STOPPING * (along + trusted)
        aside = _STOPPING_AT + _OF_STOPPING * (aside + trusted)
        # The slowest: neither beyond its creep, in the command's proportion.
        share = 0
        more = 64
        while more:
            trial = share + more
            if trial <= 64 and (linear * trial) >> 6 <= n[along + _CREEP]:
                if (turn * trial) >> 6 <= n[aside + _CREEP]:
                    share = trial
            more >>= 1
        s[_LINEAR] = linear
        s[_LINEAR_LEAST] = (linear * share) >> 6
        s[_TURN] = turn
        s[_TURN_LEAST] = (turn * share) >> 6
        s[_ALONG] = along + _STOPS
        s[_ASIDE] = aside + _STOPS

    # 1: the clearance is nearer than it takes to stop, or a lidar is blind there.
    @micropython.viper
    def too_near(self, i, age_ms: int) -> int:
        s = ptr32(self.state)
        n = ptr32(self._numbers)
        key = s[_KEY]
        if key == 0:
            return 0
        ways = ptr8(i.clearance_arcs)
        stop_mm = 0
        stop_q4 = 0
        speed = 0
        turning = 0
        at = 0
        while at < 4:
            if key >> at & 1:
                own = s[at * _OF_WAY + _STOP]
                moves = s[at * _OF_WAY + _SPEED]
                if at < 2:
                    if own > stop_mm:
                        stop_mm = own
                    if moves > speed:
                        speed = moves
                else:
                    if own > stop_q4:
                        stop_q4 = own
                    if moves > turning:
                        turning = moves
            at += 1
        # What it may have moved since, rounded up; 2400 * 60000 stays in 31 bits.
        stop_mm += speed * age_ms // 1000 + 1
        stop_q4 += turning * age_ms // 1000 + 1
        s[_STOP_MM] = stop_mm
        s[_STOP_Q4] = stop_q4
        row = 0
        while row < s[_COUNT] and n[s[_TURNS_AT] + row] < stop_q4:
            row += 1
        near = 1
        if row < s[_COUNT] and ways[s[_AT] + row] * _UNIT_MM >= stop_mm:
            near = 0
            if s[_OTHER_AT] and ways[s[_OTHER_AT] + row] * _UNIT_MM < stop_mm:
                near = 1
        views = int(i.clearance_arc_views)
        if s[_WANTED] >> 7 == _AUTO:
            views |= views >> 4  # unseen: blocked for it, too
        views &= 15
        at = 0
        while views:
            if views & 1 and key >> (at & 1) & 1 and key >> (2 + (at >> 1)) & 1:
                near = 1
            views >>= 1
            at += 1
        return near

    # The level that the clearance permits: down at once, up after CLEAR_MS of a better view.
    @micropython.viper
    def _weigh(self, i, age_ms: int):
        s = ptr32(self.state)
        n = ptr32(self._numbers)
        ways = ptr8(i.clearance_arcs)
        key = s[_KEY]
        level = s[_LEVEL]
        if int(self.too_near(i, age_ms)):
            s[_LEVEL] = _BLOCKED
            s[_BETTER_MS] = 0
            return
        ceiling = _LEVELS
        views = int(i.clearance_arc_views) >> 4
        at = 0
        while views:
            if views & 1 and key >> (at & 1) & 1 and key >> (2 + (at >> 1)) & 1:
                ceiling = 0
            views >>= 1
            at += 1
        count = s[_COUNT]
        turns_at = s[_TURNS_AT]
        at = s[_AT]
        other_at = s[_OTHER_AT]
        # As if the command were put out now, since the clearance was measured.
        found = _BLOCKED
        better = _BLOCKED
        trial = ceiling
        while trial >= 0 and better < 0:
            linear = s[_LINEAR_LEAST] + (((s[_LINEAR] - s[_LINEAR_LEAST]) * trial) >> 4)
            turn = s[_TURN_LEAST] + (((s[_TURN] - s[_TURN_LEAST]) * trial) >> 4)
            mm = ((linear + 31) >> 5) + s[_ALONG]
            q4 = ((turn + 31) >> 5) + s[_ASIDE]
            if trial:
                mm += _STEPS
                q4 += _STEPS
            mm = n[mm]
            q4 = n[q4]
            # An axis that is not commanded rolls on.
            if s[_LINEAR] == 0:
                mm = s[_STOP_MM]
            if s[_TURN] == 0:
                q4 = s[_STOP_Q4]
            row = 0
            while row < count and n[turns_at + row] < q4:
                row += 1
            if row < count and ways[at + row] * _UNIT_MM >= mm:
                if other_at == 0 or ways[other_at + row] * _UNIT_MM >= mm:
                    if found < 0:
                        found = trial
                    mm += _BAND_MM
                    q4 += _BAND_Q4
                    while row < count and n[turns_at + row] < q4:
                        row += 1
                    if row < count and ways[at + row] * _UNIT_MM >= mm:
                        if other_at == 0 or ways[other_at + row] * _UNIT_MM >= mm:
                            better = trial
            trial -= 1
        if level > found:
            level = found
            s[_BETTER_MS] = 0
        elif better > level:
            s[_BETTER_MS] += _PERIOD_MS
            if s[_BETTER_MS] >= _CLEAR_MS:
                s[_BETTER_MS] = 0
                level = better
        else:
            s[_BETTER_MS] = 0
        s[_LEVEL] = level

    # Slow enough for a bypass?
    @micropython.viper
    def _slow(self, trusted: int) -> int:
        s = ptr32(self.state)
        n = ptr32(self._numbers)
        at = 0
        while at < 4:
            creeps = n[_STOPPING_AT + _OF_STOPPING * (at + trusted) + _CREEPS]
            if s[at * _OF_WAY + _SPEED] > creeps:
                return 0
            at += 1
        return 1

    # A bypass makes it creep, and nothing blocked.
    @micropython.native
    def _permit(self, bypass):
        s = self.state
        level = 0 if bypass else s[_LEVEL]
        linear = s[_LINEAR_LEAST]
        turn = s[_TURN_LEAST]
        # Blocked, too, where creep is no output at all: else the chair would stand for no reason.
        self.blocked = level < 0 or (level == 0 and linear == 0 and turn == 0)
        if self.blocked:
            linear = turn = 0
        else:
            linear += (s[_LINEAR] - linear) * level >> 4
            turn += (s[_TURN] - turn) * level >> 4
        self.linear_cap = linear
        self.turn_cap = turn
