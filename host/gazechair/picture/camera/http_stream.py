"""A camera on the network: its MJPEG stream over HTTP."""

from __future__ import annotations

import http.client
import re
import time
import urllib.error
import urllib.request
from typing import Any

from gazechair.base.latest_value import Latest
from gazechair.picture.camera import SILENT_S, CameraError
from gazechair.picture.camera.mjpeg import MjpegParser, NotMjpeg, Part, boundary_of
from gazechair.picture.camera.record import Frame

# A time stamp that is off by more than this is from another machine's clock.
_OLDEST_STAMP_S = 10.0


def acquired_s(part: Part, arrived_s: float) -> float:
    """When the picture was taken: its X-Timestamp if that is this machine's clock, else arrival."""
    try:
        stamp_s = float(part.headers.get("x-timestamp", ""))
    except ValueError:
        return arrived_s
    return stamp_s if arrived_s - _OLDEST_STAMP_S < stamp_s <= arrived_s else arrived_s


def _shown(url: str) -> str:
    """The camera's host and port: path and query may hold a password."""
    return re.sub(r"^(https?://[^/?#]*).*", r"\1", url, flags=re.DOTALL)


def _why(error: Exception) -> str:
    if isinstance(error, OSError):
        reason = getattr(error, "reason", error)
    elif isinstance(error, ValueError | http.client.InvalidURL):
        reason = "no address"
    else:
        return "answers, but not as a web server (HTTP); check camera.url"
    return f"does not answer ({reason}); check its power and camera.url"


def connect(url: str) -> tuple[Any, bytes]:
    """Open the stream; the response and its boundary. Raises CameraError within some 3 s."""
    # No proxy: the camera is on our own network, whatever the environment sets.
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    try:
        response = opener.open(url, timeout=SILENT_S)
    except urllib.error.HTTPError as error:
        raise CameraError(
            f"the camera at {_shown(url)} refuses: {error.code} {error.reason}"
        ) from error
    except (OSError, http.client.HTTPException, ValueError) as error:
        raise CameraError(f"the camera at {_shown(url)} {_why(error)}") from error
    try:
        return response, boundary_of(response.headers.get("Content-Type", ""))
    except NotMjpeg as error:
        response.close()
        raise CameraError(f"the camera at {_shown(url)} {error}") from error


def read(url: str, newest: Latest[Frame]) -> None:
    """Put each picture into `newest` until the stream fails (CameraError)."""
    response, boundary = connect(url)
    parser = MjpegParser(boundary)
    good_s = time.monotonic()
    with response:
        while True:
            try:
                data = response.read1(1 << 16)
                parts = parser.feed(data)
            except NotMjpeg as error:
                raise CameraError(f"the camera at {_shown(url)} {error}") from error
            except (OSError, http.client.HTTPException) as error:
                raise CameraError(f"the camera at {_shown(url)} fell silent: {error}") from error
            if not data:
                raise CameraError(f"the camera at {_shown(url)} ended its stream")
            now_s = time.monotonic()
            if parts:
                good_s = now_s
                newest.put(Frame(parts[-1].jpeg, acquired_s(parts[-1], now_s)))
            elif now_s - good_s > SILENT_S:
                raise CameraError(f"the camera at {_shown(url)} sends no whole JPEG picture")
