"""HTTP routes of the board's settings that a caretaker may read and change."""

from __future__ import annotations

from flask import Flask, Response

from gazechair.board.caretaker_settings import CaretakerSettings, ChangeRefused
from gazechair.web.answers import answer, body, only_caretaker, refuse
from gazechair.web.first_drive_routes import Steps

_STATUS = {
    "setting_unknown": 400,
    "setting_out_of_range": 400,
    "setting_while_armed": 409,
    "setting_by_calibration": 409,
    "setting_not_stored": 507,
    "not_connected": 503,
}


def add_routes(app: Flask, settings: CaretakerSettings, steps: Steps) -> None:
    """GET and POST /settings. Nothing changes while one of `steps` holds the settings."""

    @app.get("/settings")
    def read() -> Response:
        only_caretaker()
        return answer({"settings": settings.read()})

    @app.post("/settings")
    def change() -> Response:
        only_caretaker()
        values = body().get("set")
        if not isinstance(values, dict):
            return refuse(400, "bad_message", '"set" must be an object of names and values')
        if steps.holds_settings:
            return refuse(409, "first_busy", "a step of the first drive uses the settings")
        return answer({"settings": settings.change(values)})

    @app.errorhandler(ChangeRefused)
    def refused(error: ChangeRefused) -> Response:
        return refuse(_STATUS.get(error.reason, 502), error.reason, str(error))
