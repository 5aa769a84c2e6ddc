"""The steps on a board's flash: what is copied; a whole firmware is there at any moment."""

import itertools
from pathlib import Path

import pytest

from fakeboardfiles import FakeBoardFiles
from gazechair.service.flash import tree
from gazechair.service.flash.deploy import OLD_MAIN, Deployment
from gazechair.service.flash.errors import FlashError
from gazechair.service.flash.tree import Sources, Tree


def make_tree(folder: Path, number: int) -> Tree:
    """A small firmware; each number gives another one."""
    folder = folder / str(number)
    (folder / "gazeboard").mkdir(parents=True, exist_ok=True)
    main = folder / "main.py"
    main.write_text("neutral()\n\nfrom gazeboard import app\n")
    files = {}
    for name in ("app", "link"):
        file = folder / "gazeboard" / f"{name}.py"
        file.write_text(f"{name} = {number}\n" * 50)
        files[f"gazeboard/{name}.py"] = file
    return tree.build(Sources(files, main), None)


def deploy(board: FakeBoardFiles, new: Tree) -> None:
    deployment = Deployment(board, new, watchdog=True)
    deployment.copy(lambda path, count: None)
    deployment.switch()


def roll_back(board: FakeBoardFiles, new: Tree) -> str:
    return Deployment(board, new, watchdog=False).roll_back()


def whole_firmware(board: FakeBoardFiles, *trees: Tree) -> Tree | None:
    """The one that the board starts; fails when that one is not whole."""
    main = board.files.get(tree.MAIN)
    if main is None:
        return None
    (started,) = [t for t in trees if t.main == main]
    for path, content in started.files.items():
        assert board.files.get(f"{started.folder}/{path}") == content, path
    return started


def test_main_chooses_its_folder_after_neutral_and_before_any_import(tmp_path: Path) -> None:
    new = make_tree(tmp_path, 1)
    lines = new.main.decode().split("\n")
    assert lines[0] == "neutral()"
    assert lines.index(f'sys.path.insert(0, "/flash/{new.name}")') < lines.index(
        "from gazeboard import app"
    )
    assert tree.named_by(new.main.decode()) == new.name
    assert tree.named_by("from gazeboard import app\n") == ""


def test_main_of_this_checkout_is_stamped_behind_promise_1() -> None:
    new = tree.build(tree.find_sources(), None)
    text = new.main.decode()
    compile(text, "main.py", "exec")
    assert text.index("writeto") < text.index("kbd_intr(-1)") < text.index("sys.path.insert")
    assert text.index("sys.path.insert") < text.index("from gazeboard")


def test_nothing_only_a_pc_needs_is_flashed() -> None:
    paths = set(tree.find_sources().files)
    assert {"gazelink/frame.py", "gazeboard/app.py", "gazeboard/boards/teensy40.py"} <= paths
    assert not [p for p in paths if "unix" in p or "virtual" in p or "bank" in p]


def test_another_content_is_another_folder(tmp_path: Path) -> None:
    assert make_tree(tmp_path, 1).name == make_tree(tmp_path / "again", 1).name
    assert make_tree(tmp_path, 1).name != make_tree(tmp_path, 2).name


def test_a_fresh_board_gets_everything(tmp_path: Path) -> None:
    board, new = FakeBoardFiles(), make_tree(tmp_path, 1)
    assert not Deployment(board, new, watchdog=False).up_to_date()
    deploy(board, new)
    assert whole_firmware(board, new) == new
    assert Deployment(board, new, watchdog=False).up_to_date()


def test_main_is_the_last_thing_changed_and_by_a_rename(tmp_path: Path) -> None:
    board = FakeBoardFiles()
    deploy(board, make_tree(tmp_path, 1))
    deploy(board, make_tree(tmp_path, 2))
    assert board.changes[-1] == f"rename {tree.MAIN}.new {tree.MAIN}"
    assert not [change for change in board.changes if change == f"write {tree.MAIN}"]


def test_the_firmware_before_stays_until_the_next_flash(tmp_path: Path) -> None:
    board = FakeBoardFiles()
    first, second, third = (make_tree(tmp_path, n) for n in (1, 2, 3))
    deploy(board, first)
    deploy(board, second)
    assert first.name in board.folders("/flash")
    deploy(board, third)
    assert set(board.folders("/flash")) == {second.name, third.name}


