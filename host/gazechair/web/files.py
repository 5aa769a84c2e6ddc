"""The pages' files: where they are, which may be served, and which page belongs to which role."""

from __future__ import annotations

import functools
import gzip
import os
from pathlib import Path

from flask import Flask, Response, abort, redirect, request
from werkzeug.wrappers import Response as AnyResponse

from gazechair.base.languages import web_folder as web_folder
from gazechair.web.guard import DEVICE
from gazechair.web.minify import minified

_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".json": "application/json; charset=utf-8",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".ico": "image/x-icon",
}


@functools.lru_cache(maxsize=256)
def _content(file: Path, zipped: bool, _mtime_ns: int, _size: int) -> bytes:
    # By age and size, so that a changed file is read again.
    content = file.read_bytes()
    if _is_text(file):
        content = minified(content.decode("utf-8"), file.suffix).encode()
    # Always the same bytes, so that the tag stays.
    return gzip.compress(content, mtime=0) if zipped else content


def _is_text(file: Path) -> bool:
    return _TYPES[file.suffix].endswith("utf-8")


def _takes_gzip() -> bool:
    # Only as browsers send it, without weights: a stranger's header costs no parsing.
    accepted = request.environ.get("HTTP_ACCEPT_ENCODING", "").split(",")
    return "gzip" in (word.strip(" ") for word in accepted)


def add_routes(app: Flask, folder: Path) -> None:
    """Serve `folder`: the pages by role, files at /static/, string tables at /strings/."""
    root = folder.resolve()

    def answer(path: str) -> Response:
        file = (root / path).resolve()
        kind = _TYPES.get(file.suffix)
        hidden = any(part.startswith((".", "_")) for part in Path(path).parts)
        # Path.is_file() raises OSError for a name longer than any file's.
        if kind is None or hidden or not file.is_relative_to(root) or not os.path.isfile(file):
            abort(404)
        facts = file.stat()
        zipped = _is_text(file) and _takes_gzip()
        response = Response(_content(file, zipped, facts.st_mtime_ns, facts.st_size))
        response.headers["Content-Type"] = kind
        response.headers["Vary"] = "Accept-Encoding"
        if zipped:
            response.headers["Content-Encoding"] = "gzip"
        # An unchanged file costs the tablet a 304, and a changed one is never missed.
        response.add_etag()
        response.make_conditional(request)
        response.headers["Cache-Control"] = "no-cache"
        return response

    def elsewhere(path: str) -> AnyResponse:
        query = request.query_string.decode("ascii", "replace")
        response = redirect(f"{path}?{query}" if query else path, 303)
        response.headers["Cache-Control"] = "no-store"
        return response

    @app.get("/")
    def drivers_page() -> AnyResponse:
        if request.environ[DEVICE].role == "driver":
            return answer("index.html")
        return elsewhere("/caretaker")

    @app.get("/caretaker")
    def caretakers_page() -> AnyResponse:
        if request.environ[DEVICE].role == "driver":
            return elsewhere("/")
        return answer("caretaker.html")

    @app.get("/pair")
    def pairing_page() -> Response:
        return answer("pair.html")

    @app.get("/static/<path:path>")
    def static_file(path: str) -> Response:
        return answer(path)

    @app.get("/strings/<language>.json")
    def strings(language: str) -> Response:
        return answer(f"strings/{language}.json")
