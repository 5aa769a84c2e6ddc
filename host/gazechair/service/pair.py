"""`gazechair pair`: creates a code for one more device, lists the devices, revokes one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from gazechair.base.sole_daemon import AlreadyRunning, no_daemon
from gazechair.base.user_error import UserError
from gazechair.people.pairing.desk import PairingDesk
from gazechair.people.pairing.local import NotRunning, ask
from gazechair.people.pairing.one_time import VALID_S
from gazechair.people.pairing.show import code_as_text, devices_as_text
from gazechair.people.pairing.store import Device, StoreError


class PairError(UserError):
    """Raised when a device cannot be paired, listed or revoked."""


def make_code(folder: Path, role: str, say: Callable[[str], None]) -> None:
    """Show a code of the running daemon. Raises PairError when none runs, RequestRefused."""
    try:
        made = ask(folder, {"ask": "code", "role": role, "valid_s": VALID_S})
    except NotRunning as error:
        raise PairError(f"{error}; start it first, or give its --config") from None
    say(code_as_text(made["url"], made["code"], role, made["valid_s"]))


def show_devices(folder: Path, say: Callable[[str], None]) -> None:
    """Show the paired devices, even if no daemon runs. Raises PairError, RequestRefused."""
    try:
        answer = ask(folder, {"ask": "list"})
        devices = [Device(**row) for row in answer["devices"]]
        problem = answer["problem"]
    except NotRunning:
        desk = _desk(folder)
        devices, problem = desk.devices(), desk.problem
    say(devices_as_text(devices))
    if problem:
        say(problem)


def revoke(folder: Path, id: str, say: Callable[[str], None]) -> None:
    """Forget a device, even if no daemon runs.

    Raises PairError for an unknown id, and when a daemon runs that does not answer: it would go on
    accepting the device, and write it back. Raises RequestRefused.
    """
    try:
        revoked = ask(folder, {"ask": "revoke", "id": id})["revoked"]
        pages = "; its pages have been sent away"
    except NotRunning as unanswered:
        revoked = _revoke_alone(folder, id, str(unanswered))
        pages = ""
    if not revoked:
        raise PairError(f"no device {id!r}; gazechair pair --list shows them")
    say(f"{id} is not paired any more{pages}")


def _revoke_alone(folder: Path, id: str, unanswered: str) -> bool:
    try:
        with no_daemon(folder):
            return _desk(folder).revoke(id)
    except AlreadyRunning as running:
        problem = f"{id} is still paired: {running}, but {unanswered}; restart it, repeat"
        raise PairError(problem) from None
    except OSError as error:
        problem = f"{folder}: {error.strerror}; run this as the user of gazechair run"
        raise PairError(problem) from None
    except StoreError as error:
        raise PairError(str(error)) from None


def _desk(folder: Path) -> PairingDesk:
    try:
        return PairingDesk(folder)
    except StoreError as error:
        raise PairError(str(error)) from None
