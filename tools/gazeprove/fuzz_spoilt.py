"""Episodes in which the board and what hangs on it fail: loops, sensors, wipers, relay, power.

Each is a script over a Life: it brings the chair to drive, then spoils one thing, and mostly mends
it again; the next episode copes.
"""

from __future__ import annotations

from gazelink import arcs, codes
from gazelink.settings_table import NAMES, TABLE
from gazeprove.fuzz_board import DEAF, LYING, NAK, STUCK
from gazeprove.fuzz_host import View
from gazeprove.fuzz_life import FOLLOWS, STAYS_CLOSED, STAYS_OPEN, Life, Script

FILES = ("settings.json", "emergency", "watchdog_boots", "heading_offsets")
NEUTRAL = ("neutral_linear_count", "neutral_turn_count")
_TRIED = (
    *NEUTRAL,
    "linear_permille",
    "turn_permille",
    "step_turn_permille",
    "hold_permille",
    "step_forward_ms",
    "step_turn_limit_ms",
    "stop_margin_mm",
    "stop_margin_q4_deg",
    "creep_mm_s",
    "profile",
    "tilt_limit_q4_deg",
)
_TURNS = (codes.LEFT, codes.RIGHT)
_NEAR = {
    "forward_mm": (0, 50, 99, 300, 800),
    "backward_mm": (0, 50, 99, 300, 800),
    "left_q4_deg": (0, 20, 47, 200, 700),
    "right_q4_deg": (0, 20, 47, 200, 700),
}


def stalled_service(life: Life) -> Script:
    """The service loop does not come back for a while."""
    rng = life.rng
    yield from life.drive()
    life.service_alive = False
    yield rng.choice((20, 45, 55, 80, 300, 520, 700))
    life.service_alive = True
    yield rng.randrange(20, 200)


def stalled_tick(life: Life) -> Script:
    """Time passes without a tick."""
    rng = life.rng
    yield from life.drive()
    for _ in range(rng.choice((1, 1, 3))):
        life.gap_us = rng.choice((19_500, 20_500, 60_000, 400_000))
        yield rng.randrange(1, 100)


def obstacle(life: Life) -> Script:
    """Something comes into a way, stays or goes; the press goes on."""
    rng = life.rng
    yield from life.drive()
    view = View()
    for name, near in _NEAR.items():
        if rng.random() < 0.5:
            view.fields[name] = rng.choice(near)
    if rng.random() < 0.5:
        view.fields["blocked"] = rng.randrange(16)
    if rng.random() < 0.3:
        view.fields["unseen"] = rng.randrange(16)
    if rng.random() < 0.5:
        view.fields["arcs"] = rng.choice((bytes(arcs.SIZE), rng.randbytes(arcs.SIZE)))
    if rng.random() < 0.2:
        view.fields["arc_views"] = rng.choice((15, rng.randrange(256)))
    life.host.view = view
    life.host.clearance_every_us = rng.choice((2_000, 20_000, 50_000))
    yield rng.randrange(2, 250)
    if rng.random() < 0.3:
        life.host.bypass = rng.randrange(1, 256)
        yield rng.randrange(20, 200)
        yield from life.drive()
    if rng.random() < 0.7:
        life.host.view = View()
        yield rng.randrange(60, 500)
    life.host.bypass = 0
    life.host.view = View()
    yield 60


def old_eyes(life: Life) -> Script:
    """Obstacle data stop, grow old on their way or come from elsewhere."""
    rng = life.rng
    yield from life.drive()
    how = rng.randrange(4)
    if how == 0:
        life.host.view = None
    elif how == 1 and life.host.view is not None:
        life.host.view.frozen_at_us = life.world.now_us
    elif how == 2:
        life.host.view = View(age_ms=rng.choice((200, 280, 305, 400, 65535)))
    else:
        life.host.view = View({"source": rng.randrange(4)})
    yield rng.randrange(50, 500)
    life.host.view = View()
    yield rng.randrange(20, 200)


def bypass(life: Life) -> Script:
    """A bypass held on and on, before something near."""
    rng = life.rng
    life.host.view = View({"forward_mm": 40, "backward_mm": 40})
    life.host.bypass = rng.randrange(1, 256)
    yield 60
    yield from life.drive(verb=codes.FORWARD, mode=codes.CONTINUOUS)
    if rng.random() < 0.1:
        for _ in range(4):  # other numbers make no new time
            yield 5_200
            life.host.bypass = life.host.bypass % 255 + 1
    else:
        yield rng.choice((300, 900, 2_000))
    life.host.bypass = 0
    yield 400
    life.host.view = View()
    yield 60


