# The board's active settings.
#
# Loaded at start, changed over the wire while disarmed, saved with a CRC.

import json

from gazeboard.io.storage import sealed, unsealed
from gazelink import codes
from gazelink.settings_table import NAMES, TABLE, index_of, profile_row

FILE = "settings.json"
_NEUTRAL = (index_of("neutral_linear_count"), index_of("neutral_turn_count"))
_BOTH = 3


class Settings:
    # Attributes as named in the table. `calibrated` is False, and the board does not arm, while the
    # joystick's neutral differs from the stored one: it was changed, or the stored text was
    # rejected (the defaults are then active, and `error` is the reason). Such a neutral is stored
    # only straight after both its counts were set: any other save would take a guess, or a count
    # that is still being measured, for the chair's own.

    def __init__(self, text=None):
        self.error = ""
        self._set_all()
        if text is not None:
            self._load(text)
        self._stored = self.neutral()  # and while that is not readable, the defaults
        self._damaged = bool(self.error)
        self._measured = 0  # bit per count of the neutral: set since anything else was
        self.calibrated = not self._damaged

    def _set_all(self):
        for name, default, _low, _high in TABLE:
            setattr(self, name, default)

    # All but the neutral, which is measured and no preference.
    def defaults(self):
        neutral = self.neutral()
        self._set_all()
        self._put_neutral(neutral)
        self._measured = 0

    def neutral(self):
        return (self.neutral_linear_count, self.neutral_turn_count)

    def _put_neutral(self, neutral):
        self.neutral_linear_count, self.neutral_turn_count = neutral
        self._compare()

    def _compare(self):
        self.calibrated = not self._damaged and self.neutral() == self._stored

    # NO_REASON, or why what is in force must not be written to flash.
    def store_refused(self):
        if self.calibrated or self._measured == _BOTH:
            return codes.NO_REASON
        return codes.SETTING_BY_CALIBRATION

    # What is in force has been written to flash.
    def stored(self):
        self._stored = self.neutral()
        self._damaged = False
        self._measured = 0
        self.calibrated = True

    # A neutral that was not stored is not kept for the next who connects.
    def drop_neutral(self):
        self._put_neutral(self._stored)
        self._measured = 0

    def get(self, index):
        return getattr(self, NAMES[index])

    # A value of the selected profile, `name` as in PROFILE_ROWS.
    def of_profile(self, name):
        return getattr(self, profile_row(self.profile, name))

    # Returns NO_REASON, or why the value is refused (nothing changed then).
    def set(self, index, value):
        if index in _NEUTRAL:
            return codes.SETTING_BY_CALIBRATION
        self._measured = 0
        return self._set(index, value)

    # The same of the joystick's neutral, and of nothing else.
    def set_neutral(self, index, value):
        if index not in _NEUTRAL:
            return codes.SETTING_UNKNOWN
        refused = self._set(index, value)
        if refused == codes.NO_REASON:
            self._measured |= 1 << _NEUTRAL.index(index)
        self._compare()
        return refused

    def _set(self, index, value):
        if index >= len(TABLE):
            return codes.SETTING_UNKNOWN
        name, _default, low, high = TABLE[index]
        if not low <= value <= high:
            return codes.SETTING_OUT_OF_RANGE
        setattr(self, name, value)
        return codes.NO_REASON

    # As it is stored: one line of JSON, one line with the JSON's CRC-32.
    def text(self):
        line = json.dumps({name: getattr(self, name) for name in NAMES})
        return sealed(line)

    def _load(self, text):
        line = unsealed(text)
        if line is None:
            self._refuse("settings: damaged (CRC)")
            return
        try:
            values = json.loads(line)
        except Exception:  # no JSON, or too deep
            values = None
        if not isinstance(values, dict):
            self._refuse("settings: not a JSON object")
            return
        for name in values:
            refused = self._check(name, values[name])
            if refused:
                self._refuse(refused)
                return
        for name in values:
            setattr(self, name, values[name])

    def _check(self, name, value):
        for row in TABLE:
            if row[0] == name:
                if type(value) is int and row[2] <= value <= row[3]:
                    return ""
                return "settings: %s must be a whole number %d..%d" % (name, row[2], row[3])
        return "settings: unknown name " + name

    def _refuse(self, reason):
        self._set_all()
        self.error = reason
