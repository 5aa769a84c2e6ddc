# The rule for a chair that drives and turns at once, once more in other words, against the
# firmware's: random commands, motions, ways and chairs, whose numbers often lie at a limit.

from dice import Dice
from gazeboard.core import limits
from gazeboard.core.arcs import Arcs
from gazeboard.core.shared import Inputs
from gazelink import arcs, codes

ALONG = (codes.DIR_FORWARD, codes.DIR_BACKWARD)
ASIDE = (codes.DIR_LEFT, codes.DIR_RIGHT)
ROLLS = (20, 20, 48, 48)  # a motion counts beside a command of both axes
PERIOD_MS = 8
LEVELS = 16
BLOCKED = -1


# What Arcs asks of a Stopping, in coarse steps, so that stops often end at a row's turn or way.
class Chair:
    def __init__(self, dice, turns):
        self.full = (250, 500, 1000)[dice.roll(3)] if turns else (250, 625, 1250)[dice.roll(3)]
        self.step = 16 if turns else 10
        self.margin = self.step * dice.roll(4)
        self.permille = [(0, 30, 32, 33, 100, 250)[dice.roll(6)], 999]
        self.creep = dice.roll(4) * self.full // 16
        self.ms = (100, 200, 300)[dice.roll(3)]

    def speed(self, permille):
        return (self.full * permille + 999) // 1000

    def stop(self, speed):
        return self.margin + speed * self.ms // 1000 // self.step * self.step


class Settings:
    def __init__(self, dice):
        self.linear_permille = 200 + dice.roll(801)
        self.turn_permille = 200 + dice.roll(801)
        self.step_turn_permille = 200 + dice.roll(801)
        self.hold_permille = dice.roll(200)


class Way:
    # What the chair may be doing in one direction.

    def __init__(self):
        self.rolls = self.speed = self.stop = 0

    def change(self, dice, limit):
        self.speed = (0, limit, limit + 1, dice.roll(1000), dice.roll(100))[dice.roll(5)]
        self.rolls = (0, self.speed, limit, limit + 1, 60 + dice.roll(100))[dice.roll(5)]
        self.stop = (0, dice.roll(16) * 10, dice.roll(12) * 16, dice.roll(400))[dice.roll(4)]


def as_q4(degrees):
    return [16 * deg for deg in degrees]


# How far at most until it stands, seen from where the clearance was measured.
def from_there(ways, directions, age_ms):
    moved = max(ways[at].speed for at in directions) * age_ms
    return max(ways[at].stop for at in directions) + moved // 1000 + 1