def failing_pot(life: Life) -> Script:
    """Writes fail or lie, for some transfers or until told."""
    rng = life.rng
    yield from life.drive()
    for _ in range(rng.randrange(1, 4)):
        life.world.pot.fault = rng.choice((NAK, STUCK, DEAF, LYING))
        life.world.pot.fails_for = rng.choice((1, 2, 3, 4, 6, 9, 40))
        yield rng.randrange(1, 12)
    yield rng.randrange(10, 60)
    life.world.pot.fault = 0
    life.world.pot.fails_for = -1
    if rng.random() < 0.4:
        life.host.let_go()
        yield 600
        life.host.order(codes.ARM, codes.DRIVER)
        yield 220


def failing_imu(life: Life) -> Script:
    """The heading sensor freezes, jumps, resets itself or leaves its bus, mostly in a turn."""
    rng = life.rng
    verb = rng.choice((*_TURNS, *_TURNS, codes.DRIVE, codes.FORWARD))
    yield from life.drive(verb=verb, turn=rng.choice((500, -500)) if verb == codes.DRIVE else 0)
    yield rng.randrange(1, 200)
    chair, world = life.chair, life.world
    how = rng.randrange(5)
    if how == 0:
        chair.freeze()
    elif how == 1:
        world.spoil_imu(rng.choice((NAK, STUCK)))
    elif how == 2:
        world.imu.power_on()
        chair.unfit_us = world.now_us
    elif how == 3:
        chair.jump(rng.choice((20, -30, 90, 180)))
    else:
        for _ in range(rng.randrange(1, 6)):
            chair.spike_deg = rng.choice((20, -30, 90))
            yield rng.choice((10, 20, 60))
    yield rng.choice((20, 60, 150, 600))
    chair.thaw()
    world.spoil_imu(0)
    yield rng.randrange(10, 100)
    if rng.random() < 0.5:
        yield from life.drive(verb=rng.choice(_TURNS))
    yield rng.choice((10, 300))


def dead_sensor(life: Life) -> Script:
    """No heading and no tilt for long, on level ground or not; the chair is driven straight on."""
    rng = life.rng
    limit = life.oracle.rules.tilt_limit_deg
    life.chair.tilt(rng.choice((0, 0.3, 0.8)) * limit, limit)
    yield 400
    how = rng.randrange(3)
    if how == 0:
        life.chair.freeze()
    elif how == 1:
        life.world.spoil_imu(rng.choice((NAK, STUCK)))
    else:
        life.world.imu.power_on()
        life.chair.unfit_us = life.world.now_us
        life.chair.freeze()
    for _ in range(rng.choice((1, 1, 5))):
        yield from life.drive(verb=rng.choice((codes.FORWARD, codes.BACKWARD)))
        yield rng.choice((300, 1_500))
    life.chair.thaw()
    life.world.spoil_imu(0)
    life.chair.tilt(0.0, limit)
    yield 700


def tilt(life: Life) -> Script:
    """The chair stands askew for a while."""
    rng = life.rng
    yield from life.drive()
    limit = life.oracle.rules.tilt_limit_deg
    life.chair.tilt(rng.choice((-1, 1)) * (limit + rng.choice((1.5, 5, 20))), limit)
    yield rng.choice((50, 90, 130, 300))
    life.chair.tilt(0.0, limit)
    yield rng.randrange(20, 300)


def relay(life: Life) -> Script:
    """The relay's contact does not follow."""
    rng = life.rng
    if rng.random() < 0.5:
        yield from life.drive()
    life.relay = rng.choice((STAYS_OPEN, STAYS_CLOSED))
    yield rng.choice((5, 28, 60, 300))
    if rng.random() < 0.5:
        life.host.order(codes.DISARM, codes.NOBODY)
        life.host.let_go()
        yield 600
        life.host.order(codes.ARM, codes.DRIVER)
        yield 220
    life.relay = FOLLOWS
    yield rng.choice((10, 600))


def reset(life: Life) -> Script:
    """The board resets; its files are kept or not; the host goes on with its press or not."""
    rng = life.rng
    if rng.random() < 0.7:
        yield from life.drive()
    if rng.random() < 0.5:
        life.host.let_go()
    life.boot(rng.choice((1, 1, 3, 5)))
    yield rng.randrange(20, 800)


def exception(life: Life) -> Script:
    """Something raises in the tick."""
    yield from life.drive()
    life.world.raises = life.rng.choice((ValueError("x"), OSError(5), MemoryError()))
    yield life.rng.choice((1, 50, 700))
    life.host.let_go()
    life.host.order(codes.ARM, codes.DRIVER)
    yield 220


