"""Recognises single words in sound: pocketsphinx with the English model of its own package.

The grammar has one word for each utterance: a command or one of some hundred other words, which
take what is no command. The commands weigh more than the others, and "stop" weighs most.
"""

import math
import os
import tempfile

from gazechair.plugins import Unusable
from gazechair_voice.ear import Ear
from gazechair_voice.others import OTHERS

# Natural logarithms of weights: stop 0.
COMMAND, OTHER = -35.0, -60.0


class Recogniser:
    """Takes sound as it comes and finds words in it."""

    def __init__(self, commands):
        """`commands` besides "stop": lower-case English words. Raises Unusable."""
        try:
            import pocketsphinx
        except ImportError:
            raise Unusable(
                "the package pocketsphinx is missing: pip install pocketsphinx"
            ) from None
        self._commands = {"stop", *commands}
        others = [word for word in OTHERS if word not in self._commands]
        said = _pronunciations(
            pocketsphinx.get_model_path("en-us/cmudict-en-us.dict"), {*self._commands, *others}
        )
        for word in self._commands:
            if word not in said:
                raise Unusable(f"{word!r} is not in the recogniser's English dictionary")
        self._decoder = _decoder(pocketsphinx, self._commands, others, said)
        self._ear = Ear()

    def forget(self):
        """What was heard so far is no part of a word: sound is missing after it."""
        self._ear.forget()

    @property
    def trouble(self):
        """Why no word can be heard; "" when one can."""
        return self._ear.trouble

    def hear(self, data):
        """The commands whose end is in `data`: 16 kHz, 16 bit, mono, cut anywhere."""
        return [word for sound in self._ear.hear(data) if (word := self._decide(sound))]

    def _decide(self, sound):
        self._decoder.start_utt()
        self._decoder.process_raw(sound, full_utt=True)
        self._decoder.end_utt()
        found = self._decoder.hyp()
        word = found.hypstr.split(" ")[0] if found is not None else ""
        return word if word in self._commands else ""


def _pronunciations(path, words):
    """Of those words that are in the dictionary at `path`: all their lines."""
    found = {}
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            word = line.split(" ", 1)[0].split("(")[0]
            if word in words:
                found.setdefault(word, []).append(line)
    return found


def _decoder(pocketsphinx, commands, others, said):
    with tempfile.NamedTemporaryFile("w", suffix=".dict", delete=False) as file:
        for lines in said.values():
            file.writelines(lines)
    try:
        decoder = pocketsphinx.Decoder(
            hmm=pocketsphinx.get_model_path("en-us/en-us"),
            dict=file.name,
            lm=None,
            loglevel="FATAL",
            cmn="batch",
            bestpath=False,
            lw=1.0,
            wip=1.0,
            pip=1.0,
        )
    finally:
        os.unlink(file.name)
    grammar = [(0, 1, math.exp(COMMAND), word) for word in sorted(commands - {"stop"})]
    grammar += [(0, 1, math.exp(OTHER), word) for word in others if word in said]
    grammar += [(0, 2, 1.0, "stop"), (2, 2, 1.0, "stop"), (2, 1, 1.0)]  # "stop, stop, stop"
    decoder.add_fsg("words", decoder.create_fsg("words", 0, 1, grammar))
    decoder.activate_search("words")
    return decoder
