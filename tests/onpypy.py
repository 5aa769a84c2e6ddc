"""Runs board_*.py in PyPy, all in one process: what is compiled for one file serves the next.

pypy3 -m onpypy FILE...; as boardtest.py does in MicroPython. What the tests measure is noted as in
pytest (promises.py).
"""

from __future__ import annotations

import gc
import importlib
import sys
import time
import traceback
from pathlib import Path

import promises


def main(files: list[str]) -> int:
    """Run every test of these files; the number of those that failed."""
    # The firmware asks for it once a second of its own time, and in PyPy it takes long.
    gc.collect = lambda *_: 0  # type: ignore[assignment]
    all_failed = 0
    for file in map(Path, files):
        sys.path.insert(0, str(file.parent))
        module = importlib.import_module(file.stem)
        tests = [name for name in vars(module) if name.startswith("test_")]
        assert tests, f"no tests in {file}"
        failed = 0
        start = time.monotonic()
        for name in tests:
            try:
                getattr(module, name)()
            except Exception:
                failed += 1
                print(f"FAILED {file}::{name}\n{traceback.format_exc()}")
        spent_s = time.monotonic() - start
        print(f"{file} {len(tests)} tests, {failed} failed, {spent_s:.1f} s", flush=True)
        all_failed += failed
    promises.pytest_sessionfinish(None)
    return all_failed


if __name__ == "__main__":
    sys.exit(1 if main(sys.argv[1:]) else 0)