def other_pace(life: Life) -> Script:
    """Ticks come slower than every millisecond, for a while or for good."""
    rng = life.rng
    if rng.random() < 0.2:  # a whole step
        life.period_us = rng.choice((1006, 1030, 1045))
        yield from life.drive(verb=rng.choice((codes.FORWARD, codes.BACKWARD)), mode=codes.STEP)
        yield 2_100
        life.period_us = 1000
        return
    if rng.random() < 0.3:
        life.period_us = rng.choice((1030, 1200, 2000, 10_000))
        yield from life.ready()
    yield from life.drive()
    life.period_us = rng.choice((1030, 1100, 1500, 2_000, 5_000, 10_000, 19_000))
    yield rng.choice((20, 100, 400))
    how = rng.randrange(4)
    if how == 0:
        life.host.alive = False
    elif how == 1:
        life.host.held.refreshed = False
    elif how == 2:
        life.host.view = None
    else:
        life.service_alive = False
    yield max(20, 700_000 // life.period_us)
    life.period_us = 1000
    life.host.alive = life.service_alive = True
    life.host.view = View()
    yield rng.randrange(20, 700)


def flaky_pot(life: Life) -> Script:
    """Two writes of three fail, never three in a row, for more than a second."""
    rng = life.rng
    yield from life.drive(mode=codes.CONTINUOUS)
    pot = life.world.pot
    for _ in range(rng.choice((100, 360))):
        pot.fault = NAK
        pot.fails_for = 2
        yield 3
    pot.fault = 0
    pot.fails_for = -1
    yield 50


def pushed(life: Life) -> Script:
    """Something turns the chair that is not its joystick."""
    rng = life.rng
    if rng.random() < 0.5:
        yield from life.drive(mode=codes.CONTINUOUS)
    life.chair.pushed_dps = rng.choice((-1, 1)) * rng.choice((5, 20, 40))
    if rng.random() < 0.5:
        life.host.let_go()
    yield rng.choice((100, 600, 4_000))
    life.chair.pushed_dps = 0
    yield rng.randrange(10, 100)


def spoilt_files(life: Life) -> Script:
    """A stored file is gone, erased or full of anything when the board comes up."""
    rng = life.rng
    if rng.random() < 0.5:
        yield from life.drive()
        if rng.random() < 0.5:
            life.host.order(codes.EMERGENCY_STOP, codes.DRIVER)
            yield rng.randrange(1, 60)
            life.host.forget_order()
    life.spoil_file(rng.choice(FILES), rng.choice((None, b"\xff" * 300, rng.randbytes(200), b"")))
    life.boot(rng.choice((1, 3, 5)))
    yield rng.randrange(20, 300)
    yield from life.ready()
    for name in NEUTRAL:
        yield from life.setting(codes.SETTING_SET_NEUTRAL, NAMES.index(name), 170)
    yield from life.setting(codes.SETTING_SAVE)


def full_flash(life: Life) -> Script:
    """The flash takes nothing while an emergency or a setting has to be stored."""
    rng = life.rng
    yield from life.drive()
    life.world.files.full = True
    if rng.random() < 0.7:
        life.host.order(codes.EMERGENCY_STOP, codes.DRIVER)
        yield rng.randrange(3, 60)
        life.host.forget_order()
        if rng.random() < 0.6:
            life.boot(rng.choice((1, 5)))
            life.world.files.full = rng.random() < 0.5
            yield from life.ready()
    else:
        life.host.let_go()
        life.host.order(codes.DISARM, codes.DRIVER)
        yield 30
        life.host.forget_order()
        yield from life.setting(codes.SETTING_SAVE)
    yield rng.randrange(1, 200)
    life.world.files.full = False
    yield rng.choice((100, 700))


def settings(life: Life) -> Script:
    """Settings change, mostly at rest; some are saved, some neutrals are moved."""
    rng = life.rng
    life.host.let_go()
    if rng.random() < 0.8:
        life.host.order(codes.DISARM, codes.DRIVER)
        yield 30
        life.host.forget_order()
    else:
        yield from life.drive()
    for _ in range(rng.randrange(1, 4)):
        name = rng.choice(_TRIED)
        _, default, low, high = TABLE[NAMES.index(name)]
        value = rng.choice((default, low, high, rng.randrange(low, high + 1), high + 1))
        request = codes.SETTING_SET
        if name.startswith("neutral") and rng.random() < 0.8:
            request = codes.SETTING_SET_NEUTRAL
        yield from life.setting(request, NAMES.index(name), value)
    if rng.random() < 0.5:
        for name in NEUTRAL:
            value = rng.randrange(150, 191)
            yield from life.setting(codes.SETTING_SET_NEUTRAL, NAMES.index(name), value)
    if rng.random() < 0.7:
        yield from life.setting(codes.SETTING_SAVE)
    elif rng.random() < 0.5:
        yield from life.setting(codes.SETTING_DEFAULTS)
    if rng.random() < 0.3:
        life.boot(1)
    yield from life.ready()
    yield from life.drive()
    yield rng.randrange(10, 300)
