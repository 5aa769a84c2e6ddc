"""Line and branch coverage of the core by its own tests, in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from gazeprove.kill import suite_files
from gazesetup import ROOT, source_environment

_LIMIT_S = 600


@dataclass(frozen=True)
class Covered:
    """Of one module: lines and branches there are, and what was never run."""

    module: str
    lines: int
    branches: int
    missing: tuple[str, ...]


def measure(modules: tuple[str, ...]) -> list[Covered]:
    """Run the core's tests under coverage.py. Raises RuntimeError when they fail."""
    files = [ROOT / "firmware" / "gazeboard" / "core" / f"{name}.py" for name in modules]
    env = source_environment()
    with tempfile.TemporaryDirectory(prefix="gazeprove-") as folder:
        env["COVERAGE_FILE"] = str(Path(folder) / "data")
        report = Path(folder) / "report.json"
        include = "--include=" + ",".join(str(file) for file in files)
        coverage = [sys.executable, "-m", "coverage"]
        pytest = ["-m", "pytest", "-q", "-p", "no:cacheprovider", *map(str, suite_files())]
        for words in (
            [*coverage, "run", "--branch", include, *pytest],
            [*coverage, "json", "-q", "-o", str(report)],
        ):
            done = subprocess.run(
                words, cwd=ROOT, env=env, capture_output=True, text=True, timeout=_LIMIT_S
            )
            if done.returncode != 0:
                raise RuntimeError(f"{' '.join(words[1:4])} failed:\n{done.stdout}{done.stderr}")
        data = json.loads(report.read_text())["files"]
    by_name = {Path(name).stem: found for name, found in data.items()}
    return [_covered(name, by_name[name]) for name in modules]


def _covered(
    module: str, found: dict[str, dict[str, int] | list[int] | list[list[int]]]
) -> Covered:
    summary = found["summary"]
    assert isinstance(summary, dict)
    lines = [f"line {line}" for line in found["missing_lines"]]
    branches = [f"branch {branch}" for branch in found["missing_branches"]]
    return Covered(module, summary["num_statements"], summary["num_branches"], (*lines, *branches))
