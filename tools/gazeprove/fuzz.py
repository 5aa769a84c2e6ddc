"""The fuzzer of the whole firmware: runs lives, shrinks one that broke a promise, says so."""

from __future__ import annotations

import argparse
import gc
import itertools
import multiprocessing
import random
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from gazeprove.fuzz_episodes import EPISODES
from gazeprove.fuzz_facts import Violation
from gazeprove.fuzz_life import Life

EPISODES_PER_LIFE = 16
_SHARED = Path("/dev/shm")


@dataclass
class Outcome:
    """What one life came to."""

    seed: int
    ticks: int = 0
    broken: str = ""
    episodes: list[str] = field(default_factory=list)
    story: list[str] = field(default_factory=list)
    stats: dict[str, int] = field(default_factory=dict)

    def __str__(self) -> str:
        if not self.broken:
            return f"life {self.seed}: nothing broken in {self.ticks} ticks"
        return f"life {self.seed}, {' '.join(self.episodes)}, tick {self.ticks}: {self.broken}"


def live(
    seed: int, kept: frozenset[int] | None = None, log: bool = False, only: str = ""
) -> Outcome:
    """One life from its seed; `kept` leaves out all other episodes, `only` all of other names."""
    outcome = Outcome(seed)
    table = [(weight, one) for weight, one in EPISODES if only in ("", one.__name__)]
    weights = [weight for weight, _ in table]
    drawn = random.Random(seed ^ 0x5EED).choices(table, weights, k=EPISODES_PER_LIFE)
    place = str(_SHARED) if _SHARED.is_dir() else None
    with tempfile.TemporaryDirectory(prefix="gazefuzz-", dir=place) as folder:
        life = Life(seed, folder, log)
        try:
            for number, (_, episode) in enumerate(drawn):
                if kept is not None and number not in kept:
                    continue
                life.rng.seed(seed * 1000 + number)
                life.note(f"episode {number}: {episode.__name__}")
                outcome.episodes.append(episode.__name__)
                life.run(life.ready())
                life.run(episode(life))
        except Violation as violation:
            outcome.broken = str(violation)
        except Exception as error:  # the firmware's service loop raised: main.py would have ended
            outcome.broken = f"P10: {type(error).__name__}: {error}"
        outcome.ticks = life.ticks
        outcome.stats = life.oracle.stats
        outcome.story = life.story
    return outcome


def fuzz(ticks: int, first: int, processes: int) -> Iterator[Outcome]:
    """Lives from seed `first` on until so many ticks were run, as they end."""
    with multiprocessing.get_context("fork").Pool(processes, _prepare) as pool:
        for outcome in pool.imap_unordered(live, itertools.count(first)):
            yield outcome
            ticks -= outcome.ticks
            if ticks <= 0:
                return


def _prepare() -> None:
    """For a process that does nothing but live.

    The firmware collects its garbage once a second of its own time. That changes nothing here, and
    takes as long as all else in that second.
    """
    gc.collect = lambda *_: 0
    if hasattr(gc, "freeze"):  # PyPy's has none
        gc.freeze()


def first_breach(ticks: int, first: int, only: str = "") -> tuple[Outcome | None, int]:
    """The first life that breaks a promise, if any, and how many ticks it took to find it."""
    used = 0
    for seed in itertools.count(first):
        outcome = live(seed, only=only)
        used += outcome.ticks
        if outcome.broken:
            return outcome, used
        if used >= ticks:
            break
    return None, used


def shrink(outcome: Outcome) -> Outcome:
    """The same breach with as few episodes as it takes, its story kept."""
    promise = outcome.broken.partition(":")[0]
    kept = list(range(EPISODES_PER_LIFE))
    for number in range(EPISODES_PER_LIFE):
        tried = [k for k in kept if k != number]
        if live(outcome.seed, frozenset(tried)).broken.partition(":")[0] == promise:
            kept = tried
    return live(outcome.seed, frozenset(kept), log=True)


def main(arguments: list[str]) -> int:
    """Replay, shrink or search: what a person does with a seed."""
    parser = argparse.ArgumentParser(prog="python -m gazeprove.fuzz", description=__doc__)
    parser.add_argument("--seed", type=int, default=1, help="of the first life")
    parser.add_argument("--ticks", type=int, default=200_000, help="until so many were run")
    parser.add_argument("--only", default="", help="no other episode than this")
    parser.add_argument("--replay", action="store_true", help="only this life, shrunk, in words")
    options = parser.parse_args(arguments)
    _prepare()
    if options.replay:
        outcome = live(options.seed)
        if outcome.broken:
            outcome = shrink(outcome)
            print("\n".join(outcome.story))
        print(outcome)
        return 1 if outcome.broken else 0
    found, used = first_breach(options.ticks, options.seed, options.only)
    print(f"{found} after {used} ticks" if found else f"nothing in {used} ticks")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
