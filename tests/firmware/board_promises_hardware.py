# Promises P8 to P11 on the whole firmware in lockstep virtual time: wipers, loops, emergency.

from gazeboard.boards import bank_layout as at
from gazeboard.boards import pins
from gazeboard.core import limits
from gazelink import codes, messages
from gazesim.board_rig import NEUTRAL, POT, REGS, Rig
from promiserig import ENABLE_AT, armed, fault, stays_still_until_pressed_anew, toggles
from promises import CORE, kept, measured


def pot_nak(rig):
    rig.bank[POT + at.SLOT_NAK] = 1


def pot_bus(rig):
    rig.bank[at.BUSES_AT] = 1


def pot_misreads(rig):
    # Both wipers in the middle, whatever is written: registers that take nothing.
    rig.bank[POT + at.SLOT_STYLE] = at.STYLE_REGISTERS
    for k in range(256):
        rig.bank[POT + REGS + k] = 0x80
    for k in range(32):
        rig.bank[POT + at.SLOT_RO + k] = 0xFF


def test_p8_a_failing_wiper_write_ends_the_enable_line_within_4_ms_and_latches():
    for spoil, cause in (
        (pot_nak, "potentiometer answers nothing"),
        (pot_bus, "potentiometer's bus stuck"),
        (pot_misreads, "potentiometer reads back wrong"),
    ):
        rig = Rig()
        rig.drive()
        spoil(rig)
        ms = rig.until(lambda: fault(rig, codes.WIPER), 10)
        measured(CORE, "P8", cause + ": enable off", ms, 4)
        assert toggles(rig, 50) == 0
        assert not armed(rig)
        rig.bank[POT + at.SLOT_NAK] = 0
        rig.bank[at.BUSES_AT] = 0
        rig.bank[POT + at.SLOT_STYLE] = at.STYLE_AD5282
        rig.release()
        rig.run(2000)
        assert fault(rig, codes.WIPER)  # latched
        rig.give(codes.ARM)
        rig.run(300)
        assert not armed(rig)
        assert rig.state["arm_reason"] == codes.FAULT_REASON + codes.WIPER
        rig.give(codes.RESET_FAULTS, codes.CARETAKER)
        rig.run(100)
        rig.arm()


def test_p8_two_failures_in_a_row_are_retried():
    rig = Rig()
    rig.drive()
    for _ in range(50):
        rig.bank[POT + at.SLOT_NAK_COUNT] = 2  # two ticks, one transfer each
        rig.run(5)
    assert armed(rig)
    assert not rig.neutral()


def test_p9_a_stalled_service_loop_is_neutral_within_50_ms_and_disarmed_after_500():
    rig = Rig()
    rig.drive()
    rig.service_alive = False
    ms = rig.until(rig.neutral, 100)
    measured(CORE, "P9", "service loop blocked", ms, limits.SERVICE_STALLED_MS)
    ms += rig.until(lambda: not armed(rig), limits.SERVICE_LOST_MS)
    measured(CORE, "P9", "service loop blocked: disarmed", ms, limits.SERVICE_LOST_MS)
    rig.service_alive = True
    stays_still_until_pressed_anew(rig)


def test_p10_a_stalled_tick_stops_the_enable_line_and_disarms_when_it_returns():
    rig = Rig()
    rig.drive()
    level = rig.bank[ENABLE_AT + at.PIN_OUT]
    rig.clock.now_us += 25000
    assert rig.bank[ENABLE_AT + at.PIN_OUT] == level
    rig.one_ms()
    assert not armed(rig)
    assert fault(rig, codes.TICK_STALLED)
    assert rig.neutral()
    kept(CORE, "P10", "tick stalls: disarmed when it goes on")
    rig.release()
    rig.run(1000)
    stays_still_until_pressed_anew(rig)


def test_p10_an_exception_in_the_tick_turns_the_enable_line_off_and_latches():
    rig = Rig()
    rig.drive()
    step = rig.app.motion.step

    def broken(i, blocked):
        raise ValueError("spoilt")

    rig.app.motion.step = broken
    rig.one_ms()
    assert rig.bank[ENABLE_AT + at.PIN_OUT] == 0
    assert fault(rig, codes.TICK_EXCEPTION)
    measured(CORE, "P10", "exception inside the tick: enable off", 1, 1)
    rig.app.motion.step = step
    assert toggles(rig, 300) == 0
    assert rig.neutral()
    rig.release()
    rig.run(1500)
    assert fault(rig, codes.TICK_EXCEPTION)


# Where an exception can come from in a tick, and in what is done about it.
IN_THE_TICK = (
    ("obstacles", "step"),
    ("safety", "step"),
    ("safety", "wipers_written"),
    ("safety", "tick_raised"),
    ("motion", "step"),
    ("motion", "stop"),
    ("motion", "_halt"),
    ("joystick", "write"),
    ("profile_check", "step"),
    ("telemetry", "capture"),
    ("board", "relay_pin"),
    ("board", "ticks_us"),
    ("board", "ticks_diff"),
)


