"""Pairing: one code, one device; guessing fails; paired devices survive the host."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from fulldisk import full
from gazechair.people.pairing import Paired, Rejected, StoreError
from gazechair.people.pairing.lockout import WAIT_S
from gazechair.people.pairing.one_time import ALPHABET, LENGTH, MOST_OPEN, VALID_S
from gazechair.people.pairing.store import MOST_DEVICES

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


def test_after_five_wrong_codes_each_guess_waits_a_second(desk: Any) -> None:
    for guess in range(5):
        assert desk.guess(f"2222-222{guess}") == "wrong_code"
    for guess in range(20):
        code = f"3333-33{guess:02}"
        rejected = desk.pair(code, "x", "192.0.2.66")
        assert (rejected.reason, rejected.wait_s) == ("too_many_guesses", WAIT_S)
        desk.now_s += WAIT_S / 2
        assert desk.pair(code, "x", "192.0.2.66").wait_s == WAIT_S / 2
        desk.now_s += WAIT_S / 2
        assert desk.guess(code) == "wrong_code"
        assert desk.guess(code) == "too_many_guesses"  # waits again


def test_an_hour_later_an_address_guesses_freely_again(desk: Any) -> None:
    for _ in range(6):
        desk.guess()
    desk.now_s += 3601
    assert desk.guess() == "wrong_code"


def test_another_address_does_not_wait(desk: Any) -> None:
    for _ in range(8):
        desk.guess()
    assert desk.guess() == "too_many_guesses"
    assert isinstance(desk.join(), Paired)


@pytest.mark.parametrize("tablet", ["192.0.2.66", "192.0.2.1"])
@pytest.mark.parametrize("addresses", [1, 3000])
def test_a_right_code_waits_2_s_at_most_whatever_others_guess(
    desk: Any, tablet: str, addresses: int
) -> None:
    """A guess every millisecond, from the tablet's own address or from 3000 others."""
    code = desk.new_code("driver").text
    began_s = asked_s = -1.0
    for guess in range(6000):
        desk.now_s += 0.001
        by = guess % addresses
        address = "192.0.2.66" if addresses == 1 else f"198.51.{by >> 8}.{by & 255}"
        desk.pair(f"{guess:04}-9999", "x", address)
        if guess < 3000 or desk.now_s < asked_s:
            continue
        began_s = desk.now_s if began_s < 0 else began_s
        paired = desk.pair(code, "tablet", tablet)
        if isinstance(paired, Paired):
            assert desk.now_s - began_s <= 2.0
            return
        asked_s = desk.now_s + paired.wait_s  # as the pairing page does
    pytest.fail("the right code was never looked at")


def test_ten_thousand_guesses_get_nowhere(desk: Any) -> None:
    """Their chance is as calculated; paired devices are not affected."""
    code = desk.new_code("driver").text
    token = desk.join().token
    for guess in range(10_000):
        desk.now_s += 0.06
        desk.guess(f"{guess:04}-9999", f"198.51.{guess >> 8}.{guess & 255}")
        assert desk.who(token) is not None
    desk.now_s += 1
    assert not desk.is_open(code)
    guesses_in_a_code_s_life = 1000 * VALID_S
    assert MOST_OPEN * guesses_in_a_code_s_life / len(ALPHABET) ** LENGTH < 4e-6


def test_what_waits_takes_little_memory(desk: Any) -> None:
    for guess in range(20_000):
        desk.guess(f"{guess:05}-999")
    assert len(desk._lockout._requests) <= 5000


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
    desk.note_uses()
    later = again(tmp_path / "state")
    assert later.who(second.token).name == "tv"
    assert [(d.role, d.last_used - d.created) for d in later.devices()] == [
        ("driver", 7200),
        ("viewer", 0),
    ]


def test_a_revoked_device_is_nobody_for_good(desk: Any, again: Any, tmp_path: Path) -> None:
    paired = desk.join()
    reported: list[str] = []
    desk.on_revoke(reported.append)
    assert desk.is_paired(paired.device.id)
    assert desk.revoke(paired.device.id)
    assert reported == [paired.device.id]
    assert not desk.is_paired(paired.device.id)
    assert desk.who(paired.token) is None
    assert again(tmp_path / "state").who(paired.token) is None
    assert not desk.revoke(paired.device.id)
    assert reported == [paired.device.id]


def test_only_its_user_may_read_the_file(desk: Any, tmp_path: Path) -> None:
    desk.join()
    assert (tmp_path / "state").stat().st_mode & 0o777 == 0o700
    assert (tmp_path / "state" / "paired.jsonl").stat().st_mode & 0o777 == 0o600


def test_too_many_devices_are_refused_in_one_line(desk: Any) -> None:
    for _ in range(MOST_DEVICES):
        desk.join()
    with pytest.raises(StoreError, match="revoke one first"):
        desk.join()


def test_a_code_outlives_a_full_list(desk: Any) -> None:
    devices = [desk.join().device for _ in range(MOST_DEVICES)]
    code = desk.new_code("driver").text
    for _ in range(3):
        with pytest.raises(StoreError, match="revoke one first"):
            desk.pair(code, "tablet", "192.0.2.1")
    desk.revoke(devices[0].id)
    assert isinstance(desk.pair(code, "tablet", "192.0.2.1"), Paired)
    assert desk.guess(code) == "wrong_code"  # used


def test_a_code_outlives_a_full_disk(desk: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    code = desk.new_code("driver").text
    with monkeypatch.context() as disk:
        disk.setattr("os.open", full)
        with pytest.raises(StoreError):
            desk.pair(code, "tablet", "192.0.2.1")
    assert isinstance(desk.pair(code, "tablet", "192.0.2.1"), Paired)


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
        assert not again(tmp_path / "state").is_paired(device.id)


def test_a_disk_that_takes_nothing_pairs_nobody_and_keeps_nobody_out(
    desk: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    old = desk.join()

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
    assert rejected.detail == "too many wrong codes; ask again in 1.0 s"