def test_rolls_back_to_the_firmware_before(tmp_path: Path) -> None:
    board = FakeBoardFiles()
    first, second = make_tree(tmp_path, 1), make_tree(tmp_path, 2)
    deploy(board, first)
    deploy(board, second)
    assert roll_back(board, second) == "the firmware before is back"
    assert whole_firmware(board, first, second) == first


@pytest.mark.parametrize("damaged", [False, True])
def test_the_same_firmware_again_keeps_the_one_before(tmp_path: Path, damaged: bool) -> None:
    board = FakeBoardFiles()
    first, second = make_tree(tmp_path, 1), make_tree(tmp_path, 2)
    deploy(board, first)
    deploy(board, second)
    if damaged:
        board.files[f"{second.folder}/gazeboard/link.py"] = b"half"
    for _ in range(2):
        deploy(board, second)
        assert whole_firmware(board, first, second) == second
    assert roll_back(board, second) == "the firmware before is back"
    assert whole_firmware(board, first, second) == first


def test_a_firmware_before_that_is_gone_is_said_and_not_started(tmp_path: Path) -> None:
    board = FakeBoardFiles()
    first, second, third = (make_tree(tmp_path, n) for n in (1, 2, 3))
    deploy(board, first)
    deploy(board, second)
    Deployment(board, third, watchdog=True).copy(lambda path, count: None)  # and then the cable
    deploy(board, second)
    printed = roll_back(board, second)
    assert f"({first.name}) is no longer on the board" in printed
    assert whole_firmware(board, first, second, third) == second


def test_rolls_back_to_nothing_where_nothing_was(tmp_path: Path) -> None:
    board, new = FakeBoardFiles(), make_tree(tmp_path, 1)
    deploy(board, new)
    assert "starts nothing" in roll_back(board, new)
    assert tree.MAIN not in board.files


def test_a_foreign_main_is_kept_for_going_back(tmp_path: Path) -> None:
    board, new = FakeBoardFiles(), make_tree(tmp_path, 1)
    board.files[tree.MAIN] = b"print('mine')\n"
    deploy(board, new)
    assert board.files[OLD_MAIN] == b"print('mine')\n"
    assert roll_back(board, new) == "the firmware before is back"
    assert board.files[tree.MAIN] == b"print('mine')\n"


def test_the_plug_pulled_at_any_moment_leaves_a_whole_firmware(tmp_path: Path) -> None:
    first, second = make_tree(tmp_path, 1), make_tree(tmp_path, 2)
    outcomes = []
    for cut_at in itertools.count():
        board = FakeBoardFiles()
        deploy(board, first)
        board.changes.clear()
        board.power_cut_at = cut_at
        try:
            deploy(board, second)
        except FlashError:
            outcomes.append(whole_firmware(board, first, second))
        else:
            break
        board.power_cut_at = None
        deploy(board, second)  # and flashing again always ends well
        assert whole_firmware(board, first, second) == second
    assert len(outcomes) >= 7
    assert set(map(id, outcomes)) == {id(first)}, "until the last rename it is the old one"


def test_copies_only_what_is_missing_or_damaged(tmp_path: Path) -> None:
    board, new = FakeBoardFiles(), make_tree(tmp_path, 1)
    deploy(board, new)
    board.files[f"{new.folder}/gazeboard/link.py"] = b"half"
    copied = []
    Deployment(board, new, watchdog=False).copy(lambda path, count: copied.append(path))
    assert copied == ["gazeboard/link.py"]


def test_a_file_that_arrives_damaged_is_noticed(tmp_path: Path) -> None:
    class Damaging(FakeBoardFiles):
        def write(self, path: str, content: bytes) -> None:
            super().write(path, content[:-1] + b"?")

    with pytest.raises(FlashError, match="did not arrive as it was sent"):
        deploy(Damaging(), make_tree(tmp_path, 1))


def test_a_full_board_is_refused_before_anything_is_copied(tmp_path: Path) -> None:
    board = FakeBoardFiles()
    board.free = 10_000
    with pytest.raises(FlashError, match="9 kB left and the firmware needs 72 kB"):
        deploy(board, make_tree(tmp_path, 1))
    assert not board.changes


def test_the_watchdog_is_fed_only_where_it_runs(tmp_path: Path) -> None:
    fed, not_fed = FakeBoardFiles(), FakeBoardFiles()
    deploy(fed, make_tree(tmp_path, 1))
    Deployment(not_fed, make_tree(tmp_path, 1), watchdog=False).copy(lambda path, count: None)
    assert fed.feeds == 1
    assert not_fed.feeds == 0
