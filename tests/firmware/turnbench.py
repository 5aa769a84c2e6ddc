# The turn controller on a bench: a chair that turns as a model says.

from gazeboard.core.angle import wrapped
from gazeboard.core.limits import HEADING_TURN_Q4_DEG
from gazeboard.io.settings import Settings
from gazeboard.turning.chair_model import ChairModel
from gazeboard.turning.turn import turn_controller
from gazelink.settings_table import profile_row


def settings_of(profile, values):
    settings = Settings()
    settings.profile = profile
    for name in values:
        setattr(settings, profile_row(profile, name), values[name])
    return settings


class Bench:
    # A board that takes the profile's defaults for tuned, and a chair of which `values` differ.

    def __init__(self, profile=2, values=None, heading_q4=0, tuned=1):
        self.turn = turn_controller(settings_of(profile, {"tuned": tuned}))
        self.chair = ChairModel(settings_of(profile, values or {}))
        self.begins_q4 = heading_q4
        self.heading_q4 = heading_q4
        self.rate_q4 = 0
        self.count = 0
        self.ms = 0
        self.stuck = False
        self.slope_dps = 0.0  # turns the chair while it moves
        self.slid_q4 = 0.0
        self.outs = []

    def one_ms(self, out):
        self.turn.follow(out)
        self.chair.step(0 if self.stuck else out)
        self.outs.append(out)
        self.ms += 1
        if abs(self.chair.seen_rate()) > 512:
            self.slid_q4 += self.slope_dps * 16 / 1000
        if self.ms % 10 == 0:
            angle_q4 = (self.chair.seen_angle() >> 12) + int(self.slid_q4)
            self.heading_q4 = (self.begins_q4 + angle_q4) % HEADING_TURN_Q4_DEG
            self.rate_q4 = self.chair.seen_rate() >> 6
            self.count += 1

    # Turn by `degrees`; the error it ends with, in degrees, and the time it takes, ms.
    def by(self, degrees):
        setpoint_q4 = self.heading_q4 + degrees * 16
        self.turn.start(setpoint_q4, self.count)
        begins_ms = self.ms
        while not self.turn.arrived and not self.turn.missed:
            self.one_ms(self.turn.update(self.heading_q4, self.rate_q4, self.count))
            assert self.ms - begins_ms < 10000
        return wrapped(setpoint_q4 - self.heading_q4) / 16, self.ms - begins_ms

    # How often the output changed sides.
    def flips(self):
        sides = [out > 0 for out in self.outs if out]
        return sum([sides[k] != sides[k - 1] for k in range(1, len(sides))])

    # How often it set out anew.
    def pushes(self):
        outs = self.outs
        return sum([outs[k] != 0 and (k == 0 or outs[k - 1] == 0) for k in range(len(outs))])


# How long each output lasted, ms, signed by its side.
def pulses(outs):
    found = []
    before = 0
    for out in outs:
        if out and out == before:
            found[-1] += 1 if out > 0 else -1
        elif out:
            found.append(1 if out > 0 else -1)
        before = out
    return found
