"""HTTP routes of the alerts: list, acknowledge, test."""

from __future__ import annotations

from typing import Any, Protocol

from flask import Flask, Response, request

from gazechair.people.pairing import Device
from gazechair.web.answers import answer, body, only_caretaker, refuse
from gazechair.web.guard import DEVICE


class AlertBook(Protocol):
    """What the pages need from the alerts."""

    def as_json(self) -> dict[str, Any]: ...
    def acknowledge(self, number: int, by: str) -> bool: ...
    def test(self, by: str) -> None: ...


def add_routes(app: Flask, alerts: AlertBook) -> None:
    """GET and POST /alerts."""

    @app.get("/alerts")
    def alerts_now() -> Response:
        only_caretaker()
        return answer(alerts.as_json())

    @app.post("/alerts")
    def change_alerts() -> Response:
        only_caretaker()
        device: Device = request.environ[DEVICE]
        posted = body()
        number = posted.get("acknowledge")
        if len(posted) == 1 and posted.get("test") is True:
            alerts.test(device.name)
        elif len(posted) != 1 or type(number) is not int:
            return refuse(400, "bad_message", 'send {"acknowledge": number} or {"test": true}')
        else:
            alerts.acknowledge(number, device.name)  # somebody else may have been quicker
        return answer(alerts.as_json())
