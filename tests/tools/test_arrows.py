"""Dependencies point one way: no circle between files, no arrow upward between rooms."""

from __future__ import annotations

from pathlib import Path

import pytest

from gazehouse import arrows

KNOWN = arrows.modules()
# Programs that run on the board or install the rest: no rooms.
OUTSIDE = {"gazechair", "gazechair.__main__", "gazeboard"}


@pytest.fixture(scope="module")
def graph() -> arrows.Imports:
    return arrows.imports(KNOWN)


def test_no_files_import_each_other_in_a_circle(graph: arrows.Imports) -> None:
    assert arrows.circles(graph) == []


def test_no_arrow_points_upward(graph: arrows.Imports) -> None:
    assert [str(arrow) for arrow in arrows.upward(arrows.arrows(graph))] == []


def test_every_module_is_in_a_room() -> None:
    assert {name for name in KNOWN if not arrows.room(name)} == OUTSIDE


def test_every_room_is_there_and_says_what_belongs_in_it() -> None:
    for name in (name for storey in arrows.STOREYS for name in storey):
        first = KNOWN[name].read_text().splitlines()[0].lstrip('#" ')
        assert len(first) > 20, name
        assert first.endswith((".", '."""')), f"{name}: its first line is no sentence: {first}"


def _house(folder: Path, **files: str) -> arrows.Imports:
    for name, text in files.items():
        file = folder / "host" / f"{name.replace('_in_', '/')}.py"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return arrows.imports(arrows.modules(folder))


def test_a_circle_is_found_also_of_imports_for_types_only(tmp_path: Path) -> None:
    graph = _house(tmp_path, one="import two", two="def f():\n    from three import x", three="")
    assert arrows.circles(graph) == []
    graph = _house(tmp_path, three="if TYPE_CHECKING:\n    import one")
    assert arrows.circles(graph) == [["one", "three", "two"]]


def test_an_arrow_upward_is_found(tmp_path: Path) -> None:
    (tmp_path / "host/gazechair/base").mkdir(parents=True)
    (tmp_path / "host/gazechair/web").mkdir()
    (tmp_path / "host/gazechair/web/page.py").write_text("from gazechair.base import log\n")
    (tmp_path / "host/gazechair/base/log.py").write_text("")
    assert not arrows.upward(arrows.arrows(arrows.imports(arrows.modules(tmp_path))))
    (tmp_path / "host/gazechair/base/log.py").write_text("from gazechair.web import page\n")
    found = arrows.upward(arrows.arrows(arrows.imports(arrows.modules(tmp_path))))
    assert [(arrow.start, arrow.end) for arrow in found] == [("gazechair.base", "gazechair.web")]
