"""On a build machine a skipped test fails; elsewhere it is skipped and says why."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import gazesetup

TESTS = {
    "body": "import pytest\ndef test_it():\n    pytest.skip('no such thing here')\n",
    "mark": "import pytest\n@pytest.mark.skip(reason='no such thing here')\ndef test_it(): pass\n",
    "module": "import pytest\npytest.skip('no such thing here', allow_module_level=True)\n",
    "fixture": "import pytest\n@pytest.fixture\ndef f(): pytest.skip('no such thing here')\n"
    "def test_it(f): pass\n",
}


@pytest.mark.parametrize("ci", ["true", ""])
@pytest.mark.parametrize("how", TESTS)
def test_skip(how: str, ci: str, tmp_path: Path) -> None:
    """Every way to skip, with and without CI=true; the reason is shown in both cases."""
    (tmp_path / "test_skipping.py").write_text(TESTS[how])
    env = dict(os.environ, CI=ci, PYTHONPATH=f"{gazesetup.ROOT / 'tests'}:{gazesetup.ROOT}/tools")
    result = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "conftest", "-rs", "-c", os.devnull, tmp_path],
        env=env,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert "no such thing here" in result.stdout
    if ci:
        assert result.returncode != 0, result.stdout
        assert "nothing may be skipped" in result.stdout
    else:
        assert "1 skipped" in result.stdout
        assert "failed" not in result.stdout
