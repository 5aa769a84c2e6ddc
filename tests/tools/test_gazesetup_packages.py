"""Which program of the distribution a test gets."""

from pathlib import Path

import pytest

import gazesetup


def programs(folder: Path, monkeypatch: pytest.MonkeyPatch, *names: str) -> None:
    """A machine that has these programs, and nothing to install others with."""
    for name in names:
        (folder / name).touch(mode=0o755)
    monkeypatch.setenv("PATH", str(folder))


def test_pages_are_drawn_without_windows_where_that_is_installed(tmp_path, monkeypatch):
    programs(tmp_path, monkeypatch, "chromium", "chromium-headless-shell")
    assert gazesetup.headless_chromium() == tmp_path / "chromium-headless-shell"
    assert gazesetup.ensure_headless_shell() == tmp_path / "chromium-headless-shell"
    assert gazesetup.ensure_chromium() == tmp_path / "chromium"


def test_else_in_the_whole_browser(tmp_path, monkeypatch):
    programs(tmp_path, monkeypatch, "chromium")
    assert gazesetup.headless_chromium() == tmp_path / "chromium"
    with pytest.raises(gazesetup.NotAvailable, match="apt install chromium-headless-shell"):
        gazesetup.ensure_headless_shell()


def test_without_any_it_says_what_to_install(tmp_path, monkeypatch):
    programs(tmp_path, monkeypatch)
    with pytest.raises(gazesetup.NotAvailable, match=r"apt install chromium\)"):
        gazesetup.headless_chromium()