def test_p1_an_exception_that_repeats_makes_neutral_in_its_own_tick_and_every_other():
    for errors in (ValueError, MemoryError, OSError):
        for part, name in IN_THE_TICK:
            rig = Rig()
            rig.drive()
            owner = rig.app._board if part == "board" else getattr(rig.app, part)

            def broken(*_args):
                raise errors("spoilt")

            setattr(owner, name, broken)
            if name in ("tick_raised", "stop", "_halt"):
                rig.app.obstacles.step = broken  # they only come after another
            rig.board.tick(rig.app)
            assert rig.neutral(), (part, name)
            for _ in range(700):
                rig.bank[POT + REGS] = 220  # as if it had been left there
                rig.bank[POT + REGS + 1] = 80
                rig.board.tick(rig.app)
                assert rig.neutral(), (part, name)
                assert rig.bank[ENABLE_AT + at.PIN_OUT] == 0
    measured(CORE, "P1", "exception inside the tick: neutral", 1, 1)


def test_p10_an_exception_that_passes_at_rest_leaves_a_board_that_arms_again():
    rig = Rig()
    rig.arm()
    step = rig.app.obstacles.step

    def broken(*_args):
        raise ValueError("spoilt")

    rig.app.obstacles.step = broken
    rig.one_ms()
    rig.app.obstacles.step = step
    rig.run(200)
    assert fault(rig, codes.TICK_EXCEPTION)
    rig.give(codes.RESET_FAULTS, codes.CARETAKER)
    rig.run(100)
    rig.arm()


def test_p1_an_exception_makes_neutral_on_a_channel_whose_other_one_fails():
    rig = Rig()
    rig.drive()
    write = rig.app._board.joystick_i2c.writeto

    def first_fails(address, data):
        if data[0] == 0:
            raise OSError(19)
        write(address, data)

    rig.app._board.joystick_i2c.writeto = first_fails

    def broken(*_args):
        raise ValueError("spoilt")

    rig.app.obstacles.step = broken
    rig.bank[POT + REGS + 1] = 80
    rig.board.tick(rig.app)
    assert rig.bank[POT + REGS + 1] == NEUTRAL


def test_p10_the_watchdog_is_fed_only_while_the_tick_lives():
    rig = Rig()
    rig.run(100)
    feeds = rig.bank[at.WDT_FEEDS_AT]
    for _ in range(200):
        rig.app.service()
    assert rig.bank[at.WDT_FEEDS_AT] - feeds <= 1


def open_input(rig):
    rig.drive_pin(pins.EMERGENCY, 1)


def broken_wire(rig):
    rig.bank[at.PINS_AT + pins.EMERGENCY * at.PIN_SIZE + at.PIN_HOST_DRIVE] = 0


def message(rig):
    rig.send(messages.ORDER, (codes.EMERGENCY_STOP, 200, codes.NOBODY))


def test_p11_emergency_input_or_message_turns_enable_off_within_2_ms_and_latches_across_resets():
    for cause in (open_input, broken_wire, message):
        rig = Rig()
        rig.drive()
        cause(rig)
        ms = rig.until(lambda: fault(rig, codes.EMERGENCY), 10)
        name = "emergency message" if cause is message else "emergency input"
        measured(CORE, "P11", name + ": enable off", ms, 2)
        assert rig.neutral()
        assert toggles(rig, 30) == 0
        rig.drive_pin(pins.EMERGENCY, 0)
        rig.release()
        rig.run(50)
        rig.boot()
        rig.run(1500)
        assert fault(rig, codes.EMERGENCY)
        assert rig.state["first_fault"] == codes.FAULT_REASON + codes.EMERGENCY
        rig.give(codes.ARM)
        rig.run(300)
        assert not armed(rig)
        rig.give(codes.RESET_FAULTS, codes.DRIVER)
        rig.run(200)
        assert fault(rig, codes.EMERGENCY)  # the driver's page can't
        rig.give(codes.RESET_FAULTS, codes.CARETAKER)
        rig.run(200)
        assert not fault(rig, codes.EMERGENCY)
        rig.boot()
        rig.arm()


def test_p11_three_seconds_at_the_chairs_button_reset_it():
    rig = Rig()
    rig.drive()
    open_input(rig)
    rig.run(10)
    rig.release()
    rig.drive_pin(pins.BUTTON, 0)
    rig.run(3100)
    assert fault(rig, codes.EMERGENCY)  # the input is still open
    rig.drive_pin(pins.BUTTON, 1)
    rig.drive_pin(pins.EMERGENCY, 0)
    rig.run(50)
    rig.drive_pin(pins.BUTTON, 0)
    rig.run(2900)
    assert fault(rig, codes.EMERGENCY)
    rig.run(200)
    assert not fault(rig, codes.EMERGENCY)
    rig.arm()
    kept(CORE, "P11", "3 s at the chair's button reset it")
