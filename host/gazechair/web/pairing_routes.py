"""HTTP routes of pairing: a code for a cookie, the device's own role, the list of devices."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from flask import Flask, Response, request

from gazechair.people.pairing import Device, PairingDesk, Rejected, StoreError
from gazechair.people.pairing.one_time import VALID_S
from gazechair.people.pairing.show import qr_rows
from gazechair.people.pairing.store import ROLES
from gazechair.web.answers import answer, body, only_caretaker, refuse, text_in
from gazechair.web.guard import DEVICE, PAGES, token_in

_COOKIE_S = 400 * 86_400  # the longest that browsers keep one
_MOST_CODE = 40


def add_routes(
    app: Flask, desk: PairingDesk, cookie_name: Callable[[], str], url: Callable[[], str], tls: bool
) -> None:
    """`url`: the address of the pairing page, as other devices reach it."""

    @app.get("/me")
    def me() -> Response:
        device: Device | None = request.environ[DEVICE]
        if device is None:
            return refuse(401, "not_paired", "this browser is not paired with this chair")
        return answer({"role": device.role, "name": device.name, "id": device.id})

    @app.post("/pair")
    def pair() -> Response:
        content = body()
        code = text_in(content, "code", _MOST_CODE)
        name = text_in(content, "name", _MOST_CODE) if "name" in content else ""
        paired = desk.pair(code, name, str(request.remote_addr))
        if isinstance(paired, Rejected):
            if paired.wait_s <= 0:
                return refuse(403, paired.reason, paired.detail)
            wait_s = math.ceil(paired.wait_s)
            response = refuse(429, paired.reason, paired.detail, wait_s=wait_s)
            response.headers["Retry-After"] = str(wait_s)
            return response
        response = answer({"role": paired.device.role})
        keep(response, paired.token)
        return response

    def keep(response: Response, token: str) -> None:
        response.set_cookie(
            cookie_name(),
            token,
            max_age=_COOKIE_S,
            path="/",
            secure=tls,
            httponly=True,
            samesite="Strict",
        )

    @app.after_request
    def keep_longer(response: Response) -> Response:
        # A device that opens a page within 400 days stays paired.
        if request.path in PAGES and request.environ.get(DEVICE) is not None:
            keep(response, token_in(request.environ, cookie_name()))
        return response

    @app.get("/pairing")
    def devices() -> Response:
        only_caretaker()
        return _devices(desk)

    @app.post("/pairing/code")
    def new_code() -> Response:
        only_caretaker()
        role = text_in(body(), "role", _MOST_CODE)
        if role not in ROLES:
            return refuse(400, "bad_message", f'"role" must be one of {", ".join(ROLES)}')
        return _code(desk, role, url())

    @app.post("/pairing/revoke")
    def revoke() -> Response:
        only_caretaker()
        desk.revoke(text_in(body(), "id", _MOST_CODE))
        return _devices(desk)

    @app.errorhandler(StoreError)
    def not_stored(error: StoreError) -> Response:
        return refuse(507, "setting_not_stored", str(error))


def _code(desk: PairingDesk, role: str, url: str) -> Response:
    code = desk.new_code(role)
    return answer(
        {
            "code": code.text,
            "url": url,
            "role": role,
            "valid_s": VALID_S,
            "qr": qr_rows(f"{url}#{code.text}"),
        }
    )


def _devices(desk: PairingDesk) -> Response:
    me: Device = request.environ[DEVICE]
    rows: list[dict[str, Any]] = [
        {
            "id": device.id,
            "role": device.role,
            "name": device.name,
            "created": device.created,
            "last_used": device.last_used,
            "you": device.id == me.id,
        }
        for device in desk.devices()
    ]
    return answer({"devices": rows})
