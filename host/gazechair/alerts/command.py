"""The commands `gazechair alert test` and `list`."""

from __future__ import annotations

import argparse
import sys
import threading
import time
from typing import Any

from gazechair.alerts import apprise_route
from gazechair.alerts.book import Alert, alert_of
from gazechair.alerts.child import LIMIT_S
from gazechair.alerts.diary import Diary
from gazechair.alerts.message import message_of
from gazechair.alerts.reasons import TRIED
from gazechair.base.languages import sentence
from gazechair.base.state_folder import state_folder
from gazechair.base.user_error import UserError
from gazechair.config import configuration
from gazechair.config.settings import RouteConfig


def add(commands: Any) -> None:
    """Add them to argparse's subparsers `commands`."""
    alert = commands.add_parser("alert", help="test the alert routes, list the alerts")
    acts = alert.add_subparsers(title="actions", required=True, metavar="ACTION")
    test = acts.add_parser("test", help="send a test over every route, and print the results")
    listed = acts.add_parser("list", help="print the diary: every alert, and who was reached")
    test.set_defaults(act=_test)
    listed.set_defaults(act=_list)
    for command in (test, listed):
        configuration.add_option(command)


def _test(options: argparse.Namespace) -> int:
    config = configuration.load(options.config)
    if not config.routes:
        raise UserError("no [[alerts.route]] is configured; read docs/alerts.md")
    if not apprise_route.installed():
        raise UserError(apprise_route.MISSING)
    message = message_of(Alert(0, TRIED, time.time()), "", config.web.language)
    results: dict[str, str] = {}

    def send(route: RouteConfig) -> None:
        results[route.name] = apprise_route.send(route.url, message.title, message.body)

    threads = [threading.Thread(target=send, args=(one,), daemon=True) for one in config.routes]
    end_s = time.monotonic() + LIMIT_S
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(max(0.0, end_s - time.monotonic()))
    failed = False
    for route in config.routes:
        problem = results.get(route.name, f"no answer within {LIMIT_S:g} s")
        failed |= bool(problem)
        print(f"{route.name}: {problem or 'delivered'}", flush=True)
    return 1 if failed else 0


def _list(options: argparse.Namespace) -> int:
    config = configuration.load(options.config)
    diary = Diary(state_folder(config.web.state_folder))
    for row in diary.read():
        alert = alert_of(row)
        if alert is None:
            continue
        when = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(alert.at))
        by = f" by {alert.by}" if alert.by else ""
        text = sentence(config.web.language, alert.key)
        print(f"{when}  {text}, {alert.count}x, {alert.state}{by}")
        for name, one in row["deliveries"].items():
            print(f"    {name}: {one.get('state')} {one.get('detail', '')}".rstrip())
    if diary.problem:
        print(f"gazechair: {diary.problem}", file=sys.stderr)
    return 0
