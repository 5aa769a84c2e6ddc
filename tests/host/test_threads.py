"""The host's processes run no threads but their own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).parent.parent


@pytest.mark.parametrize("first", ["gazechair", "conftest"])
def test_numpy_starts_no_helper_threads_in_them_or_in_tests(first: str) -> None:
    program = f"""
import os, {first}
import numpy as np
many = np.ones((500, 500))
many @ many
print(len(os.listdir("/proc/self/task")))
"""
    env = {k: v for k, v in os.environ.items() if not k.endswith("_NUM_THREADS")}
    words = [sys.executable, "-c", program]
    done = subprocess.run(words, cwd=TESTS, env=env, capture_output=True, check=True)
    assert done.stdout.strip() == b"1"
