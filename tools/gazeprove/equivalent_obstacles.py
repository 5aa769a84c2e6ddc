"""Mutants of the obstacle rule that no test can kill: by module and the reason why."""

from __future__ import annotations

# As EQUIVALENT in equivalent.py.
OBSTACLES: dict[str, dict[str, tuple[tuple[str, str], ...]]] = {
    "obstacles": {
        "The wait is counted in eights: one more or less takes as many turns.": (
            ("__init__", "self._better_ms = 0  ->  self._better_ms = -1"),
            ("__init__", "self._better_ms = 0  ->  self._better_ms = 1"),
            ("judge", "if self._better_ms >= _CLEAR_MS:  ->  if self._better_ms > _CLEAR_MS:"),
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
        "The same speed either way.": (
            ("feel", "if measured > speed:  ->  if measured >= speed:"),
        ),
        "Saves time: nothing is added for a speed of 0.": (("feel", "if speed:  ->  if True:"),),
        "The same level either way.": (("judge", "if level > ceiling:  ->  if level >= ceiling:"),),
    },
    "speed": {
        "The first output sets it, and without one the bound is 0.": (
            ("__init__", "self._bound = 0  ->  self._bound = -1"),
            ("__init__", "self._bound = 0  ->  self._bound = 1"),
            ("__init__", "self._left_ms = 0  ->  pass"),
            ("__init__", "self._left_ms = 0  ->  self._left_ms = -1"),
            ("__init__", "self._left_ms = 0  ->  self._left_ms = 1"),
            ("__init__", "self._peak = 0  ->  self._peak = -1"),
            ("__init__", "self._peak = 0  ->  self._peak = 1"),
            ("__init__", "self._ramp = 0  ->  self._ramp = -1"),
            ("__init__", "self._ramp = 0  ->  self._ramp = 1"),
            ("__init__", "self._since = 0  ->  pass"),
            ("__init__", "self._since = 0  ->  self._since = -1"),
            ("__init__", "self._since = 0  ->  self._since = 1"),
        ),
        "The same value either way.": (
            ("update", "if asked > self._since:  ->  if asked >= self._since:"),
        ),
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
        ),
        "The next turn's output is never below 0 and takes its place.": (
            ("update", "self._since = 0  ->  self._since = -1"),
        ),
    },
    "stopping": {},
    "bypass": {
        "The first session sets it.": (
            ("__init__", "self._number = _ANY  ->  pass"),
            ("__init__", "self._session_count = 0  ->  self._session_count = 1"),
            ("__init__", "self._session_count = 0  ->  self._session_count = -1"),
        ),
        "No press has this number either.": (("module", "_ANY = const(-1)  ->  _ANY = const(-2)"),),
        "Both must be above 0 for a bypass, and a press sets both.": (
            ("__init__", "self._ttl_ms = 0  ->  self._ttl_ms = 1"),
            ("__init__", "self._ttl_ms = 0  ->  self._ttl_ms = -1"),
            ("__init__", "self.left_ms = 0  ->  self.left_ms = 1"),
            ("__init__", "self.left_ms = 0  ->  self.left_ms = -1"),
        ),
        "Nothing is left to count down.": (("step", "if self.left_ms > 0:  ->  if True:"),),
    },
}
