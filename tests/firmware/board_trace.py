# The trace of the board: off unless asked for, whole or said to be lost, and it costs no memory.
# What it says is compared with the core itself in tests/tools/test_replay_board.py.

from boardtest import no_allocation
from gazeboard.boards import pins
from gazeboard.core.shared import Inputs
from gazeboard.io import core_state, trace
from gazelink import arcs, codes, messages
from gazesim.board_rig import Rig

DATA = messages.TRACE.offsets["data"]


class Traced(Rig):
    # A rig that keeps what a trace's frames say.

    def __init__(self):
        self.frames = []
        Rig.__init__(self)

    def received(self, kind, buf):
        if kind == messages.TRACE.type_id:
            told = messages.TRACE.unpack(buf)
            self.frames.append((told["part"], told["begins"], bytes(told["data"])))
        Rig.received(self, kind, buf)

    def ask(self, on=1):
        self.send(messages.TRACE_REQUEST, (on,))

    # (tick, whether anything before is lost) of each snapshot.
    def snapshots(self):
        found = []
        for _, begins, data in self.frames:
            if begins != trace.NO_BEGIN and begins + 6 <= len(data):
                assert data[begins] == trace.SNAPSHOT
                low, high = data[begins + 1 : begins + 3], data[begins + 3 : begins + 5]
                tick = int.from_bytes(low + high, "little")
                found.append((tick, data[begins + 5]))
        return found

    def parts_in_order(self):
        first = self.frames[0][0]
        return all(self.frames[k][0] == (first + k) & 0xFFFF for k in range(len(self.frames)))


def test_nothing_is_sent_unless_asked_for():
    rig = Traced()
    rig.drive()
    assert rig.frames == []
    assert rig.app.trace.on == trace.OFF
    rig.ask(2)
    rig.run(100)
    assert rig.frames == []


def test_it_begins_with_a_snapshot_and_goes_on_without_a_gap():
    rig = Traced()
    rig.drive()
    asked_at = rig.app.outbox.ticks
    rig.ask()
    rig.run(1000)
    ((tick, lost),) = rig.snapshots()
    assert asked_at <= tick <= asked_at + 30
    assert lost == 1
    assert rig.frames[0][1] == 0
    assert 20 < len(rig.frames) < 120
    assert rig.parts_in_order()


def test_asked_again_it_gives_another_snapshot_and_loses_nothing():
    rig = Traced()
    rig.arm()
    for _ in range(3):
        rig.ask()
        rig.run(550)
    assert [lost for _, lost in rig.snapshots()] == [1, 0, 0]
    assert rig.parts_in_order()


def test_it_ends_when_asked_to_and_with_the_session():
    rig = Traced()
    rig.arm()
    rig.ask()
    rig.run(200)
    rig.ask(0)
    rig.run(50)
    count = len(rig.frames)
    assert count
    rig.run(300)
    assert len(rig.frames) == count
    rig.ask()
    rig.run(200)
    assert len(rig.frames) > count
    rig.renew(0x4321)
    rig.run(100)
    assert rig.app.trace.on == trace.OFF


def test_what_does_not_fit_is_lost_and_a_snapshot_follows():
    rig = Traced()
    rig.arm()
    rig.ask()
    rig.run(300)
    rig.wire.reading = False
    tracing = rig.app.trace
    tracing._head = (tracing._tail + len(tracing._bytes) - 450) & 0x3FFFFFFF
    rig.run(60)
    assert tracing._lost
    rig.wire.reading = True
    rig.run(500)
    assert [lost for _, lost in rig.snapshots()] == [1, 1]
    assert rig.parts_in_order()  # what did not fit was never begun


def test_more_events_than_fit_are_lost_and_said_to_be():
    rig = Traced()
    rig.arm()
    rig.ask()
    rig.run(300)
    rig.service_alive = False
    for k in range(70):
        rig.drive_pin(pins.BUTTON, k & 1)
        rig.run(1)
    rig.service_alive = True
    rig.run(300)
    assert [lost for _, lost in rig.snapshots()] == [1, 1]


def test_an_exception_in_the_tick_is_a_loss():
    rig = Traced()
    rig.arm()
    rig.ask()
    rig.run(200)
    step = rig.app.obstacles.step
    rig.app.obstacles.step = None
    rig.run(1)
    rig.app.obstacles.step = step
    rig.run(200)
    assert rig.app.safety.faults & (1 << codes.TICK_EXCEPTION)
    assert [lost for _, lost in rig.snapshots()] == [1, 1]


def test_changed_settings_are_a_loss():
    rig = Traced()
    rig.run(300)
    rig.ask()
    rig.run(200)
    rig.send(messages.SETTING, (codes.SETTING_DEFAULTS, 0, 0))
    rig.run(200)
    assert [lost for _, lost in rig.snapshots()] == [1, 1]


def test_no_tick_and_no_service_pass_allocates():
    rig = Traced()
    rig.arm()
    app = rig.app

    def board_only():
        app._gc_at = app.outbox.ticks
        rig.board.tick(app)
        for _ in range(3):
            app.service()

    rig.ask()
    for verb in (codes.FORWARD, codes.LEFT, codes.DRIVE):
        rig.press(verb, codes.CONTINUOUS, 300, -200)
        for k in range(200):
            rig.world_ms()
            if k % 60 == 0:
                rig.ask()
            no_allocation(board_only, 1)
            rig.listen()
        assert not rig.neutral()
        rig.release()
        rig.run(50)
    rig.service_alive = False
    rig.run(60)
    no_allocation(board_only, 1)
    assert len(rig.snapshots()) >= 6


def test_the_inputs_as_words_are_all_of_them():
    i = Inputs()
    k = 0
    for name in trace.FIELDS:
        k += 1
        setattr(i, name, k)
    for at in range(arcs.SIZE):
        i.clearance_arcs[at] = 200 + at
    words = core_state.array("i", [0] * trace.WORDS)
    i.as_words(words)
    assert list(words) == list(range(1, k + 1)) + list(range(200, 200 + arcs.SIZE))
    assert len(trace.FIELDS) == len(Inputs.FIELDS) - 1


def test_the_state_is_what_the_core_has():
    rig = Rig()
    rig.drive()
    rig.run(200)
    state = rig.app.trace._state
    state.take()
    at = len(core_state.NAMES)
    assert list(state.words[:at]) == [rig.app.settings.get(k) for k in range(at)]
    for part, name in state.numbers:
        assert state.words[at] == getattr(part, name), name
        at += 1
    for numbers in state.lists + state.arrays:
        assert list(state.words[at : at + len(numbers)]) == list(numbers)
        at += len(numbers)
    assert at == len(state.words)


def test_no_part_gets_another_number_later():
    # Found once at the start: what a drive adds would be missing.
    rig = Rig()
    before = rig.app.trace._state
    rig.drive(codes.LEFT)
    rig.run(500)
    after = core_state.CoreState(rig.app.core, rig.app.joystick, rig.app.settings)
    assert [name for _, name in after.numbers] == [name for _, name in before.numbers]
    assert len(after.words) == len(before.words)
