"""HTTP routes of the alerts: list, acknowledge, test."""

from __future__ import annotations

from typing import Any, Protocol

from flask import Flask, Response, request

from gazechair.people.pairing import Device
from gazechair.web.answers import BadRequest, answer, body, refuse, unless_caretaker
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
        return unless_caretaker() or answer(alerts.as_json())

    @app.post("/alerts")
    def change_alerts() -> Response:
        refusal = unless_caretaker()
        if refusal is not None:
            return refusal
        device: Device = request.environ[DEVICE]
        try:
            posted = body()
        except BadRequest as error:
            return error.response()
        number = posted.get("acknowledge")
        if len(posted) == 1 and posted.get("test") is True:
            alerts.test(device.name)
        elif len(posted) != 1 or type(number) is not int:
            return refuse(400, "bad_message", 'send {"acknowledge": number} or {"test": true}')
        else:
            alerts.acknowledge(number, device.name)  # somebody else may have been quicker
        return answer(alerts.as_json())
