"""Shared by all tests: what they need from the machine, and no silent skips on build machines."""

import gc
import os
from pathlib import Path

import pytest

import gazesetup


def pytest_addoption(parser: pytest.Parser) -> None:
    """What the command line adds."""
    parser.addoption(
        "--board",
        metavar="PORT",
        help="run tests/board on the real board at PORT, its relay held open",
    )


@pytest.hookimpl(trylast=True)
def pytest_collection_finish() -> None:
    """The firmware collects garbage once a second of its time: spare it pytest's own objects."""
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


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """With CI=true a skipped test is a failed one: nothing goes untested unseen."""
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
