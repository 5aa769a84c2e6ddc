"""JSON over HTTP: answers, refusals, and the validation of request bodies."""

from __future__ import annotations

import json
from typing import Any

from flask import Response, request

from gazechair.base import json_text
from gazechair.base.refused import Refused
from gazechair.people.pairing import Device
from gazechair.web.guard import DEVICE


class HttpRefused(Refused):
    """Raised by a route; the server answers with `response`."""

    def __init__(self, status: int, reason: str, detail: str) -> None:
        super().__init__(reason, detail)
        self._status = status

    def response(self) -> Response:
        """The refusal to send."""
        return refuse(self._status, self.reason, str(self))


def answer(content: dict[str, Any], status: int = 200) -> Response:
    """`content` as JSON that is never cached."""
    response = Response(json.dumps(content) + "\n", status, mimetype="application/json")
    response.headers["Cache-Control"] = "no-store"
    return response


def refuse(status: int, reason: str, detail: str, **more: Any) -> Response:
    """A refusal: `reason` is a key of the string tables, `detail` one plain line."""
    return answer({"reason": reason, "detail": detail, **more}, status)


def only_caretaker() -> None:
    """Raises HttpRefused for a device that is not a caretaker's."""
    device: Device = request.environ[DEVICE]
    if device.role != "caretaker":
        raise HttpRefused(403, "not_allowed", f"a {device.role} may not; only a caretaker")


def _bad_request(detail: str) -> HttpRefused:
    """To raise for a body that violates the contract."""
    return HttpRefused(400, "bad_message", detail)


def file_of(kind: str) -> bytes:
    """The request's body of this type, which another site's form cannot send. HttpRefused."""
    sent = request.environ.get("CONTENT_TYPE", "").partition(";")[0]
    if sent.strip(" \t").lower() != kind:
        raise _bad_request(f"send Content-Type: {kind}")
    return request.get_data()


def body() -> dict[str, Any]:
    """The request's JSON object. Raises HttpRefused.

    Its type must be application/json, which another site's form cannot send.
    """
    try:
        content = json_text.parse(file_of("application/json"))
    except ValueError:
        raise _bad_request("send a JSON object") from None
    if not isinstance(content, dict):
        raise _bad_request("send a JSON object")
    return content


def text_in(content: dict[str, Any], key: str, most: int) -> str:
    """The text `key` of 1..`most` characters. Raises HttpRefused."""
    value = content.get(key)
    if not isinstance(value, str) or not 1 <= len(value) <= most:
        raise _bad_request(f'"{key}" must be a text of 1..{most} characters')
    return value
