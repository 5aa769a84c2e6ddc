"""What may happen in a life: presses, people and frames here, failing parts in fuzz_spoilt.

Each episode is a script over a Life, drawn by its weight.
"""

from __future__ import annotations

from collections.abc import Callable

from gazelink import codes, frame, messages
from gazeprove import fuzz_auto as auto
from gazeprove import fuzz_spoilt as spoilt
from gazeprove.fuzz_life import Life, Script

_MOVES = (codes.FORWARD, codes.BACKWARD, codes.LEFT, codes.RIGHT, codes.DRIVE)


def presses(life: Life) -> Script:
    """Presses one after another, let go or not."""
    rng = life.rng
    for _ in range(rng.randrange(1, 5)):
        yield from life.drive()
        yield rng.randrange(1, 200)
        if rng.random() < 0.5:
            life.host.let_go()
            yield rng.randrange(1, 60)


def long_press(life: Life) -> Script:
    """A step to its end, or a pulse."""
    rng = life.rng
    verb = rng.choice(_MOVES)
    if rng.random() < 0.3:
        life.host.press(
            rng.choice(_MOVES),
            codes.TUNE,
            life.oracle.owner,
            linear=rng.randrange(-1000, 1000),
            turn=rng.randrange(-1000, 1000),
            pulse_ms=rng.choice((50, 300, 2500)),
        )
        yield rng.choice((400, 2600))
    else:
        yield from life.drive(verb=verb, mode=rng.choice((codes.STEP, codes.CONTINUOUS)))
        yield rng.choice((300, 2300, 6300))
    life.host.let_go()


def lapse(life: Life) -> Script:
    """The hold is not refreshed while the host talks on; then it is again."""
    rng = life.rng
    yield from life.drive(mode=codes.CONTINUOUS)
    held = life.host.held
    how = rng.randrange(3)
    if how == 0:
        held.refreshed = False
    elif how == 1:
        held.refreshed = False
        held.until_us = 0
    else:
        life.host.says_command = False
    yield rng.randrange(50, 500)
    held.refreshed = True
    life.host.says_command = True
    yield rng.randrange(20, 200)


def silence(life: Life) -> Script:
    """The host says nothing for a while; the press may go on behind it."""
    rng = life.rng
    yield from life.drive()
    life.host.alive = False
    for _ in range(rng.choice((1, 2, 6, 10, 30))):
        if rng.random() < 0.5:
            replay(life, rng.randrange(1, 8))
        yield rng.randrange(5, 40)
    life.host.alive = True
    yield rng.randrange(20, 200)


def emergency(life: Life) -> Script:
    """The input or the message; then those who may reset it and those who may not."""
    rng = life.rng
    yield from life.drive()
    if rng.random() < 0.5:
        life.world.emergency_level = 1
        yield rng.choice((1, 3, 100))
        if rng.random() < 0.3:
            life.host.order(codes.RESET_FAULTS, codes.CARETAKER)
            yield 50
        life.world.emergency_level = 0
    else:
        life.host.order(codes.EMERGENCY_STOP, rng.randrange(3))
        yield rng.randrange(1, 30)
        life.host.forget_order()
    yield rng.randrange(1, 40)
    life.host.let_go()
    if rng.random() < 0.6:
        life.boot(rng.choice((1, 5)))
        yield 300
    if rng.random() < 0.5:
        life.host.order(codes.RESET_FAULTS, rng.choice((codes.DRIVER, codes.NOBODY)))
        yield 650
    life.host.order(codes.ARM, codes.DRIVER)
    yield 220
    if rng.random() < 0.3:
        life.world.button_level = 0
        yield rng.choice((100, 2_900, 3_050))
        life.world.button_level = 1


def others_stop(life: Life) -> Script:
    """Somebody says stop, once, while the driver holds on."""
    rng = life.rng
    yield from life.drive()
    held = life.host.held
    stop = type(held)(owner=rng.randrange(3))
    for _ in range(rng.randrange(1, 3)):
        if rng.random() < 0.5:
            life.host.send_command(stop, 0)
            life.host.send_command(held, 300)
        else:
            life.host.send_command(held, 300)
            life.host.send_command(stop, 0)
        yield rng.randrange(1, 40)
    yield rng.randrange(1, 200)


