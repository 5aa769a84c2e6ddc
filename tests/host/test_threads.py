"""The host's processes run no threads but their own."""

import os
import subprocess
import sys


def test_numpy_starts_no_helper_threads_in_them() -> None:
    program = """
import os, gazechair
import numpy as np
many = np.ones((500, 500))
many @ many
print(len(os.listdir("/proc/self/task")))
"""
    env = {k: v for k, v in os.environ.items() if not k.endswith("_NUM_THREADS")}
    words = [sys.executable, "-c", program]
    assert subprocess.run(words, env=env, capture_output=True, check=True).stdout.strip() == b"1"
