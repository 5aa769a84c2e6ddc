"""HTTP routes of the maps: pose and pictures for every page; changes by caretakers."""

from __future__ import annotations

from typing import Any, Protocol

from flask import Flask, Response, request

from gazechair.sensing.mapping.stored.picture import Picture
from gazechair.sensing.mapping.stored.places import EditRefused
from gazechair.web.answers import answer, body, file_of, only_caretaker, refuse

_STATUS = {
    "map_gone": 404,
    "map_name_taken": 409,
    "map_full": 409,
    "map_known": 409,
    "map_damaged": 409,
    "map_no_update": 409,
    "map_older_damaged": 409,
    "map_busy": 409,
    "map_file_large": 413,
    "map_no_lidar": 409,
    "map_not_stored": 507,
}


class Maps(Protocol):
    """What the pages need from the maps (gazechair.sensing.mapping.desk.MapDesk)."""

    def as_json(self) -> dict[str, Any]: ...
    def where(self) -> dict[str, Any] | None: ...
    def details(self, id_: str) -> dict[str, Any]: ...
    def picture(self, id_: str) -> bytes: ...
    def files(self, id_: str) -> bytes: ...
    def add(self, data: bytes) -> str: ...
    def growing(self) -> Picture | None: ...
    def change(self, request: dict[str, Any]) -> None: ...


def add_routes(app: Flask, maps: Maps) -> None:
    """GET and POST /maps, and the routes of a single map."""

    @app.get("/maps")
    def all_maps() -> Response:
        only_caretaker()
        return answer(maps.as_json())

    @app.post("/maps")
    def change_maps() -> Response:
        only_caretaker()
        maps.change(body())
        return answer(maps.as_json())

    @app.post("/maps/import")
    def add_map() -> Response:
        only_caretaker()
        added = maps.add(file_of("application/zip"))
        return answer({**maps.as_json(), "added": added})

    @app.get("/maps/where")
    def where() -> Response:
        return answer({"where": maps.where()})

    @app.get("/maps/growing")
    def growing() -> Response:
        only_caretaker()
        picture = maps.growing()
        return answer({"picture": picture and picture.as_json()})

    @app.get("/maps/growing.png")
    def growing_picture() -> Response:
        only_caretaker()
        picture = maps.growing()
        if picture is None:
            return refuse(404, "map_gone", "no map is being made")
        return _png(picture.png)

    @app.get("/maps/<id_>")
    def one_map(id_: str) -> Response:
        return answer(maps.details(id_))

    @app.get("/maps/<id_>.png")
    def map_picture(id_: str) -> Response:
        return _png(maps.picture(id_))

    @app.get("/maps/<id_>.zip")
    def map_files(id_: str) -> Response:
        only_caretaker()
        return _zip(maps.files(id_), id_)

    @app.errorhandler(EditRefused)
    def refused(error: EditRefused) -> Response:
        return refuse(_STATUS.get(error.reason, 400), error.reason, str(error))


def _png(data: bytes) -> Response:
    response = Response(data, mimetype="image/png")
    response.add_etag()
    response.make_conditional(request)
    response.headers["Cache-Control"] = "no-cache"
    return response


def _zip(data: bytes, id_: str) -> Response:
    response = Response(data, mimetype="application/zip")
    response.headers["Content-Disposition"] = f'attachment; filename="map-{id_}.zip"'
    response.headers["Cache-Control"] = "no-store"
    return response
