"""The input `voice`: a spoken word becomes a stop, a step, or the choice of a mode."""

import time
from dataclasses import dataclass

from gazechair.plugins import NOTHING, STOP, Input, choose, number, setting, step, text
from gazechair_voice.listener import Listener
from gazechair_voice.sources import opener
from gazechair_voice.words import Recogniser

COMMANDS = {
    "stop": STOP,
    "left": step("left"),
    "right": step("right"),
    "forward": step("forward"),
}
REHEARSAL = "rehearsal"
STOP_S = 1.0  # nobody drives for so long after "stop"
STEP_S = 0.3  # a step is said for so long; it ends by itself


class Voice(Input):
    """Spoken English words: "stop", "left", "right", "forward", and the names of modes."""

    @dataclass(frozen=True)
    class Settings:
        """Spoken words. Each must be said alone, with a moment of silence before and after it."""

        source: str = setting(
            "microphone", text(), '"microphone", or the path of a WAV file or a named pipe'
        )
        device: str = setting("default", text(), "the microphone, by its name in `arecord -L`")
        modes: str = setting("", text(), 'words that choose the mode of that name, as "ahead"')
        choose_s: float = setting(1.0, number(0.2, 2.0), "how long such a word holds its mode")

    nl = "Stem"
    en = "Voice"
    icon = "🎤"
    rehearsal = {"source": REHEARSAL}  # noqa: RUF012 (as in docs/extending.md)

    def __init__(self, settings):
        super().__init__(settings)
        modes = settings.modes.lower().split()
        self._intents = {**{mode: choose(mode) for mode in modes}, **COMMANDS}
        self._intent, self._until_s = NOTHING, 0.0
        self._listener = None
        if settings.source != REHEARSAL:
            recogniser = Recogniser([word for word in self._intents if word != "stop"])
            self._listener = Listener(opener(settings.source, settings.device), recogniser)
            self._listener.start()

    def sense(self, now_s):
        if self._listener is None:
            word = "forward" if now_s % 1.2 >= 0.6 else ""
        else:
            word = self._listener.take(time.monotonic())
        if word == "stop" or (word and not (self._intent == STOP and now_s < self._until_s)):
            self._intent = self._intents[word]
            self._until_s = now_s + self._lasts_s()
        return self._intent if now_s < self._until_s else NOTHING

    def _lasts_s(self):
        if self._intent == STOP:
            return STOP_S
        return STEP_S if self._intent.do == "step" else self.settings.choose_s

    def trouble(self):
        return "" if self._listener is None else self._listener.trouble

    def close(self):
        if self._listener is not None:
            self._listener.stop()
