"""The host's certificate: made once, kept, renewed, and an error when that is impossible."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest

from gazechair.config.configuration import WebConfig
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


def test_one_that_ends_soon_is_made_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(certificate, "DAYS", 10)
    Certificate(tmp_path, NAMES)
    before = (tmp_path / "tls" / "host.crt").read_bytes()
    monkeypatch.setattr(certificate, "DAYS", 820)
    with caplog.at_level(logging.WARNING):
        Certificate(tmp_path, NAMES)
    assert (tmp_path / "tls" / "host.crt").read_bytes() != before
    assert "must trust" in caplog.text
    assert list((tmp_path / "tls").glob("authority.key")) == []


def test_half_a_certificate_is_made_whole(tmp_path: Path) -> None:
    Certificate(tmp_path, NAMES)
    (tmp_path / "tls" / "host.key").unlink()
    (tmp_path / "tls.new").mkdir()  # left by a host that was killed at it
    assert Certificate(tmp_path, NAMES).context()


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
