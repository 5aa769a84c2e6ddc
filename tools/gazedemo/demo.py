"""The demo: starts all processes, prints the page's address, ends all; or runs its check.

Ctrl-C, TERM and HUP end it in order. The check drives the chair through the page in a real Chromium
and prints one JSON line of figures.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import sys
import time
import webbrowser
from typing import Any

import gazesetup
from gazechair.people.pairing.local import NotRunning, RequestRefused
from gazedemo import ending, home, pairing
from gazedemo.stack import Stack, StackError

_CPYTHON = "cpython"


def demo(arguments: argparse.Namespace) -> int:
    """Run it, or its check: 0 ended normally, 1 a step of the check failed, 2 can't start."""
    ending.listen()
    try:
        if arguments.check:
            return _check(arguments)
        return _show(arguments)
    except (gazesetup.NotAvailable, StackError, NotRunning, RequestRefused, OSError) as error:
        print(f"tools/demo: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        ending.enough()
        with contextlib.suppress(OSError):  # the terminal may be closed
            print("\nended", flush=True)
        return 0


def _interpreter() -> str:
    """A MicroPython's path, or CPython with a notice."""
    try:
        found = gazesetup.ensure_micropython()
    except gazesetup.NotAvailable as error:
        gazesetup.note(f"no MicroPython: {error}")
        gazesetup.note("the firmware runs on CPython instead: same files, for this demo only")
        return _CPYTHON
    gazesetup.note(found.description)
    return str(found.path)


def _show(arguments: argparse.Namespace) -> int:
    try:
        more = arguments.config.read_text("utf-8-sig") if arguments.config else ""
    except UnicodeDecodeError:
        raise StackError(f"{arguments.config} is not text in UTF-8") from None
    with _stack(arguments, port=arguments.port, more_config=more) as stack:
        if arguments.home:
            home.allow(stack)
            print("\nChoose 'Doorlopend' until it says 'Meer': there are the places of the home.")
        address = stack.invitation()
        print(
            f"\nThe driver's page: {address}\n"
            "Press and hold 'Rijden aan', then hold Vooruit, Links or Rechts with the mouse, "
            "a finger or the arrow keys; or let the pointer rest on a button.\n"
            "Ctrl-C ends everything.",
            flush=True,
        )
        if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
            webbrowser.open(address)
        while True:
            stack.check_alive()
            with contextlib.suppress(NotRunning):  # slow to answer, or about to end
                if not pairing.is_open(stack.state_folder, address):
                    address = stack.invitation()
                    print(f"For one more browser: {address}", flush=True)
            time.sleep(0.5)


def _stack(arguments: argparse.Namespace, **more: Any) -> Stack:
    if arguments.home:
        more |= {"lidars": home.LIDARS, "prepare": home.prepare}
    room = home.ROOM if arguments.home else arguments.room
    return Stack(_interpreter(), room, arguments.profile, **more)


def _check(arguments: argparse.Namespace) -> int:
    # Only the check needs a browser driver, which only --check sets up.
    from gazedemo import check, home_check

    drive = home_check.check if arguments.home else check.check
    chromium = gazesetup.ensure_chromium()
    start_s = time.monotonic()
    with _stack(arguments) as stack:
        figures: dict[str, object] = {"ready_s": round(time.monotonic() - start_s, 1)}
        code = 0
        with gazesetup.say("driving through the page"):
            try:
                figures |= drive(stack, chromium, arguments.artefacts)
                figures["passed"] = True
            except check.CheckFailed as error:
                figures |= {"passed": False, "failed": str(error)}
                code = 1
                sys.stderr.write(stack.log("host")[-2000:])
    print(json.dumps(figures), flush=True)
    return code
