"""What the set-up reads from the machine's own apt sources."""

import hashlib
import os
import time
from http.client import IncompleteRead
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gazesetup import apt
from gazesetup.progress import NotAvailable

DEB822 = """\
# installed by the image
Types: deb deb-src
URIs: http://one.example/debian
  http://two.example/debian
Suites: bookworm bookworm-updates
Components: main contrib
Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg

Types: deb
URIs: http://one.example/debian-security
Suites: bookworm-security
Components: main

Types: deb-src
URIs: http://sources.example/debian
Suites: bookworm
Components: main

Enabled: no
Types: deb
URIs: http://off.example/debian
Suites: bookworm
Components: main
"""
ONE_LINE = """\
# deb http://commented.example/debian bookworm main
deb http://plain.example/debian bookworm main non-free # words
deb [arch=amd64 signed-by=/etc/key.gpg] http://options.example/debian bookworm main
deb-src http://sources.example/debian bookworm main
deb cdrom:[Debian_12]/ bookworm main
deb http://broken.example/debian
deb http://vendor.example/apt vendor-bookworm main
"""


def machine(tmp_path: Path, identity: str = "debian") -> tuple[Path, Path]:
    """An /etc/apt with both kinds of files, and an os-release."""
    parts = tmp_path / "apt" / "sources.list.d"
    parts.mkdir(parents=True)
    (tmp_path / "apt" / "sources.list").write_text(ONE_LINE)
    (parts / "debian.sources").write_text(DEB822)
    (tmp_path / "os-release").write_text(f'ID={identity}\nVERSION_CODENAME="bookworm"\n')
    return tmp_path / "apt", tmp_path / "os-release"


def test_both_formats_are_read() -> None:
    """Every enabled binary source, with its key file."""
    assert apt.parse_deb822(DEB822)[:2] == [
        apt.Source(
            f"http://{name}.example/debian",
            ("bookworm", "bookworm-updates"),
            ("main", "contrib"),
            "/usr/share/keyrings/debian-archive-keyring.gpg",
        )
        for name in ("one", "two")
    ]
    assert [source.uri for source in apt.parse_deb822(DEB822)[2:]] == [
        "http://one.example/debian-security"
    ]
    assert apt.parse_one_line(ONE_LINE)[:2] == [
        apt.Source("http://plain.example/debian", ("bookworm",), ("main", "non-free")),
        apt.Source("http://options.example/debian", ("bookworm",), ("main",), "/etc/key.gpg"),
    ]


def test_a_key_written_into_the_source_is_no_path() -> None:
    """Such a source falls back on the machine's key rings."""
    text = "Types: deb\nURIs: http://a/\nSuites: x\nSigned-By:\n -----BEGIN PGP\n .\n abc\n"
    assert apt.parse_deb822(text) == [apt.Source("http://a/", ("x",), ())]


def test_only_the_machine_s_own_debian_archives_are_asked(tmp_path: Path) -> None:
    """No vendor's, no security archive, no source disc."""
    assert [source.uri for source in apt.debian_archives(*machine(tmp_path))] == [
        "http://plain.example/debian",
        "http://options.example/debian",
        "http://one.example/debian",
        "http://two.example/debian",
    ]


def test_a_machine_that_is_not_debian_names_none(tmp_path: Path) -> None:
    """Its mirrors do not carry Debian's suites."""
    assert apt.debian_archives(*machine(tmp_path, "ubuntu")) == []
    assert apt.debian_archives(tmp_path / "nothing", tmp_path / "nothing") == []


@given(st.text())
def test_any_text_can_be_read(text: str) -> None:
    """A broken source file never ends the set-up."""
    apt.parse_one_line(text)
    apt.parse_deb822(text)
    apt.parse_os_release(text)


def test_lists_are_old_after_a_day_or_when_missing(tmp_path: Path) -> None:
    """Then apt-get update comes first."""
    assert apt.lists_are_old(tmp_path)
    lists = tmp_path / "deb.example_dists_bookworm_main_binary-amd64_Packages.lz4"
    lists.touch()
    assert not apt.lists_are_old(tmp_path)
    yesterday = time.time() - apt.LISTS_OLD_S - 60
    os.utime(lists, (yesterday, yesterday))
    assert apt.lists_are_old(tmp_path)


def test_without_root_the_command_to_type_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """One line: what is missing and how to get it."""
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    with pytest.raises(NotAvailable, match=r"Chromium is missing.*apt install chromium"):
        apt.install("chromium", what="Chromium")


@pytest.mark.parametrize("failures", range(len(apt.RETRY_AFTER_S) + 2))
def test_a_mirror_that_is_being_synchronised_is_asked_again(tmp_path, monkeypatch, failures):
    """Lists and checksums of two days: apt-get fails for some minutes, then not."""
    commands, slept = [], []

    def run(command, **_) -> str:
        commands.append(command)
        if "update" in command and len(commands) <= failures:
            raise NotAvailable("File has unexpected size")
        return ""

    monkeypatch.setattr(apt, "run_quietly", run)
    monkeypatch.setattr(apt.time, "sleep", slept.append)
    monkeypatch.setattr(apt.shutil, "which", lambda tool: f"/usr/bin/{tool}")
    archive = apt.Source("http://one.example/debian", ("bookworm",), ("main",))

    def unpack() -> None:
        apt.unpack(archive, "trixie", "i386", ["micropython"], tmp_path)

    if failures > len(apt.RETRY_AFTER_S):
        with pytest.raises(NotAvailable, match="unexpected size"):
            unpack()
        assert not any("download" in command for command in commands)
    else:
        unpack()
        assert "download" in commands[-1]
    assert tuple(slept) == apt.RETRY_AFTER_S[:failures]


def test_a_pinned_file_is_taken_only_as_it_was_pinned(tmp_path, monkeypatch):
    pool = tmp_path / "pool"
    pool.mkdir()
    (pool / "a.deb").write_bytes(b"as it was")
    right = hashlib.sha256(b"as it was").hexdigest()
    unpacked = []
    monkeypatch.setattr(apt, "run_quietly", lambda command, **_: unpacked.append(command[:2]))
    monkeypatch.setattr(apt.shutil, "which", lambda tool: f"/usr/bin/{tool}")
    archive = apt.Source(tmp_path.as_uri(), ("bookworm",), ("main",))
    for files, reason in (
        ([("pool/a.deb", right), ("pool/a.deb", "0" * 64)], "not the file that was pinned"),
        ([("pool/a.deb", right), ("pool/gone.deb", right)], "gone.deb"),
    ):
        with pytest.raises(NotAvailable, match=reason):
            apt.unpack_pinned(archive, files, tmp_path / "root")
    assert unpacked == []  # all or nothing
    apt.unpack_pinned(archive, [("pool/a.deb", right)], tmp_path / "root")
    assert unpacked == [["dpkg", "-x"]]


def test_a_pinned_file_that_breaks_off_is_not_available(tmp_path, monkeypatch):
    def break_off(url, timeout):
        raise IncompleteRead(b"half")

    monkeypatch.setattr(apt.urllib.request, "urlopen", break_off)
    archive = apt.Source("http://one.example/debian", ("bookworm",), ("main",))
    with pytest.raises(NotAvailable, match="IncompleteRead"):
        apt.unpack_pinned(archive, [("pool/a.deb", "0" * 64)], tmp_path)