def two_people(life: Life) -> Script:
    """Somebody who does not own the chair commands it, or takes it over."""
    rng = life.rng
    yield from life.drive()
    other = codes.DRIVER if life.oracle.owner == codes.CARETAKER else codes.CARETAKER
    if rng.random() < 0.5:
        life.host.order(codes.ARM, other, rng.randrange(1, 3))
    if rng.random() < 0.5:
        old = life.host.held
        life.host.press(rng.choice(_MOVES[:4]), codes.CONTINUOUS, other)
        yield rng.randrange(1, 100)
        if rng.random() < 0.5:
            life.host.held = old
    else:
        life.host.held.owner = other
    yield rng.randrange(20, 400)


def two_orders(life: Life) -> Script:
    """Two orders in one slice, each once or twice, armed, arming or at rest."""
    rng = life.rng
    if rng.random() < 0.6:
        yield from life.drive()
    elif rng.random() < 0.5:
        life.host.order(codes.DISARM, codes.DRIVER)
        life.host.let_go()
        yield 700
    for _ in range(rng.randrange(2, 4)):
        life.host.order(rng.randrange(4), rng.randrange(3), rng.randrange(1, 3))
        if rng.random() < 0.2:
            yield rng.randrange(1, 60)
    yield rng.randrange(1, 400)
    life.host.forget_order()


def replay(life: Life, count: int) -> None:
    """Some recorded frames once more, byte for byte."""
    recorded = life.host.recorded
    if recorded:
        oldest = max(0, len(recorded) - life.rng.choice((4, 12, 150)))
        start = life.rng.randrange(oldest, len(recorded))
        for _, data, sent in recorded[start : start + count]:
            life.host.inject(data, sent, "replayed")


def arm_again(life: Life) -> Script:
    """Disarmed out of a motion, and armed again sooner or later than that may be."""
    rng = life.rng
    yield from life.drive()
    life.host.let_go()
    yield rng.randrange(1, 30)
    life.host.order(codes.DISARM, codes.DRIVER)
    life.host.forget_order()
    yield rng.randrange(200, 620)
    life.host.order(codes.ARM, codes.DRIVER)
    yield 130
    yield from life.drive()


def attack(life: Life) -> Script:
    """Frames nobody meant, around a press, a stop and an arming."""
    rng = life.rng
    host = life.host
    if rng.random() < 0.3:
        host.order(codes.DISARM, codes.DRIVER)
    else:
        yield from life.drive()
        if rng.random() < 0.6:
            host.let_go()
    for _ in range(rng.randrange(2, 25)):
        how = rng.randrange(5)
        if how == 0:
            replay(life, rng.randrange(1, 12))
        elif how == 1 and host.recorded:
            _, data, sent = host.recorded[-rng.randrange(1, min(12, len(host.recorded)) + 1)]
            spoilt = bytearray(data)
            for _ in range(rng.randrange(1, 4)):
                spoilt[rng.randrange(len(spoilt))] ^= 1 << rng.randrange(8)
            host.inject(bytes(spoilt) + b"\0", sent, "corrupt")
        elif how == 2:
            _of_others(life)
        elif how == 3:
            noise = bytes(rng.randrange(256) for _ in range(rng.randrange(1, 40)))
            if host.recorded:
                host.inject(noise + b"\0", host.recorded[-1][2], "noise")
        else:
            _impossible(life)
        yield rng.randrange(1, 30)
    yield rng.randrange(1, 100)


def _of_others(life: Life) -> None:
    rng = life.rng
    keys, why = rng.choice(life.host.keys_of_others())
    owner = rng.randrange(3)
    _foreign_command(life, keys, why, owner)
    if rng.random() < 0.5:
        _foreign_order(life, keys, why, owner)


def _foreign_command(life: Life, keys: frame.Session, why: str, owner: int) -> None:
    life.host.foreign(
        messages.COMMAND,
        keys,
        why,
        verb=life.rng.choice(_MOVES[:4]),
        mode=codes.CONTINUOUS,
        edge=life.rng.randrange(1, 256),
        owner=owner,
        ttl_ms=300,
        cap_permille=1000,
    )


