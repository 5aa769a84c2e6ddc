"""Which word is heard as which: `python tests/confusion.py [tuned]` prints the README's table.

Speech of espeak-ng: ten voices, three speeds, three levels of noise. Nothing was chosen by these
voices, other words and sentences; with `tuned`, the voices by which words.py was.
"""

import itertools
import sys
import time
from collections import Counter

from gazechair_voice.words import Recogniser
from speech import in_a_room, say

COMMANDS = ("stop", "left", "right", "forward")
SPEEDS = (130, 160, 190)
NOISES_DB = (None, 20, 12)
_TUNED = """
gmw/en gmw/en-US gmw/en-GB-scotland gmw/en-029 gmw/en-GB-x-rp gmw/en-US+m3 gmw/en-US+f2 gmw/en+f4
gmw/en+m7 gmw/en-US+Annie
"""
TUNED = _TUNED.split()
_FRESH = """
gmw/en-GB-x-gbclan gmw/en-GB-x-gbcwmd gmw/en-US-nyc gmw/en-US+m1 gmw/en+m5 gmw/en-US+f1 gmw/en+f3
gmw/en-US+f5 gmw/en+iven gmw/en-US+linda
"""
FRESH = _FRESH.split()
_OTHER = """
monkey river mountain camera engine bottle sugar butter potato carpet ceiling mirror towel jacket
button pocket bicycle airport hospital medicine injection grandmother neighbour birthday holiday
flower insect elephant cushion umbrella
"""
OTHER = _OTHER.split()
_ALIKE = """
shop stock start step top lift let light write night late forty board word
"""
ALIKE = _ALIKE.split()
SENTENCES = (
    "my grandson plays the piano",
    "did the postman come already",
    "we had soup and a sandwich",
    "give me the blue jacket please",
    "what a beautiful garden you have",
    "it will rain again this afternoon",
    "I left my glasses on the right side",
    "they moved to another town",
    "the stop button is broken",
    "look forward to the holidays",
)


def heard(recogniser, text, voice, speed, snr_db, seed):
    """What is recognised: a word, several with "+" between, or "-"."""
    recogniser.forget()
    words = recogniser.hear(in_a_room(say(text, voice, speed), snr_db, seed))
    return "+".join(words) or "-"


def trials(voices, texts, speeds=SPEEDS, noises=NOISES_DB):
    """Every combination, each with a seed of its own."""
    for seed, (text, voice, speed) in enumerate(itertools.product(texts, voices, speeds)):
        yield text, voice, speed, noises[seed % len(noises)], seed


def table(voices, speeds=SPEEDS):
    """By what was said: how often what was heard."""
    recogniser = Recogniser(COMMANDS[1:])
    rows = {}
    for name, texts, pace in (
        *((word, (word,), speeds) for word in COMMANDS),
        ("words alike", ALIKE, speeds[1:2]),
        ("other words", OTHER, speeds[1:2]),
        ("sentences", SENTENCES, speeds[1:2]),
    ):
        every = trials(voices, texts, pace)
        rows[name] = Counter(heard(recogniser, *trial) for trial in every)
    return rows


def main():
    began_s = time.process_time()
    print(f"{'said':12}" + "".join(f"{name:>9}" for name in (*COMMANDS, "nothing", "other")))
    for name, row in table(TUNED if "tuned" in sys.argv else FRESH).items():
        counts = [row[word] for word in COMMANDS] + [row["-"]]
        counts.append(sum(row.values()) - sum(counts))
        print(f"{name:12}" + "".join(f"{count:9}" for count in counts))
    print(f"{time.process_time() - began_s:.0f} s of one processor")


if __name__ == "__main__":
    main()
