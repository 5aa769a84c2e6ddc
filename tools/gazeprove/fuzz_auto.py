"""What may happen to a motion that nobody holds, for fuzz_episodes."""

from __future__ import annotations

from gazelink import codes, messages
from gazelink.settings_table import NAMES, profile_row
from gazeprove.fuzz_host import View
from gazeprove.fuzz_life import Life, Script

_MOVES = (codes.FORWARD, codes.BACKWARD, codes.LEFT, codes.RIGHT, codes.DRIVE)


def auto(life: Life) -> Script:
    """A motion that nobody holds, and what must end it; its host goes on with the press."""
    rng = life.rng
    host = life.host
    if rng.random() < 0.25:
        yield from _faster(life)
    host.watched_us = -1
    linear, turn = rng.choice(
        ((1000, 0), (-600, 0), (0, 700), (0, -1000), (700, 600), (-500, -900))
    )
    owner = life.oracle.owner or codes.DRIVER
    ttl_ms = rng.choice((60, 150, 300))
    host.press(codes.DRIVE, codes.AUTO, owner, linear=linear, turn=turn, ttl_ms=ttl_ms)
    yield rng.randrange(30, 400)
    yield from _auto_ends(life, rng.randrange(10))
    host.watched_us = -1
    host.held.refreshed = True
    host.bypass = 0
    host.view = View()
    yield rng.randrange(20, 500)


def _faster(life: Life) -> Script:
    """The chair may go faster than an auto motion may, until the next reset."""
    life.host.let_go()
    life.host.order(codes.DISARM, codes.DRIVER)
    yield 30
    life.host.forget_order()
    profile = life.oracle.rules.profile
    for name, values in (
        (profile_row(profile, "forward_mm_s"), (800, 2000)),
        (profile_row(profile, "backward_mm_s"), (800, 2000)),
        ("auto_mm_s", (250, 350)),
    ):
        yield from life.setting(codes.SETTING_SET, NAMES.index(name), life.rng.choice(values))
    yield from life.ready()


def _auto_ends(life: Life, how: int) -> Script:
    rng = life.rng
    host = life.host
    if how == 0:
        if rng.random() < 0.5:
            host.held.refreshed = False
        else:
            host.says_command = False  # its planner stalls, the rest of the host does not
        yield rng.choice((100, 149, 151, 300, 400))
        host.says_command = True
    elif how == 1:
        host.watched_us = life.world.now_us - rng.choice((0, 2_500_000, 60_000_000))
        yield rng.choice((100, 600, 3_100))
    elif how == 2:
        owner = rng.choice((codes.NOBODY, codes.DRIVER, codes.CARETAKER, 3))
        host.send(messages.SUPERVISION, edge=rng.randrange(256), owner=owner, age_ms=0)
        yield 30
        host.send(messages.SUPERVISION, edge=host.held.edge + 1 & 0xFF, owner=codes.DRIVER)
        yield 30
    elif how == 3:
        host.bypass = rng.randrange(1, 256)
        yield rng.choice((60, 300))
    elif how == 4:
        host.view = View({"unseen": 15, "arc_views": 0xF0})
        yield rng.choice((60, 1_000))
    elif how == 5:
        host.view = View({"blocked": 15, "arc_views": 0x0F})
        yield rng.choice((60, 900, 10_500))
        host.view = View()
        yield 600  # until it would go on
    elif how == 6:
        held = host.held
        host.press(
            rng.choice(_MOVES), codes.CONTINUOUS, rng.choice((codes.DRIVER, codes.CARETAKER))
        )
        yield rng.randrange(1, 60)
        host.held = held
    elif how == 7:
        host.send(messages.COMMAND, verb=codes.STOP, cap_permille=1000)
        yield 20
    elif how == 8:
        host.held.mode = rng.choice((codes.CONTINUOUS, codes.STEP))
        yield rng.randrange(1, 60)
        host.held.mode = codes.AUTO
    else:
        yield rng.choice((1_000, 10_300))
