"""HTTP routes of the first drive: list steps, run one that does not move the chair, answer it."""

from __future__ import annotations

from typing import Any, Protocol

from flask import Flask, Response

from gazechair.web.answers import answer, body, only_caretaker, refuse


class Steps(Protocol):
    """What the pages need from the first drive (gazechair.first_drive.guide.Guide)."""

    def status(self) -> dict[str, Any]: ...
    def ask(self, request: dict[str, Any]) -> tuple[str, str] | None: ...
    @property
    def holds_settings(self) -> bool: ...


def add_routes(app: Flask, steps: Steps) -> None:
    """GET and POST /first-drive."""

    @app.get("/first-drive")
    def steps_now() -> Response:
        only_caretaker()
        return answer(steps.status())

    @app.post("/first-drive")
    def do_step() -> Response:
        only_caretaker()
        posted = body()
        refused = steps.ask(posted)
        if refused is not None:
            return refuse(400 if refused[0] == "bad_message" else 409, *refused)
        return answer(steps.status())
