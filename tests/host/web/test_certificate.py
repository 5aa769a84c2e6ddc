"""The host's certificate: made once, kept, renewed, and an error when that is impossible."""

from __future__ import annotations

import errno
import logging
import os
import ssl
import subprocess
from pathlib import Path

import pytest

from gazechair.base.clock import EARLIEST_S
from gazechair.config.settings import WebConfig
from gazechair.web import certificate
from gazechair.web.certificate import Certificate, CertificateError
from gazechair.web.names import certificate_names, network_addresses, shown_host

NAMES = ["chair.local", "127.0.0.1", "::1"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A state folder with a certificate in it."""
    folder = tmp_path_factory.mktemp("state")
    Certificate(folder, NAMES)
    return folder


def test_it_is_kept_from_start_to_start(folder: Path) -> None:
    before = (folder / "tls" / "host.crt").read_bytes()
    again = Certificate(folder, NAMES)
    assert (folder / "tls" / "host.crt").read_bytes() == before
    assert again.context().minimum_version.name == "TLSv1_2"
    assert again.authority.read_text().startswith("-----BEGIN CERTIFICATE-----")


def test_a_new_name_is_said_and_changes_nothing(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    before = (folder / "tls" / "host.crt").read_bytes()
    with caplog.at_level(logging.WARNING):
        Certificate(folder, [*NAMES, "192.0.2.9"])
    assert "does not name 192.0.2.9; remove that folder" in caplog.text
    assert (folder / "tls" / "host.crt").read_bytes() == before


def dates(folder: Path, name: str = "host.crt") -> tuple[float, float]:
    """From when to when it is valid."""
    words = ["openssl", "x509", "-in", folder / "tls" / name, "-noout", "-startdate", "-enddate"]
    lines = subprocess.run(words, capture_output=True, text=True, check=True).stdout.splitlines()
    begin_s, end_s = (ssl.cert_time_to_seconds(line.partition("=")[2]) for line in lines)
    return begin_s, end_s


def at(folder: Path, now_s: float, trusted: bool) -> bytes:
    """The certificate after a start at that time of day."""
    Certificate(folder, NAMES, lambda: now_s, lambda: trusted)
    return (folder / "tls" / "host.crt").read_bytes()


DAY_S = 86_400
NOW_S = EARLIEST_S + 300 * DAY_S
LASTS_S = certificate.DAYS * DAY_S
LONG_AGO_S, FAR_AHEAD_S = 1e9, NOW_S + 400 * DAY_S


def test_its_dates_are_of_a_clock_that_was_set_or_fixed(tmp_path: Path) -> None:
    for folder, now_s, trusted, begin_s in (
        ("set", NOW_S, True, NOW_S - DAY_S),
        ("behind", LONG_AGO_S, False, EARLIEST_S),
        ("said to be set", LONG_AGO_S, True, EARLIEST_S),
        ("ahead", FAR_AHEAD_S, False, EARLIEST_S),
        ("fixed dates are over", NOW_S + LASTS_S, False, NOW_S + LASTS_S - DAY_S),
    ):
        at(tmp_path / folder, now_s, trusted)
        for name in ("host.crt", "authority.crt"):
            assert dates(tmp_path / folder, name) == (begin_s, begin_s + LASTS_S), folder


@pytest.mark.parametrize("trusted", [True, False], ids=["set", "of a computer just switched on"])
def test_one_that_ends_soon_is_made_anew_but_not_by_a_clock_that_is_far_off(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, trusted: bool
) -> None:
    before = at(tmp_path, NOW_S, True)
    caplog.clear()
    soon_s = dates(tmp_path)[1] - 13 * DAY_S
    with caplog.at_level(logging.WARNING):
        assert at(tmp_path, FAR_AHEAD_S, False) == at(tmp_path, LONG_AGO_S, True) == before
        assert "by a clock that nobody set" in caplog.text
        assert "must trust" not in caplog.text
        assert at(tmp_path, soon_s, trusted) != before
    assert "must trust" in caplog.text
    assert dates(tmp_path) == (soon_s - DAY_S, soon_s - DAY_S + LASTS_S)
    assert list((tmp_path / "tls").glob("authority.key")) == []


def test_one_that_ends_soon_serves_until_the_disk_takes_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """A full disk must not leave a family without its chair."""
    first = at(tmp_path, NOW_S, trusted=True)
    soon_s = NOW_S + LASTS_S - 10 * DAY_S

    def full(*_: object, **_more: object) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_text", full)
        assert at(tmp_path, soon_s, trusted=True) == first
        assert "No space left on device" in caplog.text
        with pytest.raises(CertificateError, match="No space left on device"):
            at(tmp_path / "new", soon_s, trusted=True)
    assert at(tmp_path, soon_s, trusted=True) != first


def test_one_that_begins_later_is_made_anew(tmp_path: Path) -> None:
    before = at(tmp_path, FAR_AHEAD_S, True)
    assert at(tmp_path, NOW_S, True) != before


YEARS_AHEAD_S = EARLIEST_S + 1500 * DAY_S


def test_one_by_a_clock_that_was_years_ahead_is_made_anew_without_a_network(
    tmp_path: Path,
) -> None:
    ahead = at(tmp_path, YEARS_AHEAD_S, False)
    assert dates(tmp_path)[0] > NOW_S
    assert at(tmp_path, LONG_AGO_S, False) == ahead  # says nothing
    healed = at(tmp_path, NOW_S, False)
    assert healed != ahead
    begin_s, end_s = dates(tmp_path)
    assert begin_s <= NOW_S < end_s
    for now_s in (NOW_S + DAY_S, YEARS_AHEAD_S, LONG_AGO_S):
        assert at(tmp_path, now_s, False) == healed


def test_dates_that_a_set_clock_has_confirmed_are_kept_from_one_that_is_behind(
    tmp_path: Path,
) -> None:
    made = at(tmp_path, YEARS_AHEAD_S, False)
    assert at(tmp_path, YEARS_AHEAD_S + DAY_S, True) == made
    assert at(tmp_path, NOW_S, False) == made


@pytest.mark.parametrize("error", [FileNotFoundError(), PermissionError(), None])
def test_one_that_cannot_be_checked_is_kept(
    folder: Path, monkeypatch: pytest.MonkeyPatch, error: OSError | None
) -> None:
    before = (folder / "tls" / "host.crt").read_bytes()

    def fails(*_: object, **__: object) -> None:
        raise error or subprocess.TimeoutExpired("openssl", 30)

    monkeypatch.setattr(certificate.subprocess, "run", fails)
    assert at(folder, 4 * NOW_S, True) == before


def test_an_authority_that_is_damaged_or_another_s_is_noticed(tmp_path: Path) -> None:
    before = at(tmp_path, NOW_S, True)
    authority = tmp_path / "tls" / "authority.crt"
    authority.write_bytes(b"\xff" * 100)
    again = at(tmp_path, NOW_S, True)
    assert again != before
    at(tmp_path / "other", NOW_S, True)
    authority.write_bytes((tmp_path / "other" / "tls" / "authority.crt").read_bytes())
    assert at(tmp_path, NOW_S, True) != again


def test_one_of_before_is_kept(tmp_path: Path) -> None:
    """As earlier versions made it: by another command, with one more extension."""
    at(tmp_path, NOW_S, True)
    tls = tmp_path / "tls"
    curve = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]
    request = ["req", *curve]
    authority = [
        "-x509",
        "-subj",
        "/CN=gazechair on chair",
        "-days",
        "820",
        "-keyout",
        "a.key",
        "-out",
        "authority.crt",
    ]
    sign = ["-CA", "authority.crt", "-CAkey", "a.key", "-CAcreateserial", "-days", "820"]
    for words in (
        [*request, *authority, "-addext", "keyUsage=critical,keyCertSign"],
        [*request, "-new", "-subj", "/CN=chair", "-keyout", "host.key", "-out", "h.csr"],
        ["x509", "-req", "-in", "h.csr", "-out", "host.crt", *sign],
    ):
        subprocess.run(["openssl", *words], cwd=tls, check=True, capture_output=True)
    before = (tls / "host.crt").read_bytes()
    assert at(tmp_path, sum(dates(tmp_path)) / 2, True) == before


def test_half_a_certificate_is_made_whole(tmp_path: Path) -> None:
    Certificate(tmp_path, NAMES)
    (tmp_path / "tls" / "host.key").unlink()
    (tmp_path / "tls.new").mkdir()  # left by a host that was killed at it
    assert Certificate(tmp_path, NAMES).context()


@pytest.mark.parametrize("place", ["tls", "tls.new"])
@pytest.mark.parametrize("link", [False, True])
def test_what_is_no_folder_in_its_place_is_set_aside(
    tmp_path: Path, place: str, link: bool
) -> None:
    (tmp_path / "something").write_bytes(b"\xff" * 100)
    if link:
        (tmp_path / place).symlink_to(tmp_path / "nowhere")
    else:
        (tmp_path / "something").rename(tmp_path / place)
    Certificate(tmp_path, NAMES).context()
    aside = tmp_path / "tls.damaged"
    assert aside.is_symlink() if link else aside.read_bytes() == b"\xff" * 100
    assert not (tmp_path / "tls.new").exists()


def test_a_damaged_key_is_one_plain_line(tmp_path: Path) -> None:
    made = Certificate(tmp_path, NAMES)
    (tmp_path / "tls" / "host.key").write_text("no key")
    with pytest.raises(CertificateError, match=r"is damaged .*; remove that folder"):
        made.context()


def test_a_damaged_one_is_made_anew_at_the_next_start(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    Certificate(tmp_path, NAMES)
    for name in ("host.key", "names.txt", "host.crt"):
        (tmp_path / "tls" / name).write_bytes(b"\xff" * 100)
        assert Certificate(tmp_path, NAMES).context()
    assert "must trust" in caplog.text


@pytest.mark.parametrize("name", ["host.key", "host.crt", "authority.crt", "names.txt"])
@pytest.mark.parametrize("error", [errno.EACCES, errno.EIO], ids=["denied", "disk"])
def test_one_that_cannot_be_read_ends_the_start_and_is_kept(
    folder: Path, monkeypatch: pytest.MonkeyPatch, name: str, error: int
) -> None:
    tls = folder / "tls"
    before = {path: path.read_bytes() for path in tls.iterdir()}
    load, read = ssl.SSLContext.load_cert_chain, Path.read_bytes

    def fails(*files: object) -> None:
        if tls / name in files:
            raise OSError(error, os.strerror(error))

    def loads(context: ssl.SSLContext, certificate: Path, key: Path) -> None:
        fails(certificate, key)
        load(context, certificate, key)

    def reads(path: Path) -> bytes:
        fails(path)
        return read(path)

    with monkeypatch.context() as patch:
        patch.setattr(ssl.SSLContext, "load_cert_chain", loads)
        patch.setattr(Path, "read_bytes", reads)
        with pytest.raises(CertificateError, match=r"cannot be read \(.*\); make it readable"):
            Certificate(folder, NAMES)
    assert {path: path.read_bytes() for path in tls.iterdir()} == before


def test_a_key_that_the_server_may_not_load_is_kept(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = (folder / "tls" / "host.crt").read_bytes()

    def denied(*_: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(ssl.SSLContext, "load_cert_chain", denied)
    with pytest.raises(CertificateError, match="cannot be read"):
        Certificate(folder, NAMES)
    assert (folder / "tls" / "host.crt").read_bytes() == before


def test_without_openssl_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(CertificateError, match="apt install openssl"):
        Certificate(tmp_path, NAMES)


def test_a_folder_that_cannot_be_written_is_one_plain_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(CertificateError, match="is it writable"):
        Certificate(tmp_path / "file", NAMES)


def test_it_names_every_way_to_reach_this_machine() -> None:
    names = certificate_names(WebConfig(host="0.0.0.0", name="chair.local"))
    assert names[0] == "chair.local"
    assert {"localhost", "127.0.0.1", *network_addresses()} <= set(names)
    assert len(names) == len(set(names))
    assert certificate_names(WebConfig(host="192.0.2.4"))[-1] == "192.0.2.4"


@pytest.mark.parametrize(
    ("web", "shown"),
    [
        (WebConfig(), "127.0.0.1"),
        (WebConfig(host="::1"), "[::1]"),
        (WebConfig(host="0.0.0.0", name="chair.local"), "chair.local"),
    ],
)
def test_the_address_shown_is_one_to_open(web: WebConfig, shown: str) -> None:
    assert shown_host(web) == shown


def test_without_a_name_a_network_address_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gazechair.web.names.network_addresses", lambda: ["192.0.2.7"])
    assert shown_host(WebConfig(host="0.0.0.0")) == "192.0.2.7"