def _foreign_order(life: Life, keys: frame.Session, why: str, owner: int) -> None:
    life.host.foreign(
        messages.ORDER, keys, why, action=codes.ARM, number=life.rng.randrange(256), owner=owner
    )


def _impossible(life: Life) -> None:
    """An honest frame with a value that means nothing."""
    rng = life.rng
    held = type(life.host.held)(
        verb=rng.choice((*_MOVES, 6, 255)),
        mode=rng.choice((1, 3, 255)),
        edge=rng.choice((0, rng.randrange(256))),
        owner=rng.choice((0, 3, 255)),
        linear=rng.choice((0, 1001, -32768)),
        cap=rng.choice((1000, 1001, 65535)),
        press=-rng.randrange(1, 1 << 30),
    )
    life.host.send_command(held, rng.choice((0, 300, 65535)))


def late_line(life: Life) -> Script:
    """What the host says waits and then comes all at once; something may be among it."""
    rng = life.rng
    host = life.host
    if rng.random() < 0.5:
        yield from life.drive()
        host.stalled = True
        if rng.random() < 0.5:
            yield from life.drive()
        yield rng.choice((30, 80, 105, 150, 400))
        host.stalled = False
    else:
        yield from _late_word(life)
    yield rng.randrange(20, 300)
    host.delay_us = rng.choice((0, 0, 3_000, 30_000, 90_000))
    yield rng.randrange(20, 300)
    host.delay_us = 0


def _late_word(life: Life) -> Script:
    """One order or press, then nothing; it comes with the next word, late by then or not."""
    rng = life.rng
    host = life.host
    order = rng.random() < 0.6
    if order:
        host.order(codes.DISARM, codes.DRIVER)
        host.let_go()
        yield 700
    else:
        yield from life.drive()
        host.let_go()
        yield 30
    host.stalled = True
    if order:
        host.order(codes.ARM, codes.DRIVER)
        host.forget_order()
    else:
        host.press(rng.choice(_MOVES[:4]), codes.CONTINUOUS, life.oracle.owner)
        host.say_command()
        host.says_command = False
    host.alive = False
    yield rng.choice((60, 90, 101, 110, 130, 200))
    host.alive = True
    host.stalled = False
    yield 60
    host.says_command = True


def new_session(life: Life) -> Script:
    """The host begins anew while it drives; or another one does."""
    rng = life.rng
    yield from life.drive()
    if rng.random() < 0.5:
        life.host.new_session()
        life.host.press(rng.choice(_MOVES[:4]), codes.CONTINUOUS, life.oracle.owner)
    else:
        life.world.serial.cut()
        life.host.new_session()
    yield rng.randrange(20, 600)


def deaf_host(life: Life) -> Script:
    """The host reads nothing for a while, or slowly."""
    yield from life.drive()
    serial = life.world.serial
    serial.reading = life.rng.random() < 0.5
    serial.takes = life.rng.choice((1, 7))
    yield life.rng.choice((30, 150, 600))
    serial.reading = True
    serial.takes = 0
    yield 100


EPISODES: tuple[tuple[int, Callable[[Life], Script]], ...] = (
    (6, presses),
    (2, long_press),
    (8, auto.auto),
    (4, lapse),
    (4, silence),
    (3, spoilt.stalled_service),
    (2, spoilt.stalled_tick),
    (5, spoilt.obstacle),
    (3, spoilt.old_eyes),
    (2, spoilt.bypass),
    (4, emergency),
    (3, others_stop),
    (4, two_people),
    (4, two_orders),
    (2, arm_again),
    (4, spoilt.failing_pot),
    (5, spoilt.failing_imu),
    (3, spoilt.tilt),
    (2, spoilt.dead_sensor),
    (2, spoilt.relay),
    (6, attack),
    (4, late_line),
    (3, spoilt.reset),
    (2, new_session),
    (2, spoilt.exception),
    (2, deaf_host),
    (3, spoilt.other_pace),
    (1, spoilt.flaky_pot),
    (2, spoilt.pushed),
    (2, spoilt.spoilt_files),
    (2, spoilt.full_flash),
    (3, spoilt.settings),
)
