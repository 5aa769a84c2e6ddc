"""Mutants of the obstacle rule that no test can kill: by module and the reason why."""

from __future__ import annotations

# As EQUIVALENT in equivalent.py.
OBSTACLES: dict[str, dict[str, tuple[tuple[str, str], ...]]] = {
    "obedience": {},
    "obstacles": {
        "The wait is counted in eights: one more or less takes as many turns.": (
            ("__init__", "self._better_ms = 0  ->  self._better_ms = -1"),
            ("__init__", "self._better_ms = 0  ->  self._better_ms = 1"),
            ("judge", "self._better_ms = 0  ->  self._better_ms = 1"),
            ("judge", "self._better_ms = 0  ->  self._better_ms = -1"),
            ("block", "self._better_ms = 0  ->  self._better_ms = 1"),
            ("block", "self._better_ms = 0  ->  self._better_ms = -1"),
            ("module", "_CLEAR_MS = const(300)  ->  _CLEAR_MS = const(301)"),
            ("module", "_CLEAR_MS = const(300)  ->  _CLEAR_MS = const(299)"),
        ),
        "Written before it is first read; named here so that no attribute is added later.": (
            ("__init__", "self.speed = 0  ->  self.speed = -1"),
            ("__init__", "self.speed = 0  ->  self.speed = 1"),
            ("__init__", "self.stop = 0  ->  self.stop = -1"),
            ("__init__", "self.stop = 0  ->  self.stop = 1"),
        ),
        "Saves time: a clearance stays for longer than a turn, which says the same.": (
            ("_look", "if near:  ->  if True:"),
            ("_look", "near &= ~self.blocked  ->  pass"),
        ),
        "Where the round begins, and what the first tick finds, is no matter: nothing has moved.": (
            ("__init__", "self._phase = 0  ->  self._phase = 1"),
            ("__init__", "self._phase = 0  ->  self._phase = -1"),
            ("__init__", "self._looked = False  ->  self._looked = True"),
            ("__init__", "self._extra_ms = 0  ->  self._extra_ms = 1"),
            ("__init__", "self._extra_ms = 0  ->  self._extra_ms = -1"),
        ),
        "An output of 0, or below, asks for nothing.": (
            ("step", "measured = 0  ->  measured = -1"),
            ("step", "most[at] = 0  ->  most[at] = -1"),
        ),
        "Forward is the lowest.": (
            ("step", "if at == _FORWARD:  ->  if at <= _FORWARD:"),
            ("_judge", "if at == _FORWARD:  ->  if at <= _FORWARD:"),
        ),
        "Only how the work is spread.": (("step", "self._looked = False  ->  pass"),),
        "Nobody asks for the higher bits.": (
            (
                "_look",
                "near = i.clearance_blocked & _ALL_BLOCKED  ->  near = i.clearance_blocked",
            ),
        ),
        "A list that is longer than what is asked of it.": (
            (
                "__init__",
                (
                    "self._ways = [Way() for _ in range(4)]  ->  self._ways = [Way() for _ "
                    "in range(5)]"
                ),
            ),
            ("_look", "for at in range(4):  ->  for at in range(5):"),
        ),
        "The round goes the other way.": (
            ("step", "phase = self._phase + 1 & 7  ->  phase = self._phase - 1 & 7"),
        ),
        "DIR_FORWARD is bit 0.": (
            ("_look", "near |= 1 << _FORWARD  ->  near |= 1 >> _FORWARD"),
            ("_look", "near |= 1 << _FORWARD  ->  near |= 1"),
        ),
        "The others were asked for before, or there is none beyond.": (
            ("_judge", "if at == _BACKWARD:  ->  if at <= _BACKWARD:"),
            ("_judge", "if at == _LEFT:  ->  if at <= _LEFT:"),
            (
                "_decide",
                (
                    "decision = _DECIDED_FREE if level == _LEVELS else _DECIDED_SLOW  ->  d"
                    "ecision = _DECIDED_FREE if level >= _LEVELS else _DECIDED_SLOW"
                ),
            ),
        ),
        "The search then finds the same level.": (
            (
                "judge",
                (
                    "if level >= 0 and (distance < stop or distance < begin[level]):  ->  i"
                    "f level >= 0 and (distance <= stop or distance < begin[level]):"
                ),
            ),
            (
                "judge",
                (
                    "if level >= 0 and (distance < stop or distance < begin[level]):  ->  i"
                    "f level >= 0 and (distance < stop or distance <= begin[level]):"
                ),
            ),
        ),
        "The same speed either way.": (
            ("feel", "if measured > speed:  ->  if measured >= speed:"),
        ),
        "Saves time: nothing is added for a speed of 0.": (("feel", "if speed:  ->  if True:"),),
        "The same level either way.": (("judge", "if level > ceiling:  ->  if level >= ceiling:"),),
    },
    "speed": {
        "Equal, or made so by the max() that follows.": (
            ("update", "if bound > ramp:  ->  if True:"),
            ("update", "if bound > ramp:  ->  if bound >= ramp:"),
            ("update", "if ramp < peak:  ->  if True:"),
            ("update", "if ramp < peak:  ->  if ramp <= peak:"),
            ("update", "if ramp > peak:  ->  if True:"),
            ("update", "if ramp > peak:  ->  if ramp >= peak:"),
        ),
        "Saves time: a bound of 0 stays 0 without an output.": (
            ("update", "if permille == 0 and bound == 0:  ->  if False:"),
            (
                "update",
                "if permille == 0 and bound == 0:  ->  if permille == -1 and bound == 0:",
            ),
            (
                "update",
                "if permille == 0 and bound == 0:  ->  if permille == 0 and bound == 1:",
            ),
            (
                "update",
                "if permille == 0 and bound == 0:  ->  if permille == 0 and bound == -1:",
            ),
        ),
    },
    "stopping": {},
    "bypass": {
        "So short a pause is over before anybody is armed; none is as good as one that is over.": (
            ("__init__", "self._pause_ms = 0  ->  self._pause_ms = 1"),
            ("__init__", "self._pause_ms = 0  ->  self._pause_ms = -1"),
        ),
        "The first session sets it.": (
            ("__init__", "self._number = _ANY  ->  pass"),
            ("__init__", "self._session_count = 0  ->  self._session_count = 1"),
            ("__init__", "self._session_count = 0  ->  self._session_count = -1"),
        ),
        "No press has this number either.": (("module", "_ANY = const(-1)  ->  _ANY = const(-2)"),),
        "Both must be above 0 for a bypass, and a press sets both.": (
            ("__init__", "self._ttl_ms = 0  ->  self._ttl_ms = 1"),
            ("__init__", "self._ttl_ms = 0  ->  self._ttl_ms = -1"),
        ),
        "Nothing is left to count down, or it is in this turn.": (
            ("step", "if self.left_ms > 0:  ->  if self.left_ms > -1:"),
            ("step", "self._ttl_ms = 0  ->  self._ttl_ms = 1"),
            ("step", "self._ttl_ms = 0  ->  self._ttl_ms = -1"),
        ),
        "No number is below 0; an odd bit less does not reach the other half.": (
            (
                "_heard",
                (
                    "if self._number != _ANY and number - self._number & 255 > 127:  ->  "
                    "if self._number > _ANY and number - self._number & 255 > 127:"
                ),
            ),
            (
                "_heard",
                (
                    "if self._number != _ANY and number - self._number & 255 > 127:  ->  "
                    "if self._number != _ANY and number - self._number & 254 > 127:"
                ),
            ),
        ),
    },
}
