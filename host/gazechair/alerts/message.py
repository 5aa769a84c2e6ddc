"""The text of an alert, for a message to somebody who is not at the chair."""

from __future__ import annotations

import time
from dataclasses import dataclass

from gazechair.alerts.book import Alert
from gazechair.alerts.reasons import REASONS
from gazechair.base.languages import sentence

_DETAIL = 500  # characters


@dataclass(frozen=True)
class Message:
    """A text for a route."""

    title: str
    body: str


def message_of(alert: Alert, driver: str, language: str) -> Message:
    """The message about `alert` for the driver named `driver`, "" for none."""
    lines = [f"{driver}: {alert.sentence}"] if alert.sentence else []
    lines += [alert.detail[:_DETAIL]] if alert.detail else []
    lines.append(sentence(language, REASONS[alert.key].who))
    when = time.strftime("%Y-%m-%d %H:%M", time.localtime(alert.at))
    # The name without a sentence, too: a helper may know more than one chair.
    lines.append(f"{driver}, {when}" if driver and not alert.sentence else when)
    return Message(f"gazechair: {sentence(language, alert.key)}", "\n".join(lines))
