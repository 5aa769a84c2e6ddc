"""Runs one board_*.py under MicroPython."""

import subprocess
from pathlib import Path

import gazesetup

TESTS = Path(__file__).resolve().parent
LIMIT_S = 300


def assert_passes(file: Path, micropython: gazesetup.MicroPython, firmware: Path | None) -> None:
    """All tests of the file pass there, with the firmware's modules of the folder `firmware`.

    None: those of the checkout.
    """
    env = gazesetup.source_environment()
    if firmware is not None:
        env["MICROPYPATH"] = f":.frozen:{firmware}:{gazesetup.ROOT / 'tools'}"
    env["MICROPYPATH"] += f":{TESTS}"
    result = subprocess.run(
        [str(micropython.path), "-X", "heapsize=4m", str(TESTS / "boardtest.py"), str(file)],
        env=env,
        cwd=TESTS.parent,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
    )
    assert result.returncode == 0, f"{micropython.description}\n{result.stdout}{result.stderr}"
    assert "0 failed" in result.stdout