class Rule:
    def __init__(self, settings, chairs, ways):
        self.settings = settings
        self.chairs = chairs
        self.ways = ways
        self.moving = frozenset()
        self.level = BLOCKED
        self.better_ms = 0
        self.rows = None
        self.asked = (0, 0)
        self.least = (0, 0)

    # The directions in which it may move: (all of them, those commanded).
    def directions(self, i, trusted):
        if i.verb == codes.STOP:
            return frozenset(), frozenset()
        commanded = set()
        if i.verb != codes.DRIVE:
            commanded.add(i.verb - 1)
        if i.verb == codes.DRIVE and i.linear_permille:
            commanded.add(ALONG[i.linear_permille < 0])
        if i.verb == codes.DRIVE and i.turn_permille:
            commanded.add(ASIDE[i.turn_permille < 0])
        moving = set(commanded)
        for at in range(4):
            way = self.ways[at]
            if len(commanded) == 2:
                rolls = way.speed > ROLLS[at]
            elif at in ALONG:
                rolls = way.rolls > ROLLS[at]
            else:
                held = self.chairs[at + trusted].speed(self.settings.hold_permille)
                rolls = way.rolls > held
            if rolls:
                moving.add(at)
        return frozenset(moving), frozenset(commanded)

    # Returns (blocked, most along, most aside).
    def judge(self, i, trusted, age_ms, bypass):
        moving, commanded = self.directions(i, trusted)
        along = [at for at in ALONG if at in moving]
        aside = [at for at in ASIDE if at in moving]
        if not along or not aside:
            self.moving = frozenset()
            return (False, 1000, 1000)
        if moving != self.moving:
            self.moving = moving
            self.level = None
            self.better_ms = 0
        self.ask(i, trusted, along, aside, commanded)
        self.weigh(i, age_ms)
        slow = all(self.ways[at].speed <= 2 * self.chairs[at + trusted].creep for at in range(4))
        return self.permit(bypass and slow)

    def ask(self, i, trusted, along, aside, commanded):
        sets = self.settings
        linear = turn = 0
        if i.verb == codes.DRIVE:
            linear = min(abs(i.linear_permille), sets.linear_permille)
            turn = min(abs(i.turn_permille), sets.turn_permille)
        elif i.verb in (codes.FORWARD, codes.BACKWARD):
            linear = sets.linear_permille
        else:
            turn = max(sets.turn_permille, sets.step_turn_permille)
        self.asked = linear, turn = min(linear, i.cap_permille), min(turn, i.cap_permille)
        along_at = next(at for at in along if at in commanded or not commanded & set(ALONG))
        aside_at = next(at for at in aside if at in commanded or not commanded & set(ASIDE))
        self.chair = (self.chairs[along_at + trusted], self.chairs[aside_at + trusted])
        # The ways that count: (turn, way) of each row.
        if len(along) == 2 or len(aside) == 2:
            firsts = [arcs.BOTH_AT + arcs.BOTH_ROWS * at for at in along]
            self.turns = as_q4(arcs.BOTH_TURNS_DEG)
        else:
            firsts = [arcs.ROWS * (along[0] + 2 * (aside[0] - 2))]
            self.turns = as_q4(arcs.TURNS_DEG)
        self.firsts = firsts
        most = [chair.permille[0] for chair in self.chair]
        share = max(
            k for k in range(65) if linear * k // 64 <= most[0] and turn * k // 64 <= most[1]
        )
        self.least = (linear * share // 64, turn * share // 64)

    # Whether so far a way is free in the row of that turn.
    def free(self, i, mm, q4):
        for row in range(len(self.turns)):
            if self.turns[row] >= q4:
                return all(i.clearance_arcs[at + row] * arcs.UNIT_MM >= mm for at in self.firsts)
        return False

    # A quadrant among those of `bits` into which it may move.
    def among(self, bits):
        for at in range(4):
            if bits >> at & 1 and at % 2 in self.moving and 2 + at // 2 in self.moving:
                return True
        return False

    def too_near(self, i, age_ms):
        if not self.moving:
            return False
        self.stop_mm = from_there(self.ways, [at for at in ALONG if at in self.moving], age_ms)
        self.stop_q4 = from_there(self.ways, [at for at in ASIDE if at in self.moving], age_ms)
        blind = self.among(i.clearance_arc_views & 15)
        return blind or not self.free(i, self.stop_mm, self.stop_q4)

    # Until it stands, with the outputs of a level; above creep, slowing down begins before.
    def needs(self, level):
        found = []
        for axis in range(2):
            asked, least = self.asked[axis], self.least[axis]
            if asked == 0:
                found.append((self.stop_mm, self.stop_q4)[axis])
                continue
            output = least + (asked - least) * level // LEVELS
            chair = self.chair[axis]
            speed = chair.speed(min(1000, (output + 31) // 32 * 32))
            ahead = speed * limits.ARC_AHEAD_MS // 1000 if level else 0
            found.append(chair.stop(speed) + ahead)
        return found

    def weigh(self, i, age_ms):
        if self.too_near(i, age_ms):
            self.level = BLOCKED
            self.better_ms = 0
            return
        ceiling = 0 if self.among(i.clearance_arc_views >> 4) else LEVELS
        found = better = BLOCKED
        for level in range(ceiling + 1):
            mm, q4 = self.needs(level)
            if self.free(i, mm, q4):
                found = level
                if self.free(i, mm + limits.BAND_MM, q4 + limits.BAND_Q4_DEG):
                    better = level
        if self.level is None or self.level > found:
            self.level = found
            self.better_ms = 0
        elif better > self.level:
            self.better_ms += PERIOD_MS
            if self.better_ms >= limits.CLEAR_MS:
                self.level = better
                self.better_ms = 0
        else:
            self.better_ms = 0

    def block(self):
        self.level = BLOCKED
        self.better_ms = 0
        return self.permit(False)

    def permit(self, bypass):
        level = 0 if bypass else self.level
        if level < 0 or (level == 0 and self.least == (0, 0)):
            return (True, 0, 0)
        caps = [self.least[k] + (self.asked[k] - self.least[k]) * level // LEVELS for k in range(2)]
        return (False, caps[0], caps[1])


def sign(value):
    return (value > 0) - (value < 0)


OUTPUTS = (1, -1, 40, -40, 288, -289, 600, -600, 1000, -1000)


class Drive:
    # Both rules, told the same.

    def __init__(self, seed):
        self.dice = dice = Dice(seed)
        chairs = [Chair(dice, at & 2) for at in range(8)]
        settings = Settings(dice)
        self.ways = [Way() for _ in range(4)]
        self.i = Inputs()
        self.i.clearance_arcs = bytearray(arcs.ALL_FAR)
        self.arcs = Arcs(settings, chairs)
        self.rule = Rule(settings, chairs, self.ways)
        self.trusted = 4 * dice.roll(2)
        self.age_ms = 0
        self.bypass = 0
        self.wanted = (codes.STOP,)

    # Another command, and whether both say so.
    def command(self):
        dice, i = self.dice, self.i
        i.verb = codes.DRIVE if dice.roll(6) else dice.roll(5)
        i.linear_permille = OUTPUTS[dice.roll(len(OUTPUTS))] if dice.roll(6) else 0
        i.turn_permille = OUTPUTS[dice.roll(len(OUTPUTS))] if dice.roll(6) else 0
        i.cap_permille = (1000, 1000, 1000, 600, 200, 70)[dice.roll(6)]
        wanted = (i.verb,)
        if i.verb == codes.DRIVE:
            wanted = (i.verb, sign(i.linear_permille), sign(i.turn_permille))
        assert self.arcs.changed(i) == int(wanted != self.wanted)
        self.wanted = wanted

    def move(self):
        for at in range(4):
            if self.dice.roll(2):
                self.ways[at].change(self.dice, ROLLS[at])
            elif self.dice.roll(2):
                self.ways[at].__init__()
            self.arcs.feel(at, self.ways[at])

    # Another clearance: any, or one that just leaves what a level needs, or just not.
    def look(self):
        dice = self.dice
        rule = self.rule
        units = (1, 15, 45, 128)[dice.roll(4)]
        more = units
        if rule.moving and dice.roll(4):
            mm, _ = rule.needs(dice.roll(LEVELS + 1))
            if dice.roll(2):
                mm += limits.BAND_MM
            units = (mm + 9) // arcs.UNIT_MM - dice.roll(4) // 3
            more = (1, 2, 60)[dice.roll(3)]
        for row in range(arcs.SIZE):
            self.i.clearance_arcs[row] = max(0, min(arcs.FAR, units + dice.roll(more)))
        self.i.clearance_arc_views = (0, 0, 0, 0, 1 << dice.roll(8), dice.roll(256))[dice.roll(6)]
        self.age_ms = (0, 0, 20, dice.roll(300))[dice.roll(4)]

    def as_the_rule_says(self):
        said = self.rule.judge(self.i, self.trusted, self.age_ms, self.bypass)
        self.arcs.judge(self.i, self.trusted, self.age_ms, self.bypass)
        assert self.says() == said, said
        return said

    def says(self):
        return (self.arcs.blocked, self.arcs.linear_cap, self.arcs.turn_cap)

    # A clearance that comes between.
    def comes(self):
        self.look()
        near = self.rule.too_near(self.i, self.age_ms)
        assert self.arcs.too_near(self.i, self.age_ms) == int(near)
        if near:
            self.arcs.block()
            assert self.says() == self.rule.block()


# In each step some of the changes, which come once in so many steps.
def drives(seeds, steps, **once_in):
    seen = set()
    for seed in seeds:
        drive = Drive(seed)
        drive.command()
        for _ in range(steps):
            for change in ("command", "move", "comes", "look"):
                if drive.dice.roll(once_in.get(change, 2)) == 0:
                    getattr(drive, change)()
            drive.bypass = 0 if drive.dice.roll(4) else 100
            seen.add(drive.as_the_rule_says()[0])
    assert seen == {True, False}


def test_what_a_command_leaves_is_as_the_rule_says():
    drives(range(1, 61), 10)


def test_what_many_commands_leave_are_as_the_rule_says():
    drives(range(61, 300), 10)


def test_what_one_command_leaves_of_many_views_is_as_the_rule_says():
    drives(range(300, 360), 60, command=20, move=20, look=3, comes=6)


def test_more_is_allowed_as_the_rule_says():
    drives(range(400, 440), 120, command=90, move=90, look=41, comes=90)


def test_with_both_sides_of_an_axis_it_is_as_the_rule_says():
    for seed in range(500, 580):
        drive = Drive(seed)
        dice, i = drive.dice, drive.i
        i.verb = (codes.DRIVE, 1, 2, codes.DRIVE, 3, 4)[seed % 6]
        i.linear_permille = (600, -600)[dice.roll(2)]
        i.turn_permille = (400, -400)[dice.roll(2)]
        i.cap_permille = 1000
        drive.arcs.changed(i)
        for at in range(4):
            way = drive.ways[at]
            if dice.roll(3):
                way.speed = way.rolls = 50 + dice.roll(300)
                way.stop = dice.roll(10) * 8
            drive.arcs.feel(at, way)
        for _ in range(100):
            if dice.roll(20) == 0:
                drive.look()
                i.clearance_arc_views = 0
            drive.as_the_rule_says()
