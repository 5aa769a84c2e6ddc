"""Pairing: one code, one device; guessing gets nowhere; what is known outlives the host."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from gazechair.pairing import Paired, Rejected, StoreError
from gazechair.pairing.one_time import ALPHABET
from gazechair.pairing.store import MOST_DEVICES

# Codes


def test_a_code_makes_one_device_of_its_role(desk: Any) -> None:
    code = desk.new_code("caretaker").text
    assert len(code) == 9
    assert set(code) <= {*ALPHABET, "-"}
    paired = desk.pair(code, "  my phone\n", "192.0.2.1")
    assert isinstance(paired, Paired)
    assert (paired.device.role, paired.device.name) == ("caretaker", "my phone")
    assert desk.who(paired.token) == paired.device
    assert desk.guess(code) == "wrong_code"  # used


def test_how_a_code_is_typed_does_not_matter(desk: Any) -> None:
    typed = desk.new_code("driver").text.lower().replace("-", " ")
    assert isinstance(desk.pair(typed, "", "192.0.2.1"), Paired)


def test_a_late_code_is_worth_nothing(desk: Any) -> None:
    code = desk.new_code("driver")
    desk.now_s = code.ends_s - 0.1
    assert desk.is_open(code.text)
    desk.now_s = code.ends_s
    assert not desk.is_open(code.text)
    assert desk.guess(code.text) == "wrong_code"


def test_too_many_open_codes_close_the_oldest(desk: Any) -> None:
    codes = [desk.new_code("driver").text for _ in range(6)]
    assert [desk.is_open(code) for code in codes] == [False, False, True, True, True, True]


def test_a_device_without_a_name_is_called_by_its_role(desk: Any) -> None:
    assert desk.join(name=" \t").device.name == "driver"
    assert len(desk.join(name="x" * 500).device.name) == 40


# Guessing


def test_five_wrong_codes_lock_an_address_out_longer_and_longer(desk: Any) -> None:
    waits = []
    for _ in range(4):
        desk.now_s += 2
        assert desk.guess() == "wrong_code"
    for _ in range(6):
        desk.now_s += 2
        assert desk.guess() == "wrong_code"
        rejected = desk.pair("3333-3333", "x", "192.0.2.66")
        assert rejected.reason == "too_many_guesses"
        waits.append(round(rejected.wait_s))
        desk.now_s += rejected.wait_s
    assert waits == [60, 120, 240, 480, 900, 900]


def test_another_address_is_not_locked_out(desk: Any) -> None:
    for _ in range(8):
        desk.guess()
    desk.now_s += 10
    assert desk.guess() == "too_many_guesses"
    assert isinstance(desk.join(), Paired)


def test_ten_thousand_guesses_get_nowhere(desk: Any) -> None:
    """Of 10,000 guesses from 10,000 addresses within 10 minutes, at most 310 are looked at."""
    code = desk.new_code("driver").text
    token = desk.join().token
    looked_at = 0
    for guess in range(10_000):
        desk.now_s += 0.06
        address = f"198.51.{guess >> 8}.{guess & 255}"
        looked_at += desk.guess(f"{guess:04}-9999", address) == "wrong_code"
        assert desk.who(token) is not None  # the paired are not concerned
    assert looked_at <= 310
    desk.now_s += 1
    assert not desk.is_open(code)
    assert len(ALPHABET) ** 8 > 6.5e11


def test_one_ipv6_network_is_one_guesser(desk: Any) -> None:
    for guess in range(5):
        assert desk.guess(address=f"2001:db8::{guess}") == "wrong_code"
    assert desk.guess(address="2001:db8::77") == "too_many_guesses"
    assert desk.guess(address="::ffff:192.0.2.66") == "wrong_code"
    assert desk.guess(address="not an address") == "wrong_code"


def test_a_right_code_forgives_what_was_typed_wrong_before(desk: Any) -> None:
    code = desk.new_code("driver").text
    for _ in range(4):
        desk.guess(address="192.0.2.1")
    assert isinstance(desk.pair(code, "", "192.0.2.1"), Paired)
    desk.now_s += 60
    for _ in range(4):
        assert desk.guess(address="192.0.2.1") == "wrong_code"


# Devices


def test_a_token_is_256_random_bits_kept_only_as_a_hash(desk: Any, tmp_path: Path) -> None:
    token = desk.join().token
    assert len(token) == 43  # 32 bytes in base64
    text = (tmp_path / "state" / "paired.jsonl").read_text()
    assert token not in text
    kept = json.loads(text)
    assert set(kept) == {"id", "role", "name", "created", "last_used", "digest"}
    assert len(kept["digest"]) == 64


@pytest.mark.parametrize("token", ["", "x", "a" * 43, "é"])
def test_a_made_up_token_is_nobodys(desk: Any, token: str) -> None:
    desk.join()
    assert desk.who(token) is None


def test_devices_outlive_the_host(desk: Any, again: Any, tmp_path: Path) -> None:
    first, second = desk.join("driver", "tablet"), desk.join("viewer", "tv")
    desk.wall_s += 7200
    desk.who(first.token)
    later = again(tmp_path / "state")
    assert later.who(second.token).name == "tv"
    assert [(d.role, d.last_used - d.created) for d in later.devices()] == [
        ("driver", 7200),
        ("viewer", 0),
    ]


def test_a_revoked_device_is_nobody_for_good(desk: Any, again: Any, tmp_path: Path) -> None:
    paired = desk.join()
    told: list[str] = []
    desk.on_revoke(told.append)
    assert desk.knows(paired.device.id)
    assert desk.revoke(paired.device.id)
    assert told == [paired.device.id]
    assert not desk.knows(paired.device.id)
    assert desk.who(paired.token) is None
    assert again(tmp_path / "state").who(paired.token) is None
    assert not desk.revoke(paired.device.id)
    assert told == [paired.device.id]


def test_only_its_user_may_read_the_file(desk: Any, tmp_path: Path) -> None:
    desk.join()
    assert (tmp_path / "state").stat().st_mode & 0o777 == 0o700
    assert (tmp_path / "state" / "paired.jsonl").stat().st_mode & 0o777 == 0o600


def test_too_many_devices_are_refused_in_one_line(desk: Any) -> None:
    for _ in range(MOST_DEVICES):
        desk.now_s += 2
        desk.join()
    desk.now_s += 2
    with pytest.raises(StoreError, match="revoke one first"):
        desk.join()


@pytest.mark.parametrize(
    "line",
    ["{", "[]", "7", "\udcff", '{"id": "aa"}', "x" * 3000],
)
def test_a_damaged_line_is_kept_and_counts_for_nothing(
    line: str, desk: Any, again: Any, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    token = desk.join().token
    path = tmp_path / "state" / "paired.jsonl"
    path.write_text(line + "\n" + path.read_text(), errors="replace")
    later = again(tmp_path / "state")
    assert "1 is no paired device" in caplog.text
    assert later.who(token) is not None
    later.join()
    assert len(path.read_text().splitlines()) == 3


def test_wrong_types_in_a_line_count_for_nothing(desk: Any, again: Any, tmp_path: Path) -> None:
    device = desk.join().device
    path = tmp_path / "state" / "paired.jsonl"
    good = json.loads(path.read_text())
    for change in ({"role": "king"}, {"created": "now"}, {"digest": 5}, {"more": 1}):
        path.write_text(json.dumps({**good, **change}) + "\n")
        assert not again(tmp_path / "state").knows(device.id)


def test_a_disk_that_takes_nothing_pairs_nobody_and_keeps_nobody_out(
    desk: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    old = desk.join()

    def full(*_: object) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.open", full)
    with pytest.raises(StoreError, match="No space left on device; is the disk full"):
        desk.join()
    desk.wall_s += 90_000
    assert desk.who(old.token) is not None
    assert len(desk.devices()) == 1


def test_a_folder_that_cannot_be_made_is_one_plain_line(again: Any, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(StoreError, match="Not a directory; who owns the folder"):
        again(tmp_path / "file" / "state")


def test_rejections_say_how_long_to_wait(desk: Any) -> None:
    for _ in range(5):
        desk.guess()
    rejected = desk.pair("2222-2222", "x", "192.0.2.66")
    assert isinstance(rejected, Rejected)
    assert rejected.detail == "too many wrong codes; try again in 60 s"
