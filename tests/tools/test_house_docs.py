"""The pages made from the code are up to date, and say something of every limit."""

from __future__ import annotations

import re

import pytest

from gazehouse import __main__ as command
from gazehouse import failure_pictures, failures, hazards, numbers, rooms
from gazelink.settings_table import TABLE
from gazeprove.safety_texts import PROMISES

# Times that several parts take together: no module reads them, tests measure them.
NOT_READ = {"TILT_MS", "OBEYS_MS"}


@pytest.mark.parametrize("document", command.PAGES, ids=lambda path: path.name)
def test_the_page_is_as_the_code_says(document) -> None:  # type: ignore[no-untyped-def]
    assert document.read_text() == command.PAGES[document](), "stale: run tools/docs"


def test_every_limit_is_enforced_somewhere() -> None:
    code = numbers.Mentions("firmware/**/*.py", "host/**/*.py")
    home = numbers.ROOT / "firmware" / "gazeboard" / "core" / "limits.py"
    unread = {limit.name for limit in numbers.limits() if not code.of(limit.name, [home])}
    assert unread == NOT_READ | numbers.HIGHEST.keys() | numbers.REPEATED.keys()


def test_a_limit_of_another_name_is_the_settings_highest_value_or_the_files_number() -> None:
    limits = {limit.name: int(limit.value) for limit in numbers.limits()}
    highest = {name: high for name, _default, _low, high in TABLE}
    for limit, setting in numbers.HIGHEST.items():
        assert highest[setting] == limits[limit], limit
    for limit, (path, name) in numbers.REPEATED.items():
        text = (numbers.ROOT / path).read_text()
        assert re.findall(rf"^{name} = const\((\d+)\)$", text, re.M) == [str(limits[limit])]


def test_the_boards_own_numbers_are_there_without_places_in_arrays_and_what_only_a_pc_runs() -> (
    None
):
    board = {(n.file.name, n.name): n for n in numbers.board_timings()}
    assert board["teensy40.py", "_WATCHDOG_MS"].value == "500"
    assert board["heading.py", "_DRIFT_Q4"].meaning.startswith("5 degrees between heading")
    for place in ("_REST_MS", "_LEFT_HOLD_MS", "_RIGHT_HOLD_MS", "_FULL_Q4"):
        assert ("obedience.py", place) not in board, place
    assert not {file for file, _name in board} & {"limits.py", "virtual.py", "bank_layout.py"}


def test_an_angle_written_in_degrees_is_a_number_of_the_host() -> None:
    host = {(n.file.name, n.name): n.value for n in numbers.host_timings()}
    assert host["steering.py", "STEER_MOST_RAD"] == "18.0 degrees"
    assert host["untuned.py", "TURN_PERMILLE"] == "600"


def test_what_no_module_reads_is_held_by_a_test() -> None:
    tests = numbers.Mentions("tests/**/*.py")
    assert [name for name in sorted(NOT_READ) if not tests.of(name)] == []


def test_a_comment_beside_or_above_is_the_meaning() -> None:
    found = {limit.name: limit.meaning for limit in numbers.limits()}
    assert found["HOST_SILENT_MS"] == "P2 neutral"
    assert found["OUTERMOST_MM"].startswith("a turn's creep")
    assert found["MARGIN_MS"].startswith("a promise counts from the event")


def test_a_string_below_or_a_comment_of_a_script_is_the_meaning() -> None:
    host = {(n.file.name, n.name): n.meaning for n in numbers.host_timings()}
    assert host["feed.py", "HEADING_LATE_S"].startswith("Age of a heading")
    assert host["bends.py", "MOST_M"].startswith("Shortest and longest tangent")
    assert host["floor_marks.py", "_LINES_M"].startswith("Drawn over the picture, so that")
    pages = {(n.file.name, n.name): n.meaning for n in numbers.page_timings()}
    assert pages["socket.js", "LOST_MS"].startswith("No message from the host for this long")
    assert pages["socket.js", "BEAT_MS"] == ""


def test_a_test_counts_for_the_module_that_it_loads_only() -> None:
    tests = numbers.Tests("tests/**/*.py")
    found = {(n.file.name, n.name): n for n in numbers.host_timings()}
    named = {file.name for file in tests.of_number(found["child.py", "LIMIT_S"])}
    assert named == {"test_alert_routes.py"}
    assert "test_lidar_tools.py" in {
        file.name for file in tests.of_number(found["lidar_tools.py", "_PATIENCE_S"])
    }


def test_every_failure_is_proven_by_tests_there_are_and_each_name_is_one_test() -> None:
    known = failures.homes()
    for failure in failures.FAILURES:
        assert failure.tests, failure.what
        for name in failure.tests:
            assert len(known.get(name, [])) == 1, name


def test_every_failure_that_is_shown_has_its_picture_and_there_are_no_others() -> None:
    shown = {failures.picture(failure) for failure in failures.FAILURES if failure.key}
    assert set(failures.PICTURES.iterdir()) == shown
    assert set(failure_pictures.CAUSES) == {f.what for f in failures.FAILURES if f.key}


def test_every_hazard_names_promises_and_tests_there_are_or_says_that_nothing_prevents_it() -> None:
    known = failures.homes()
    promised = {promise.name for promise in PROMISES}
    for hazard in hazards.HAZARDS:
        assert set(hazard.promises) <= promised, hazard.what
        assert hazard.tests or "all of it" in hazard.remains, hazard.what
        for name in hazard.tests:
            assert len(known.get(name, [])) == 1, name
    assert {name for hazard in hazards.HAZARDS for name in hazard.promises} == promised


def test_every_path_in_the_architecture_exists() -> None:
    text = (numbers.ROOT / "docs" / "architecture.md").read_text()
    rows = [line for line in text.partition("## Where is")[2].splitlines() if "?" in line]
    assert len(rows) >= 20
    for row in rows:
        paths = re.findall(r"`([\w/.-]+(?:\.\w+|/\w+))`", row.split("|")[2])
        assert paths or "entry point" in row, row
        assert [path for path in paths if "/" in path and not (numbers.ROOT / path).exists()] == []


def test_every_file_on_the_way_of_a_glance_a_beam_and_a_turn_exists() -> None:
    text = (numbers.ROOT / "docs" / "architecture.md").read_text()
    ways = text.partition("## One glance")[2].partition("## Where is")[0]
    named = re.findall(r"`([\w/]+\.(?:py|js))`", ways)
    assert len(named) > 30
    folders = ("firmware", "protocol", "host", "web")
    there = [path.as_posix() for one in folders for path in (numbers.ROOT / one).rglob("*.*")]
    assert [name for name in named if not any(path.endswith(f"/{name}") for path in there)] == []


def test_every_package_says_in_a_sentence_what_belongs_in_it() -> None:
    found = dict(rooms.rooms())
    assert len(found) > 50
    assert {
        folder for folder, what in found.items() if not (len(what) > 20 and what[-1] == ".")
    } == set()
