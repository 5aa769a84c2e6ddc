"""HTTP routes of the profiles: who drives, and each person's own times and display."""

from __future__ import annotations

from flask import Flask, Response, request

from gazechair.driving.driver_port import DriverPort
from gazechair.people.pairing import Device
from gazechair.web.answers import answer, body, refuse
from gazechair.web.guard import DEVICE

_STATUS = {"not_allowed": 403, "profile_unknown": 404, "profile_not_stored": 507}


def add_routes(app: Flask, port: DriverPort) -> None:
    """GET and POST /profiles."""

    @app.get("/profiles")
    def profiles() -> Response:
        return answer(port.profiles())

    @app.post("/profiles")
    def change_profile() -> Response:
        device: Device = request.environ[DEVICE]
        result = port.change_profile(body(), device.role)
        if "reason" not in result:
            return answer(result)
        reason = result["reason"]
        return refuse(_STATUS.get(reason, 400), reason, result["detail"])
