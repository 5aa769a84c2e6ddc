# The state of the whole core as one array of words, which a replay begins with.
# Read between two ticks.

from array import array

from gazeboard.core.ages import Ages
from gazeboard.core.arcs import Arcs
from gazeboard.core.auto import Auto
from gazeboard.core.bypass import Bypass
from gazeboard.core.motion import Motion
from gazeboard.core.obedience import Obedience
from gazeboard.core.obstacles import Obstacles, Way
from gazeboard.core.profile_check import ProfileCheck
from gazeboard.core.safety import Safety
from gazeboard.core.speed import SpeedBound
from gazeboard.core.tick import Tick
from gazeboard.turning.casters import Casters
from gazeboard.turning.chair_model import ChairModel
from gazeboard.turning.slope import Slope
from gazeboard.turning.small_moves import SmallMoves
from gazeboard.turning.turn import TurnController
from gazelink.native import micropython, ptr32
from gazelink.settings_table import NAMES

# What changes in a tick. All other objects follow from the settings.
PARTS = (
    Tick,
    Safety,
    Ages,
    Auto,
    Obstacles,
    Way,
    SpeedBound,
    Bypass,
    Arcs,
    Obedience,
    ProfileCheck,
    Motion,
    TurnController,
    ChairModel,
    Casters,
    Slope,
    SmallMoves,
)
_JOYSTICK = ("_linear_permille", "_turn_permille", "neutral")
_TABLES = ("_numbers",)  # of Arcs, from the settings


class CoreState:
    # core: a Tick; joystick: a Joystick. First the settings as in their table, then every number,
    # list and array of numbers; in the same order wherever it is made. To be made anew when a part
    # is replaced or the settings change.

    def __init__(self, core, joystick, settings):
        self.numbers = [(joystick, name) for name in _JOYSTICK]
        self.lists = []
        self.arrays = []
        self._found = []
        self._find(core)
        self._numbers = self._written_out()
        count = len(NAMES) + len(self.numbers)
        for numbers in self.lists + self.arrays:
            count += len(numbers)
        self.words = array("i", [0] * count)
        for k in range(len(NAMES)):
            self.words[k] = settings.get(k)

    def _find(self, part):
        if isinstance(part, (list, tuple)):
            for one in part:
                self._find(one)
        if not isinstance(part, PARTS) or part in self._found:
            return
        self._found.append(part)
        if isinstance(part, Casters) and not part.any:
            return
        for name in sorted(part.__dict__):
            value = getattr(part, name)
            if isinstance(value, (int, bool)):
                self.numbers.append((part, name))
            elif isinstance(value, array):
                if name not in _TABLES and not any(value is known for known in self.arrays):
                    self.arrays.append(value)
            elif isinstance(value, list) and isinstance(value[0], int):
                self.lists.append(value)
            else:
                self._find(value)

    # A function that takes the numbers, one line each: with getattr() it would take four times as
    # long, and no gap between two ticks would be long enough.
    def _written_out(self):
        lines = ["def take(words, parts):"]
        parts = []
        n = len(NAMES)
        for part, name in self.numbers:
            if not parts or parts[-1] is not part:
                lines.append(" part = parts[%d]" % len(parts))
                parts.append(part)
            lines.append(" words[%d] = part.%s" % (n, name))
            n += 1
        made = {}
        exec("\n".join(lines), made)
        return made["take"], parts

    # What the core is now, into `words`. In the service loop: a tick may interrupt it.
    @micropython.native
    def take(self):
        words = self.words
        take, parts = self._numbers
        take(words, parts)
        n = len(NAMES) + len(self.numbers)
        for numbers in self.lists:
            for number in numbers:
                words[n] = number
                n += 1
        for numbers in self.arrays:
            _copy(numbers, len(numbers), words, n)
            n += len(numbers)


@micropython.viper
def _copy(source, count: int, target, at: int):
    s = ptr32(source)
    t = ptr32(target)
    k = 0
    while k < count:
        t[at + k] = s[k]
        k += 1
