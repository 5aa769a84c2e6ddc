"""mpy-cross: which boards accept its output, and its refusals."""

from pathlib import Path

import pytest

from gazechair.service.flash import compiler
from gazechair.service.flash.errors import FlashError

SAYS = "#!/bin/sh\necho 'MicroPython v1.29.0; mpy-cross emitting mpy v6.3'\n"


def program(folder: Path, text: str) -> str:
    file = folder / "mpy-cross"
    file.write_text(text)
    file.chmod(0o755)
    return str(file)


@pytest.mark.parametrize(
    ("mpy", "fits"),
    [
        (6 | 3 << 8 | 8 << 10, True),
        (6 | 2 << 8 | 8 << 10, False),  # another sub-version: native code differs
        (5 | 3 << 8 | 8 << 10, False),
        (6 | 3 << 8 | 1 << 10, False),  # another processor
        (0, False),
    ],
)
def test_fits_boards_of_its_version_and_processor_only(
    tmp_path: Path, mpy: int, fits: bool
) -> None:
    assert compiler.Compiler(program(tmp_path, SAYS)).fits(mpy) is fits


def test_a_program_that_tells_no_version_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FlashError, match=r"does not say which \.mpy version"):
        compiler.Compiler(program(tmp_path, "#!/bin/sh\necho hello\n"))


def test_a_program_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FlashError, match="mpy-cross cannot be run"):
        compiler.Compiler(str(tmp_path / "none"))


def test_a_source_it_refuses_is_named(tmp_path: Path) -> None:
    says = SAYS + 'case "$1" in --version) ;; *) echo "SyntaxError: bad" >&2; exit 1;; esac\n'
    with pytest.raises(FlashError, match=r"mpy-cross refuses .*app\.py: SyntaxError: bad"):
        compiler.Compiler(program(tmp_path, says)).compile(tmp_path / "app.py", "app.py")
