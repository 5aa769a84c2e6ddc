"""The diary of alerts: bounded, whole after a power cut at any byte."""

from __future__ import annotations

from pathlib import Path

import pytest

from gazechair.alerts.book import MOST_ALERTS, Book, Route
from gazechair.alerts.diary import FILE_NAME, MOST_BYTES, Diary
from gazechair.alerts.reasons import HELP_WANTED, TRIED


def rows(count: int = 3) -> list[dict[str, object]]:
    book = Book([Route("zus")])
    for number in range(count):
        at_s = 100.0 * number
        book.raise_("alert_help", at_s, at_s, "Ik zit vast in het park\u2028één")
        book.end("alert_help", at_s)
    return book.as_json()


def test_what_was_written_is_read(tmp_path: Path) -> None:
    assert Diary(tmp_path).read() == []
    assert Diary(tmp_path / "new").write(rows())
    assert Diary(tmp_path / "new").read() == rows()
    assert (tmp_path / "new" / FILE_NAME).stat().st_mode & 0o777 == 0o600


def test_cut_at_any_byte_an_alert_is_there_whole_or_not_at_all(tmp_path: Path) -> None:
    diary = Diary(tmp_path)
    diary.write(rows())
    file = tmp_path / FILE_NAME
    whole = file.read_bytes()
    ends = [at for at, byte in enumerate(whole) if byte == ord("\n")]
    for at in range(len(whole)):
        file.write_bytes(whole[:at])
        found = diary.read()
        # The line's end may be missing, nothing else.
        assert found == rows()[: sum(at >= end for end in ends)]
        book = Book([Route("zus")])
        book.restore(found, 0.0, 0.0)
        assert len(book.as_json()) == len(found)


def test_cut_while_it_is_replaced_the_old_one_stays(tmp_path: Path) -> None:
    diary = Diary(tmp_path)
    diary.write(rows(2))
    content = (tmp_path / FILE_NAME).read_bytes()
    for at in range(0, len(content), 7):
        (tmp_path / f"{FILE_NAME}.new").write_bytes(content[:at])
        assert diary.read() == rows(2)
    assert diary.write(rows(3))
    assert diary.read() == rows(3)


@pytest.mark.parametrize("damage", [b"\xff\xfe{", b"[1, 2]\n", b"[" * 100_000])
def test_what_is_damaged_is_left_out(tmp_path: Path, damage: bytes) -> None:
    diary = Diary(tmp_path)
    diary.write(rows(1))
    file = tmp_path / FILE_NAME
    file.write_bytes(damage + b"\n" + file.read_bytes())
    assert diary.read() == rows(1)


def test_the_oldest_go_first(tmp_path: Path) -> None:
    diary = Diary(tmp_path)
    many = [{**row, "detail": "x" * 2000} for row in rows(MOST_ALERTS)]
    assert diary.write(many)
    assert (tmp_path / FILE_NAME).stat().st_size <= MOST_BYTES
    found = diary.read()
    assert found == many[-len(found) :]
    assert len(found) > 40


def test_an_open_alert_outlives_those_that_are_over(tmp_path: Path) -> None:
    diary = Diary(tmp_path)
    many: list[dict[str, object]] = [{**row, "detail": "x" * 2000} for row in rows(MOST_ALERTS)]
    many[0]["state"], many[1]["state"] = "open", "acknowledged"
    assert diary.write(many)
    assert (tmp_path / FILE_NAME).stat().st_size <= MOST_BYTES
    found = diary.read()
    assert found == [*many[:2], *many[2 - len(found) :]]
    every = [{**row, "state": "open"} for row in many]
    assert diary.write(every)
    assert diary.read() == every[-len(found) :]


def test_text_takes_the_bytes_of_its_letters_and_any_text_is_read_again(tmp_path: Path) -> None:
    diary = Diary(tmp_path)
    many = [{**row, "sentence": "нужна помощь, " * 20} for row in rows(MOST_ALERTS)]
    assert diary.write(many)
    assert diary.read() == many
    odd = [{**many[0], "sentence": "\r\n\x85\u2028\x1c\ud800\\"}]
    assert diary.write(odd)
    assert diary.read() == odd


def test_a_disk_that_refuses_is_said_and_nothing_else(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").touch()
    assert not Diary(tmp_path / "file").write(rows())
    assert "alerts are not kept" in caplog.text
    assert Diary(tmp_path / "file").read() == []


def test_a_damaged_diary_that_somebody_deletes_is_written_anew(tmp_path: Path) -> None:
    (tmp_path / FILE_NAME).write_text("no JSON\n")
    diary = Diary(tmp_path)
    assert diary.read() == []
    (tmp_path / FILE_NAME).unlink()
    assert diary.write(rows())
    assert diary.read() == rows()


def test_a_test_that_was_not_sent_before_the_host_ended_has_failed(tmp_path: Path) -> None:
    book = Book([Route("a")])
    book.raise_(TRIED, 0.0, 0.0)
    Diary(tmp_path).write(book.as_json())
    again = Book([Route("a")])
    again.restore(Diary(tmp_path).read(), 0.0, 0.0)
    assert again.due(300.0) == []
    delivery = again.as_json()[0]["deliveries"]["a"]
    assert (delivery["state"], delivery["detail"][:22]) == ("failed", "the host was restarted")


def test_results_of_tests_and_of_what_is_over_outlive_the_host_and_their_routes(
    tmp_path: Path,
) -> None:
    book = Book([Route("old")])
    for number, (key, problem) in enumerate(((TRIED, "no network"), (HELP_WANTED, "")), 1):
        book.raise_(key, 0.0, 0.0)
        assert [route.name for _, route in book.due(0.0)] == ["old"]
        book.result(number, "old", problem, 0.0)
        book.end(key, 0.0)
    Diary(tmp_path).write(book.as_json())
    again = Book([Route("new")])
    again.restore(Diary(tmp_path).read(), 0.0, 0.0)
    assert again.due(300.0) == []
    assert again.as_json() == book.as_json()
    assert [row["deliveries"]["old"]["state"] for row in again.as_json()] == ["failed", "sent"]
    for key in (TRIED, HELP_WANTED):
        again.raise_(key, 300.0, 300.0)
    assert [route.name for _, route in again.due(300.0)] == ["new", "new"]
