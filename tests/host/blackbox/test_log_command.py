"""`gazechair log list`, `show` and `export`."""

from __future__ import annotations

import csv
import io
import json
import math
import re
import shutil
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest
from mcap.writer import Writer

from gazechair import cli
from gazechair.blackbox import command
from gazechair.blackbox.export import plain
from gazechair.blackbox.reader import LogFile


@pytest.fixture
def config(tmp_path: Path, recorded: Path) -> list[str]:
    """--config of a host with two files, the second cut by a power failure."""
    folder = tmp_path / "state" / "log"
    folder.mkdir(parents=True)
    shutil.copy(recorded, folder / "000007_2026-09-21T14-13-20.mcap")
    cut = recorded.read_bytes()[: recorded.stat().st_size * 2 // 3]
    (folder / "000008_2026-09-21T15-13-20.mcap").write_bytes(cut)
    file = tmp_path / "chair.toml"
    file.write_text(f'[web]\nstate_folder = "{tmp_path}/state"\n')
    return ["--config", str(file)]


def test_list(config: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["log", "list", *config]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("000007_2026-09-21T14-13-20.mcap  ")
    assert " 4 s" in lines[0]
    assert lines[0].endswith("MB")
    assert "000008_2026-09-21T15-13-20.mcap is readable up to 20" in lines[2]
    assert lines[3].endswith("MB")


READABLE = (
    r"000008\S* is readable up to 2026-09-21 ..:13:2[0-4] \((\d+) of (\d+) bytes\) and ends there: "
)


@pytest.mark.parametrize("damaged", [False, True])
@pytest.mark.parametrize(
    "words", [["list"], ["show"], ["export"], ["export", "--topic", "/board/state"]]
)
def test_it_says_up_to_where_a_file_is_readable_that_ends_early(
    config: list[str], capsys: pytest.CaptureFixture[str], words: list[str], damaged: bool
) -> None:
    folder = Path(config[1]).parent / "state" / "log"
    (whole,) = folder.glob("000007*")
    (cut,) = folder.glob("000008*")
    if damaged:
        data = bytearray(whole.read_bytes())
        data[len(data) // 3] ^= 0xFF
        cut.write_bytes(data)
    assert cli.main(["log", *words, *config]) == 0
    printed = capsys.readouterr()
    ((read, size),) = re.findall(READABLE, printed.out if words == ["list"] else printed.err)
    assert 0 < int(read) < int(size) == cut.stat().st_size
    cut.unlink()
    assert cli.main(["log", *words, *config]) == 0
    printed = capsys.readouterr()
    assert "is readable" not in printed.out + printed.err


def test_a_file_that_cannot_be_read_hides_no_other(
    config: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    folder = Path(config[1]).parent / "state" / "log"
    (folder / "000005_2026-09-21T13-13-20.mcap").write_bytes(b"\x89MCAP0\r\n" + bytes(12))
    (folder / "000006_2026-09-21T14-12-20.mcap").symlink_to(folder / "deleted")
    assert cli.main(["log", "list", *config]) == 0
    lines = capsys.readouterr().out.splitlines()
    rows = [line for line in lines if line.startswith("0")]
    assert [row[:6] for row in rows] == ["000005", "000006", "000007", "000008"]
    assert "000005_2026-09-21T13-13-20.mcap is not readable and ends there" in lines[1]
    assert rows[1].endswith("No such file or directory")


def test_show_says_what_happened_once(
    config: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["log", "show", "7", *config]) == 0
    printed = [line[24:] for line in capsys.readouterr().out.splitlines()]
    order = [
        "order: arm by driver",
        "board: armed, stopped, override none, faults none",
        "board: armed, forward, override none, faults none",
        "host: session ended: unplugged ?",
        "board: armed, turn, override none, faults none",
    ]
    assert [line for line in printed if line in order][:3] == order[:3]
    assert set(order) <= set(printed)
    assert all(a != b for a, b in pairwise(printed))
    assert sum(line.startswith("command: forward continuous") for line in printed) == 1


def test_export(config: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["log", "export", *config]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert len(lines) > 300
    scan = next(line for line in lines if line["topic"] == "/scan/front")
    assert scan["ranges"][:2] == [None, 1.0]
    assert scan["type"] == "sensor_msgs/msg/LaserScan"
    assert cli.main(["log", "export", "8", "--topic", "/board/state", *config]) == 0
    cut = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert {line["topic"] for line in cut} == {"/board/state"}
    table = ["log", "export", "8", "--format", "csv", "--topic", "/board/state", *config]
    assert cli.main(table) == 0
    rows = [*csv.DictReader(io.StringIO(capsys.readouterr().out))]
    assert [int(row["faults"]) for row in rows] == [line["faults"] for line in cut]
    assert rows[0]["stamp.sec"] == str(cut[0]["stamp"]["sec"])


@pytest.mark.parametrize("summary", [True, False])
def test_messages_of_other_programs_are_left_out(
    config: list[str], capsys: pytest.CaptureFixture[str], summary: bool
) -> None:
    folder = Path(config[1]).parent / "state" / "log"
    with (folder / "000009_2026-09-21T16-13-20.mcap").open("wb") as out:
        writer = Writer(out, use_statistics=summary)
        writer.start()
        about = writer.register_schema("about", "jsonschema", b"{}")
        cdr = writer.register_schema("pkg/About", "ros2idl", b"module pkg {};")
        for encoding, schema in (("json", about), ("json", 0), ("cdr", 0), ("cdr", cdr)):
            channel = writer.register_channel("/board/state", encoding, schema)
            writer.add_message(channel, 10**9, b"{}", 10**9)
        writer.finish()
    for words in (["list"], ["show", "9"], ["export", "9"]):
        assert cli.main(["log", *words, *config]) == 0
        assert ("000009" in capsys.readouterr().out) is (words == ["list"])


def without_faults(definition: bytes, data: bytes) -> tuple[bytes, bytes]:
    rows = definition.decode().split("\n")
    return "\n".join(row for row in rows if not row.endswith(" faults")).encode(), data


def cut_short(definition: bytes, data: bytes) -> tuple[bytes, bytes]:
    return definition, data[:-5]


@pytest.mark.parametrize(
    ("words", "change", "says"),
    [
        (["log", "show", "{file}"], without_faults, "another version: its State has no faults"),
        (["log", "show", "{file}"], cut_short, "message of /board/state cannot be read"),
        (["log", "export", "{file}"], cut_short, "message of /board/state cannot be read"),
        (["replay", "{file}", "--view", "{file}.svg"], cut_short, "of /board/state cannot be read"),
        (
            ["replay", "{file}", "--view", "{file}.svg"],
            without_faults,
            "another version: its State has no faults",
        ),
    ],
)
def test_a_log_of_another_version_or_program_is_said_in_one_line(
    config: list[str],
    recorded: Path,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    change: Callable[[bytes, bytes], tuple[bytes, bytes]],
    says: str,
) -> None:
    file = Path(config[1]).parent / "other.mcap"
    with file.open("wb") as out:
        writer = Writer(out)
        writer.start()
        for line in LogFile(recorded).lines():
            if line.topic == "/board/state":
                text, data = change(line.schema.data, line.data)
                schema = writer.register_schema(line.type_name, "ros2msg", text)
                channel = writer.register_channel(line.topic, "cdr", schema)
                writer.add_message(channel, line.at_ns, data, line.at_ns)
        writer.finish()
    words = [word.format(file=file) for word in words]
    assert cli.main([*words, *(config if words[0] == "log" else [])]) == 2
    printed = capsys.readouterr().err
    assert says in printed
    assert printed.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["show", "9"], "has no file 9"),
        (["export", "no.mcap"], "has no file no.mcap"),
        (["export", "--format", "csv"], "--topic /board/state"),
        (["show", "{folder}/chair.toml"], "/chair.toml is no log"),
        (["export", "{folder}/chair.toml"], "/chair.toml is no log"),
        (["export", "--topic", "/bord/state"], "no message of /bord/state; there are /board/"),
        (["export", "--format", "csv", "--topic", "/x"], "no message of /x; there are /board/"),
    ],
)
def test_refusals_are_one_line(
    config: list[str], capsys: pytest.CaptureFixture[str], words: list[str], says: str
) -> None:
    words = [word.format(folder=Path(config[1]).parent) for word in words]
    assert cli.main(["log", *words, *config]) == 2
    printed = capsys.readouterr()
    assert says in printed.err
    assert printed.err.count("\n") == 1
    assert printed.out == ""


def test_nothing_was_recorded(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "chair.toml"
    file.write_text(f'[web]\nstate_folder = "{tmp_path}/none"\n')
    assert cli.main(["log", "list", "--config", str(file)]) == 0
    assert cli.main(["log", "show", "--config", str(file)]) == 2
    assert "has no file" in capsys.readouterr().err


def test_without_the_extra_it_says_what_to_install(
    config: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def missing(_: str) -> None:
        raise ImportError

    monkeypatch.setattr(command.importlib, "import_module", missing)
    assert cli.main(["log", "list", *config]) == 2
    assert "pip install 'gazechair[log]'" in capsys.readouterr().err


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_null_as_json_has_no_word_for_it(value: float) -> None:
    assert plain([value, 1.5]) == [None, 1.5]
