"""docs/proof.json says that everything is proven, of the very files that are here."""

from pathlib import Path

import pytest

from gazeprove import part_costly, record, record_file
from gazeprove.parts import PARTS

PART = "mutation"
NONE: dict[str, dict[str, object]] = {"parts": {}, "files": {}}


def test_the_record_proves_what_is_here() -> None:
    """Nothing changed since tools/prove found nothing wrong.

    The costly tests run instead when something did (tools/test).
    """
    said = [record.why_not_now(part) for part in PARTS if part != part_costly.NAME]
    assert not any(said), "\n".join(filter(None, said))


@pytest.mark.parametrize("part", sorted({*PARTS} - {part_costly.NAME}))
def test_it_covers_the_firmware_its_tests_and_the_prover(part: str) -> None:
    """What a part rests upon is in its hash."""
    files = record.files_of(part)
    assert "firmware/gazeboard/core/safety.py" in files
    assert "firmware/gazeboard/core/limits.py" in files
    assert "protocol/gazelink/codes.py" in files
    assert not any("gazesetup" in name for name in files)


def test_it_covers_the_suites_what_they_share_and_the_equivalents() -> None:
    """Mutants are killed by these tests."""
    files = record.files_of(PART)
    for name in ("tests/firmware/board_core_press.py", "tools/gazesim/core_rig.py"):
        assert name in files
    for name in ("equivalent/safety.txt", "equivalents.py", "mutate.py", "kill.py"):
        assert f"tools/gazeprove/{name}" in files


def test_one_changed_character_is_told(tmp_path: Path) -> None:
    """In a sentence, with the file's name."""
    file = tmp_path / "proof.json"
    files = {"core/safety.py": "12", "core/motion.py": "34"}
    record.write(PART, {"mutants": 1}, [], files, file)
    assert record.why_not(PART, record_file.read(file), files) == ""
    said = record.why_not(PART, record_file.read(file), {**files, "core/safety.py": "13"})
    assert said == "mutation: safety.py changed since it was proven: run tools/prove"
    said = record.why_not(PART, record_file.read(file), {"core/motion.py": "34"})
    assert said == "mutation: safety.py changed since it was proven: run tools/prove"


def test_what_fell_short_or_was_never_run_is_not_proven(tmp_path: Path) -> None:
    """Only proved is proved."""
    file = tmp_path / "proof.json"
    record.write(PART, {"mutants": 1}, ["one survived"], {"a.py": "1"}, file)
    assert record.why_not(PART, record_file.read(file), {"a.py": "1"}).endswith(
        "NOT PROVED: one survived"
    )
    assert record.why_not(PART, NONE, {}) == "mutation: never proven: run tools/prove"


def test_a_hash_that_is_not_of_its_files_is_told(tmp_path: Path) -> None:
    """Nobody edits the record by hand."""
    file = tmp_path / "proof.json"
    record.write(PART, {}, [], {"a.py": "1"}, file)
    edited = record_file.read(file)
    edited["files"][edited["parts"][PART]["of"]] = {"a.py": "2"}
    assert "does not fit itself" in record.why_not(PART, edited, {"a.py": "2"})


def test_a_part_updates_its_own_row_only(tmp_path: Path) -> None:
    """The others keep theirs, and the file their files' digests."""
    file = tmp_path / "proof.json"
    record.write("fuzz", {"ticks": 1}, [], {"a.py": "1"}, file)
    record.write(PART, {"mutants": 1}, [], {"b.py": "1"}, file)
    record.write(PART, {"mutants": 2}, [], {"b.py": "2"}, file)
    found = record_file.read(file)
    assert found["parts"]["fuzz"]["figures"] == {"ticks": 1}
    assert found["parts"][PART]["figures"] == {"mutants": 2}
    assert sorted(map(str, found["files"].values())) == ["{'a.py': '1'}", "{'b.py': '2'}"]
    assert [path.name for path in tmp_path.iterdir()] == ["proof.json"]
