"""Shared by all tests: what they need from the machine, and no silent skips on build machines."""

import gc
import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from playwright.sync_api import Browser, sync_playwright

import gazechair  # noqa: F401  before any test imports numpy, whose helper threads it turns off
import gazesetup
from gazedemo.browser import OPTIONS

# Machines stall: the duration of an example is meaningless.
settings.register_profile("gazechair", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("gazechair")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options of the command line."""
    parser.addoption(
        "--board",
        metavar="PORT",
        help="run tests/board on the real board at PORT, its relay held open",
    )


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests in real time are collected from one folder only (tools/test)."""
    folder = Path(__file__).parent / "e2e"
    for item in items:
        if item.get_closest_marker("e2e") and folder not in item.path.parents:
            raise pytest.UsageError(f"{item.nodeid}: marked e2e, belongs in tests/e2e")


@pytest.hookimpl(trylast=True)
def pytest_collection_finish() -> None:
    """The firmware collects garbage once a second of its time: exclude pytest's own objects."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session")
def micropython() -> gazesetup.MicroPython:
    """A MicroPython for this computer, 32-bit where it can be had."""
    try:
        return gazesetup.ensure_micropython()
    except gazesetup.NotAvailable as error:
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def m7() -> Path:
    """Folder of the emulated board, with QEMU ready to run it."""
    try:
        folder = gazesetup.find_m7()
        gazesetup.ensure_qemu()
    except gazesetup.NotAvailable as error:
        pytest.skip(str(error))
    return folder


@pytest.fixture(scope="session")
def chromium() -> Iterator[Browser]:
    """The browser shared by all tests of a process, which cannot start a second one.

    Without its windows where that can be had; the tests in real time use the whole browser.
    """
    try:
        path = gazesetup.headless_chromium()
    except gazesetup.NotAvailable as error:
        pytest.skip(str(error))
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=str(path), args=list(OPTIONS))
        yield browser
        browser.close()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """With CI=true a skipped test fails, so that no gap in the tests goes unnoticed."""
    report = yield
    if os.environ.get("CI") == "true" and report.skipped and not hasattr(report, "wasxfail"):
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr
        report.outcome = "failed"
        report.longrepr = f"{item.nodeid}: {reason} (CI=true: nothing may be skipped)"
    return report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    """The same for a file that skips itself while it is imported."""
    report = yield
    if os.environ.get("CI") == "true" and report.skipped:
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr
        report.outcome = "failed"
        report.longrepr = f"{collector.nodeid}: {reason} (CI=true: nothing may be skipped)"
    return report
