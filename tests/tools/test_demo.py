"""The demo while it runs: a host that is slow, and what is refused; the stack is a stand-in."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from gazechair.people.pairing.local import NotRunning, RequestRefused
from gazedemo import demo
from gazedemo.stack import StackError

SLOW = NotRunning("no gazechair run answers")


class Stack:
    """Its host answers each question with the next of `answers`, and ends after the last."""

    def __init__(self, answers: list[str | bool | Exception]) -> None:
        self.answers = answers
        self.state_folder = Path()

    def __enter__(self) -> Stack:
        return self

    def __exit__(self, *_error: object) -> None:
        pass

    def check_alive(self) -> None:
        if not self.answers:
            raise StackError("host ended (1): no message")

    def invitation(self) -> str:
        return str(self.answer())

    def answer(self, *_question: object) -> str | bool:
        answer = self.answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """No signals, no browser, no waiting."""
    monkeypatch.setattr(demo.ending, "listen", lambda: None)
    monkeypatch.setattr(demo.time, "sleep", lambda _s: None)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)


def run(
    monkeypatch: pytest.MonkeyPatch, *answers: str | bool | Exception, config: Path | None = None
) -> int:
    """The demo's exit code."""
    stack = Stack([*answers])
    monkeypatch.setattr(demo, "_stack", lambda _arguments, **_more: stack)
    monkeypatch.setattr(demo.pairing, "is_open", stack.answer)
    return demo.demo(argparse.Namespace(check=False, home=False, port=0, config=config))


def test_it_goes_on_while_the_host_is_slow_to_answer(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    answers = ["first", SLOW, True, False, SLOW, False, "second", True]
    assert run(monkeypatch, *answers) == 2
    output = capsys.readouterr()
    assert "page: first\n" in output.out
    assert "browser: second\n" in output.out
    assert output.err == "tools/demo: host ended (1): no message\n"


def test_without_any_answer_it_says_so_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, SLOW) == 2
    assert capsys.readouterr().err == "tools/demo: no gazechair run answers\n"


def test_a_refusal_of_the_host_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, RequestRefused("gazechair run refuses: too many codes")) == 2
    assert capsys.readouterr().err == "tools/demo: gazechair run refuses: too many codes\n"


def test_a_configuration_that_is_no_text_is_refused_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    config = tmp_path / "more.toml"
    config.write_bytes(b"\xff")
    assert run(monkeypatch, config=config) == 2
    assert capsys.readouterr().err == f"tools/demo: {config} is not text in UTF-8\n"
