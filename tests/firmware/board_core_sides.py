# The board's decision on both sides alike: what is true of the left is, mirrored, true of the
# right; and what the obstacle rule tells the arcs.

from gazeboard.core.obstacles import ARC_BLOCKED, Obstacles
from gazeboard.io.settings import Settings
from obstaclerig import Eyes

RATES = (2000, 1200)  # more than in any profile


def one_sided(left, right):
    settings = Settings()
    settings.p3_1_left_q4_dps = left
    settings.p3_1_right_q4_dps = right
    # One that is not alike takes longer: it counts where the profile is not trusted.
    settings.p1_2_dead_time_ms = 300
    settings.p1_2_lag_ms = 800
    return settings


class Side:
    # A chair that turns fast to one side, that side first: `way` 0 is the fast one.

    def __init__(self, mirrored):
        rates = (RATES[1], RATES[0]) if mirrored else RATES
        self.eyes = Eyes(one_sided(*rates))
        self.sign = -1 if mirrored else 1
        self.at = (3, 2) if mirrored else (2, 3)

    def tick(self, turn, rate_q4, near, blocked, trusted, sluggish):
        eyes = self.eyes
        eyes.i.rate_q4 = self.sign * rate_q4
        eyes.set(near, (self.at[0],))
        eyes.i.clearance_blocked = blocked << self.at[1]
        if eyes.now_ms % 20 == 0:
            eyes.frame()
        eyes.now_ms += 1
        eyes.o.step(eyes.i, 0, self.sign * turn, True, trusted, sluggish)

    def felt(self):
        o = self.eyes.o
        ways = [o._ways[at] for at in self.at]
        return [(way.speed, way.stop, way.rolls) for way in ways]

    def decided(self):
        o = self.eyes.o
        return [
            (o._ways[at].level, o.caps[at], o.decisions >> 2 * at & 3, o.blocked >> at & 17)
            for at in self.at
        ]


STORY = (
    # ms, turn, rate, way left on the fast side, is the other side blocked
    (200, 0, 0, 65535, 0),
    (300, 900, 0, 65535, 0),
    (500, 0, 0, 65535, 0),
    (100, -600, 0, 65535, 0),
    (900, 0, 0, 65535, 0),
    (300, 1000, 300, 3000, 0),
    (300, 0, 1900, 3000, 0),
    (300, 0, -1900, 3000, 0),
    (200, 0, 0, 900, 1),
    (200, 0, 0, 100, 0),
    (800, 500, 0, 2000, 0),
)


def test_the_right_is_judged_as_the_left_is():
    seen = []
    for trusted, sluggish in ((False, False), (True, False), (False, True), (True, True)):
        left = Side(False)
        right = Side(True)
        felt = 0
        for ms, turn, rate, near, blocked in STORY:
            for _ in range(ms):
                left.tick(turn, rate, near, blocked, trusted, sluggish)
                right.tick(turn, rate, near, blocked, trusted, sluggish)
                assert left.felt() == right.felt()
                for speed, stop, rolls in left.felt():
                    felt = (31 * felt + speed + 3 * stop + 7 * rolls) & 0xFFFFFF
            assert left.decided() == right.decided()
        seen.append(felt)
    # Trusted and sluggish count alike for a side; neither of them does not.
    assert seen[1] == seen[2] == seen[3]
    assert seen[0] != seen[1]


def test_a_side_that_cannot_creep_is_reported_as_itself():
    # So fast a turn has no creep below what starts it.
    for at, rates in ((2, (1060, 80)), (3, (80, 1060))):
        settings = one_sided(*rates)
        settings.p3_1_deadband_permille = 300
        eyes = Eyes(settings)
        assert eyes.stopping(at).permille[0] == 0
        eyes.i.clearance_unseen = 1 << at
        eyes.run(400)
        assert eyes.o.blocked & 15 << 4 == 16 << at
        assert eyes.o.blocked & 1 << at


class Spy:
    # Arcs that say what they are told.

    def __init__(self, near=0, changes=0):
        self.near = near
        self.changes = changes
        self.blocked = False
        self.told = []
        self.felt = []
        self.blocks = 0

    def feel(self, at, way):
        self.felt.append((at, way))

    def changed(self, i):
        return self.changes

    def judge(self, i, trusted, age_ms, bypass):
        self.told.append((trusted, bypass))

    def too_near(self, i, age_ms):
        return self.near

    def block(self):
        self.blocks += 1


def test_the_arcs_use_the_profile_whose_numbers_count():
    for trusted, told in ((False, 0), (True, 4)):
        eyes = Eyes()
        eyes.trusted = trusted
        eyes.o.arcs = Spy()
        eyes.run(30)
        assert eyes.o.arcs.told
        assert all(said == (told, 0) for said in eyes.o.arcs.told)


def test_the_arcs_update_each_direction_once_in_a_round():
    eyes = Eyes()
    eyes.o.arcs = Spy()
    eyes.frames = False
    eyes.run(8)
    ways = eyes.o._ways
    assert eyes.o.arcs.felt in [
        [(at, ways[at]) for at in order] for order in ((0, 1, 2, 3), (1, 2, 3, 0), (2, 3, 0, 1))
    ]


def test_the_arcs_are_judged_once_in_a_tick_however_often_the_command_changes():
    eyes = Eyes()
    eyes.o.arcs = Spy(changes=1)
    for ticks in range(1, 50):
        eyes.tick()
        assert len(eyes.o.arcs.told) == ticks


def test_an_arc_too_near_is_blocked_in_the_tick_that_sees_it():
    for near, was, bypass, blocks in (
        (1, False, 0, 1),
        (0, False, 0, 0),
        (1, True, 0, 0),
        (1, False, 500, 0),
        (1, True, 500, 0),
    ):
        eyes = Eyes()
        eyes.o.blocked = 0
        eyes.o.arcs = Spy(near)
        eyes.o.arcs.blocked = was
        eyes.o.bypass.left_ms = bypass
        eyes.frames = False
        eyes.frame()
        eyes.tick()
        assert eyes.o.arcs.blocks == blocks
        assert (eyes.o.blocked & ARC_BLOCKED != 0) is (blocks == 1)


def test_new_settings_count_for_the_arcs_too():
    settings = one_sided(*RATES)
    o = Obstacles(Settings())
    before = list(o.arcs._numbers)
    o.configure(settings)
    assert list(o.arcs._numbers) == list(Obstacles(settings).arcs._numbers)
    assert list(o.arcs._numbers) != before
