"""`gazechair calibrate camera`: from marks to a stored pose, or a refusal with its reason."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from gazechair.cli import main
from gazechair.picture.floor_store import FILE_NAME, FloorStore
from gazesim.floor_view import Eye, Floor, FloorView

EYE = Eye(640, 480, field_deg=68.0, height_m=1.21, down_deg=27.0, left_deg=2.0, forward_m=0.25)
PLACES = [(1.2, 0.3), (1.2, -0.3), (1.8, 0.5), (1.8, -0.5), (2.6, 0.7), (2.6, -0.7), (2.0, 0.0)]


@pytest.fixture
def home(tmp_path: Path) -> Path:
    (tmp_path / "chair.toml").write_text(f'[web]\nstate_folder = "{tmp_path / "state"}"\n')
    view = FloorView(EYE, Floor())
    (tmp_path / "floor.jpg").write_bytes(view.jpeg(0.0, 0.0, 0.0))
    return tmp_path


def run(home: Path, rows: list[tuple[float, ...]] | str, *more: str) -> int:
    text = rows if isinstance(rows, str) else "\n".join(" ".join(map(str, row)) for row in rows)
    (home / "marks").write_text(text)
    paths = "--picture", str(home / "floor.jpg"), "--marks", str(home / "marks")
    config = "--config", str(home / "chair.toml")
    return main(["calibrate", "camera", *paths, *config, *more])


def marks() -> list[tuple[float, ...]]:
    return [(*EYE.pixel(*place), *place) for place in PLACES]


def test_marks_give_the_camera_that_sees_them_there(home: Path) -> None:
    assert (
        run(home, "# u v x y\n" + "\n".join(f"{u}, {v}, {x}, {y}" for u, v, x, y in marks())) == 0
    )
    known = FloorStore(home / "state").get()
    assert known is not None
    for place in ((1.5, 0.2), (2.2, -0.4)):
        pixel = np.array((EYE.pixel(*place),))
        assert math.dist(known.camera.floor_m(pixel)[0], place) < 0.03


@pytest.mark.parametrize(
    ("rows", "why"),
    [
        (marks()[:5], "fewer than 6"),
        ([(u, v, x, -y) for u, v, x, y in marks()], "left and right"),
        ([(u, v, 100 * x, 100 * y) for u, v, x, y in marks()], "metres"),
        ([(u, v, x, 0.0) for u, v, x, _ in marks()], "one line"),
        ([*marks()[:6], (900.0, 100.0, 2.0, 0.0)], "corner (mark 7)"),
        ("1 2 3\n", "line 1: not four numbers"),
        ("nan 2 3 4\n", "line 1: a number that is none"),
        ([*marks()[:6], (*EYE.pixel(2.0, 0.0), 2.0, 1.0)], "do not fit"),
    ],
)
def test_what_cannot_be_right_is_refused_and_stores_nothing(
    home: Path, capsys: pytest.CaptureFixture[str], rows: list[tuple[float, ...]] | str, why: str
) -> None:
    assert run(home, rows) == 2
    assert why in capsys.readouterr().err
    assert FloorStore(home / "state").get() is None


def test_a_damaged_or_impossible_file_is_no_calibration(home: Path) -> None:
    assert run(home, marks()) == 0
    path = home / "state" / FILE_NAME
    good = json.loads(path.read_text())
    store = FloorStore(home / "state")
    assert store.get() is not None
    for damaged in (
        "{",
        "[]",
        "[" * 100_000,
        json.dumps({**good, "residual_m": 0.5}),
        json.dumps({**good, "camera": {**good["camera"], "height_m": float("nan")}}),
        json.dumps({**good, "camera": {**good["camera"], "width_px": 0}}),
        json.dumps({**good, "camera": "high"}),
        json.dumps({**good, "camera": {**good["camera"], "x_m": 10**400}}),
        json.dumps({**good, "camera": {**good["camera"], "width_px": float("inf")}}),
    ):
        path.unlink()
        path.write_text(damaged)
        assert store.get() is None
    path.unlink()
    assert store.get() is None


def test_without_a_camera_or_a_picture_it_says_so(
    home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = "--config", str(home / "chair.toml")
    assert main(["calibrate", "camera", *config]) == 0
    assert "not calibrated" in capsys.readouterr().out
    assert main(["calibrate", "camera", "--picture", str(home / "new.jpg"), *config]) == 2
    assert "no camera is configured" in capsys.readouterr().err
    assert main(["calibrate", "camera", "--marks", str(home / "marks"), *config]) == 2
    (home / "floor.jpg").write_bytes(b"no picture")
    assert run(home, marks()) == 2
    assert "no JPEG" in capsys.readouterr().err
    assert run(home, marks(), "--height", "40") == 2


def test_a_result_that_cannot_be_stored_is_one_line(
    home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (home / "state").write_text("a file where the folder should be")
    assert run(home, marks()) == 2
    printed = capsys.readouterr().err.strip()
    assert "it was not stored" in printed
    assert len(printed.splitlines()) == 1
