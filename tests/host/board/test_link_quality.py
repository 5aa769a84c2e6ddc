"""How the link is judged, in virtual time."""

import pytest

from gazechair.board.link_quality import LinkJudge, Verdict


@pytest.fixture
def judge() -> LinkJudge:
    judge = LinkJudge()
    judge.opened("/dev/a", 0.0)
    return judge


def seen(verdict: Verdict | None) -> tuple[str, str, bool] | None:
    return verdict and (verdict.state, verdict.reason, verdict.give_up)


def test_before_an_answer_nothing_is_said(judge: LinkJudge) -> None:
    assert judge.verdict(0, 2.9) is None


def test_a_port_that_never_answered_is_the_wrong_one(judge: LinkJudge) -> None:
    verdict = judge.verdict(0, 3.1)
    assert seen(verdict) == ("lost", "wrong_port", True)
    assert verdict is not None
    assert verdict.detail.startswith("/dev/a has not answered")


def test_a_board_that_answered_before_is_lost_not_wrong(judge: LinkJudge) -> None:
    judge.began(1.0)
    judge.ended(2.0)
    judge.opened("/dev/a", 3.0)
    assert seen(judge.verdict(0, 6.1)) == ("lost", "board_lost", True)


def test_another_version_is_told_and_the_port_kept(judge: LinkJudge) -> None:
    judge.differs("flash it", 2.9)
    assert judge.verdict(0, 5.0) == Verdict("lost", "version_differs", "flash it")


def test_the_right_version_ends_that(judge: LinkJudge) -> None:
    judge.differs("flash it", 1.0)
    judge.began(2.0)
    assert seen(judge.verdict(0, 2.1)) == ("ok", "ok", False)


@pytest.mark.parametrize(
    ("quiet_s", "expected"),
    [
        (0.29, ("ok", "ok", False)),
        (0.31, ("degraded", "board_lost", False)),
        (2.01, ("lost", "board_lost", False)),
    ],
)
def test_silence_degrades_then_loses(
    judge: LinkJudge, quiet_s: float, expected: tuple[str, str, bool]
) -> None:
    judge.began(1.0)
    judge.received(5.0)
    assert seen(judge.verdict(0, 5.0 + quiet_s)) == expected


def test_a_board_that_does_not_read_is_busy(judge: LinkJudge) -> None:
    judge.began(1.0)
    assert seen(judge.verdict(0.051, 1.1)) == ("degraded", "board_busy", False)
    assert seen(judge.verdict(0.0, 1.2)) == ("ok", "ok", False)


def test_a_board_that_does_not_start_is_shown_with_its_reason(judge: LinkJudge) -> None:
    judge.refuses("watchdog_boots", "3 watchdog resets", 2.9)
    assert judge.verdict(0, 5.0) == Verdict("lost", "watchdog_boots", "3 watchdog resets")
    assert seen(judge.verdict(0, 6.0)) == ("lost", "wrong_port", True)  # and then nothing more
    judge.opened("/dev/a", 7.0)
    judge.refuses("watchdog_boots", "3 watchdog resets", 7.0)
    judge.began(7.5)
    judge.refuses("wiper", "said in a session", 7.6)
    judge.ended(8.0)
    assert judge.verdict(0, 8.1) is None
