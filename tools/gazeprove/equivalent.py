"""Mutants that no test can kill, because they change nothing: by the reason why."""

from __future__ import annotations

from gazeprove.equivalent_obstacles import OBSTACLES

# module -> reason -> (function, change) of each mutant
EQUIVALENT: dict[str, dict[str, tuple[tuple[str, str], ...]]] = {
    "safety": {
        "A press that moves the chair is asked for, not the spent one; it ends spent.": (
            ("_judge_command", "self.spent_edge = self.edge or self.spent_edge  ->  pass"),
            (
                "_judge_command",
                "self.spent_edge = self.edge or self.spent_edge  ->  self.spent_edge = self.edge",
            ),
        ),
        "HOST_SILENT is bit 0 of what passes.": (
            (
                "module",
                (
                    "_PASSING = 1 << codes.HOST_SILENT | 1 << codes.SERVICE_STALLED | 1 << "
                    "codes.TILT | 1 << codes.TILT_UNKNOWN  ->  _PASSING = 1 >> codes.HOST_S"
                    "ILENT | 1 << codes.SERVICE_STALLED | 1 << codes.TILT | 1 << codes.TILT"
                    "_UNKNOWN"
                ),
            ),
            (
                "module",
                (
                    "_PASSING = 1 << codes.HOST_SILENT | 1 << codes.SERVICE_STALLED | 1 << "
                    "codes.TILT | 1 << codes.TILT_UNKNOWN  ->  _PASSING = 1 | 1 << codes.SE"
                    "RVICE_STALLED | 1 << codes.TILT | 1 << codes.TILT_UNKNOWN"
                ),
            ),
        ),
        "Written before it is first read; named here so that no attribute is added later.": (
            ("__init__", "self._verb = codes.STOP  ->  pass"),
            ("__init__", "self._mode = codes.STEP  ->  pass"),
            ("__init__", "self._quiet = False  ->  pass"),
            ("__init__", "self._verb = codes.STOP  ->  self._verb = codes.STOP + 1"),
            ("__init__", "self._verb = codes.STOP  ->  self._verb = codes.STOP - 1"),
            ("__init__", "self._mode = codes.STEP  ->  self._mode = codes.STEP + 1"),
            ("__init__", "self._mode = codes.STEP  ->  self._mode = codes.STEP - 1"),
            ("__init__", "self._quiet = False  ->  self._quiet = True"),
        ),
        "HOST_SILENT and DIR_FORWARD are bit 0.": (
            (
                "_why_not_linear",
                (
                    "if sign > 0 and self.blocked & 1 << codes.DIR_FORWARD:  ->  if sign > "
                    "0 and self.blocked & 1 >> codes.DIR_FORWARD:"
                ),
            ),
            (
                "_why_not_linear",
                (
                    "if sign > 0 and self.blocked & 1 << codes.DIR_FORWARD:  ->  if sign > "
                    "0 and self.blocked & 1:"
                ),
            ),
        ),
        "Adds HOST_SILENT, which has refused everything before.": (
            (
                "_why_not_turn",
                (
                    "if sign and self.faults & codes.HEADING_FAULTS:  ->  if sign and self."
                    "faults & codes.HEADING_FAULTS + 1:"
                ),
            ),
            (
                "_why_not_turn",
                (
                    "return fault_reason(self.faults & codes.HEADING_FAULTS)  ->  return fa"
                    "ult_reason(self.faults & codes.HEADING_FAULTS + 1)"
                ),
            ),
        ),
    },
    "motion": {
        "STOP is never given to motion, so the first word is never taken.": (
            (
                "module",
                (
                    "_WORD = (codes.STOPPED, codes.MOVING_FORWARD, codes.MOVING_BACKWARD, c"
                    "odes.TURNING, codes.TURNING, codes.DRIVING)  ->  _WORD = (codes.STOPPE"
                    "D + 1, codes.MOVING_FORWARD, codes.MOVING_BACKWARD, codes.TURNING, cod"
                    "es.TURNING, codes.DRIVING)"
                ),
            ),
            (
                "module",
                (
                    "_WORD = (codes.STOPPED, codes.MOVING_FORWARD, codes.MOVING_BACKWARD, c"
                    "odes.TURNING, codes.TURNING, codes.DRIVING)  ->  _WORD = (codes.STOPPE"
                    "D - 1, codes.MOVING_FORWARD, codes.MOVING_BACKWARD, codes.TURNING, cod"
                    "es.TURNING, codes.DRIVING)"
                ),
            ),
        ),
        "Written before it is first read; named here so that no attribute is added later.": (
            ("__init__", "self._elapsed_ms = 0  ->  pass"),
            ("__init__", "self._elapsed_ms = 0  ->  self._elapsed_ms = 1"),
            ("__init__", "self._elapsed_ms = 0  ->  self._elapsed_ms = -1"),
        ),
        "No press has this number either.": (("__init__", "self._edge = 0  ->  self._edge = -1"),),
        "An output of 0 stays 0.": (
            (
                "_limit",
                (
                    "if turn > 0 and blocked & 1 << codes.DIR_LEFT or (turn < 0 and blocked"
                    " & 1 << codes.DIR_RIGHT):  ->  if turn >= 0 and blocked & 1 << codes.D"
                    "IR_LEFT or (turn < 0 and blocked & 1 << codes.DIR_RIGHT):"
                ),
            ),
            (
                "_limit",
                (
                    "if turn > 0 and blocked & 1 << codes.DIR_LEFT or (turn < 0 and blocked"
                    " & 1 << codes.DIR_RIGHT):  ->  if turn > 0 and blocked & 1 << codes.DI"
                    "R_LEFT or (turn <= 0 and blocked & 1 << codes.DIR_RIGHT):"
                ),
            ),
            (
                "_limit",
                (
                    "if turn > 0 and blocked & 1 << codes.DIR_LEFT or (turn < 0 and blocked"
                    " & 1 << codes.DIR_RIGHT):  ->  if turn > -1 and blocked & 1 << codes.D"
                    "IR_LEFT or (turn < 0 and blocked & 1 << codes.DIR_RIGHT):"
                ),
            ),
            (
                "_limit",
                (
                    "if turn > 0 and blocked & 1 << codes.DIR_LEFT or (turn < 0 and blocked"
                    " & 1 << codes.DIR_RIGHT):  ->  if turn > 0 and blocked & 1 << codes.DI"
                    "R_LEFT or (turn < 1 and blocked & 1 << codes.DIR_RIGHT):"
                ),
            ),
        ),
    },
}


def reasons(module: str) -> dict[tuple[str, str], str]:
    """Why each listed mutant is equivalent. Raises ValueError when one is listed twice."""
    found: dict[tuple[str, str], str] = {}
    for reason, mutants in {**EQUIVALENT, **OBSTACLES}.get(module, {}).items():
        for key in mutants:
            if key in found:
                raise ValueError(f"{module} {key} is listed twice")
            found[key] = reason
    return found
