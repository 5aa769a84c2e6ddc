# Settings: one table of names, defaults and limits; values from a JSON file, refused when out of
# range.

import json

from gazeboard import limits

# name: (default, lowest, highest). Units are in the names; *_permille is of full deflection,
# q4 is sixteenths. Nothing here can exceed what the safety promises allow.
TABLE = {
    "neutral_linear_count": (limits.WIPER_NEUTRAL, 150, 190),
    "neutral_turn_count": (limits.WIPER_NEUTRAL, 150, 190),
    "linear_permille": (600, 50, 1000),
    "turn_permille": (500, 50, 1000),
    "step_forward_ms": (2000, 100, limits.STEP_FORWARD_MAX_MS),
    "step_turn_q4_deg": (160, 32, 720),
    "step_turn_limit_ms": (6000, 1000, limits.STEP_TURN_MAX_MS),
    "turn_kp_q4": (400, 0, 3200),
    "turn_ki_q4": (0, 0, 3200),
    "turn_kd_q4": (100, 0, 3200),
    "turn_cutoff_q4_deg": (20, 8, 80),
    "turn_offset_permille": (100, 0, 300),
    "tilt_limit_q4_deg": (240, 80, 480),
    "relay_fitted": (1, 0, 1),
}


class Settings:
    # Attributes as named in TABLE. `calibrated` is False when the stored text was refused: the
    # defaults are in force then, the board does not arm, and `error` says why.

    def __init__(self, text=None):
        self.calibrated = True
        self.error = ""
        for name in TABLE:
            setattr(self, name, TABLE[name][0])
        if text is not None:
            self._load(text)

    def _load(self, text):
        try:
            values = json.loads(text)
        except ValueError:
            values = None
        # MicroPython's parser takes an object that was cut off as whole.
        if values is None or text.rstrip()[-1:] not in "}]":
            self._refuse("settings: not JSON")
            return
        if not isinstance(values, dict):
            self._refuse("settings: not a JSON object")
            return
        for name in values:
            if name not in TABLE:
                self._refuse("settings: unknown name " + name)
                return
            low, high = TABLE[name][1:]
            value = values[name]
            if type(value) is not int or not low <= value <= high:
                self._refuse("settings: %s must be a whole number %d..%d" % (name, low, high))
                return
        for name in values:
            setattr(self, name, values[name])

    def _refuse(self, reason):
        self.calibrated = False
        self.error = reason
