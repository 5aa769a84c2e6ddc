"""Safety mistakes planted in copies of the firmware: the fuzzer must find them.

Each is one change to the source that somebody could make. A snippet that is not found exactly once
is an error: then the firmware has changed, and the mutant has to follow.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from gazesetup import ROOT, source_environment

_LIMIT_S = 900
_BROKEN = re.compile(r"life (\d+), .*, tick ")
_SAFETY = "firmware/gazeboard/core/safety.py"
_AGES = "firmware/gazeboard/core/ages.py"
_LIMITS = "firmware/gazeboard/core/limits.py"
_LINK = "firmware/gazeboard/io/link.py"
_INCOMING = "firmware/gazeboard/io/incoming.py"
_APP = "firmware/gazeboard/app.py"
_MOTION = "firmware/gazeboard/core/motion.py"
_AUTO = "firmware/gazeboard/core/auto.py"
_OBSTACLES = "firmware/gazeboard/core/obstacles.py"


@dataclass(frozen=True)
class Planted:
    """One mistake: in this file, this text becomes that one."""

    name: str
    file: str
    old: str
    new: str
    only: str = ""
    """The only episode of its lives: for what seldom comes about; "" for all."""


PLANTED = (
    Planted(
        "supervision not counted down",
        _AGES,
        "supervised_ms -= 1",
        "supervised_ms -= 0",
        "auto",
    ),
    Planted(
        "supervision of any press",
        _AUTO,
        " or i.supervision_edge != i.edge",
        "",
    ),
    Planted(
        "a planner's value lives like a person's",
        _LIMITS,
        "AUTO_TTL_MS = const(150)",
        "AUTO_TTL_MS = const(300)",
        "auto",
    ),
    Planted(
        "auto as fast as a person",
        _OBSTACLES,
        "self.auto_caps[at] = most if most < cap else cap",
        "self.auto_caps[at] = cap",
    ),
    Planted(
        "overruled for ever",
        _AUTO,
        "_OVERRULED_MS = const(10000)",
        "_OVERRULED_MS = const(1 << 29)",
        "auto",
    ),
    Planted(
        "auto where no lidar sees",
        _OBSTACLES,
        "| i.clearance_unseen & _ALL_BLOCKED",
        "",
    ),
    Planted(
        "auto goes on after a bypass press",
        _INCOMING,
        "if buf[_BYPASS_NUMBER] != back.bypass_number:",
        "if False:",
    ),
    Planted("time to live not counted", _AGES, "ttl_ms -= 1", "ttl_ms -= 0"),
    Planted(
        "sequence not checked",
        _LINK,
        "if not 1 <= (buf[messages.SEQ_AT] - self._last_seq) & 0xFF <= 127:",
        "if False:",
    ),
    Planted(
        "heading faults ignored",
        _AGES,
        "faults |= int(i.heading_faults) & int(codes.HEADING_FAULTS)",
        "faults |= 0",
    ),
    Planted(
        "session not in the seed",
        "protocol/gazelink/frame.py",
        "crc.fill_seed(ids, seed)",
        "crc.fill_seed(ids[:4], seed)",
    ),
    Planted(
        "stale order accepted",
        _INCOMING,
        "elif age_ms > limits.FRAME_STALE_MS:\n            self.late()\n        elif (action",
        "elif False:\n            self.late()\n        elif (action",
    ),
    Planted(
        "output not limited",
        _MOTION,
        "            self._limit(i, verb, blocked, caps, arcs)\n        if faults",
        "            pass\n        if faults",
    ),
    Planted(
        "host silent later", _LIMITS, "HOST_SILENT_MS = const(100)", "HOST_SILENT_MS = const(140)"
    ),
    Planted(
        "emergency forgotten by a reset",
        _APP,
        "boot_faults |= 1 << codes.EMERGENCY",
        "boot_faults |= 0",
    ),
    Planted("wiper tried more often", _LIMITS, "WIPER_TRIES = const(3)", "WIPER_TRIES = const(6)"),
    Planted("owner not checked", _SAFETY, "if i.owner != self.owner:", "if False:"),
    Planted(
        "an ended press goes on",
        _SAFETY,
        "            self.spent_edge = self.edge\n            self.edge = 0",
        "            self.edge = 0",
    ),
    Planted(
        "age of the clearance ignored",
        _AGES,
        "w[CLEARANCE] = int(i.clearance_age_ms)",
        "w[CLEARANCE] = 0",
    ),
    Planted(
        "enable line toggled after a failed write",
        _SAFETY,
        "                self.trip(codes.WIPER)\n            return False",
        "                self.trip(codes.WIPER)\n            return self.enable",
    ),
    Planted("stop of others ignored", _SAFETY, "if stopped or stops:", "if False:"),
    Planted("tilt ignored", _AGES, "faults |= 1 << int(codes.TILT)", "faults |= 0"),
    Planted(
        "service stalled later",
        _LIMITS,
        "SERVICE_STALLED_MS = const(50)",
        "SERVICE_STALLED_MS = const(75)",
    ),
    Planted(
        "late ticks unseen",
        "firmware/gazeboard/core/tick.py",
        "late = clock.late",
        "late = False",
    ),
    Planted(
        "the driver resets faults",
        _INCOMING,
        "action == codes.RESET_FAULTS and owner != codes.CARETAKER",
        "action == codes.RESET_FAULTS and False",
    ),
    Planted(
        "arming without proof of neutral",
        _LIMITS,
        "NEUTRAL_PROVEN_MS = const(500)",
        "NEUTRAL_PROVEN_MS = const(5)",
    ),
    Planted(
        "blocked ways driven", _SAFETY, "return codes.OBSTACLE_FORWARD + direction", "return 0"
    ),
    Planted(
        "armed with a relay that opened",
        _LIMITS,
        "RELAY_RELEASE_MS = const(25)",
        "RELAY_RELEASE_MS = const(250)",
    ),
    Planted(
        "an exception leaves it armed",
        _SAFETY,
        "self.trip(codes.TICK_EXCEPTION)",
        "pass",
    ),
    Planted(
        "time without ticks not counted",
        "firmware/gazeboard/core/tick_clock.py",
        "return owed_us // _TICK_US",
        "return 0",
    ),
    Planted(
        "time without ticks not counted in a step",
        _MOTION,
        "elapsed_ms = self._elapsed_ms + 1 + missed_ms",
        "elapsed_ms = self._elapsed_ms + 1",
        "other_pace",
    ),
    Planted(
        "any save makes a neutral calibrated",
        "firmware/gazeboard/io/settings.py",
        "if self.calibrated or self._measured == _BOTH:",
        "if True:",
        "settings",
    ),
    Planted(
        "tilt of a dead sensor unknown for ever",
        "firmware/gazeboard/core/tilt.py",
        "            self.unknown = True",
        "            self.unknown = False",
    ),
)


@dataclass(frozen=True)
class Found:
    """What the fuzzer said to one planted mistake."""

    name: str
    output: str
    seconds: float
    life: int  # the first that broke a promise; 0: none did

    def __str__(self) -> str:
        return f"{self.name}: {self.output} ({self.seconds:.1f} s)"


def plant(planted: Planted, folder: Path) -> list[str]:
    """Copy the firmware with this mistake; the source roots. Raises ValueError when it has gone."""
    text = (ROOT / planted.file).read_text()
    if text.count(planted.old) != 1:
        raise ValueError(f"{planted.name}: its text is not once in {planted.file}")
    roots = []
    for name in ("protocol", "firmware"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        roots.append(str(folder / name))
    (folder / planted.file).write_text(text.replace(planted.old, planted.new))
    return roots


def find(planted: Planted, ticks: int, first: int, known: int = 0) -> Found:
    """Fuzz a copy with this mistake, from life `first` on, so many ticks at most.

    `known`: of those lives the one that broke a promise before, which is run before all others.
    """
    started = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="gazefuzz-") as folder:
        env = source_environment()
        env["PYTHONPATH"] = os.pathsep.join((*plant(planted, Path(folder)), env["PYTHONPATH"]))
        output, life = _fuzz(planted.only, env, known, 1) if known else ("", 0)
        if not life:
            output, life = _fuzz(planted.only, env, first, ticks)
    return Found(planted.name, output, time.monotonic() - started, life)


def _fuzz(only: str, env: dict[str, str], first: int, ticks: int) -> tuple[str, int]:
    """What the fuzzer says at last, and the life that broke a promise; 0 when none did."""
    words = [sys.executable, "-m", "gazeprove.fuzz", "--seed", str(first), "--ticks", str(ticks)]
    done = subprocess.run(
        [*words, "--only", only], env=env, capture_output=True, text=True, timeout=_LIMIT_S
    )
    output = (done.stdout + done.stderr).strip().splitlines()[-1]
    life = _BROKEN.match(output)
    return output, int(life[1]) if done.returncode == 1 and life else 0
