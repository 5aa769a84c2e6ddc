"""`gazechair bench` over the simulator's device models: finds, reads, sweeps, always neutral."""

import json
import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from gazeboard.boards.bank_devices import BankI2C
from gazechair import cli
from gazechair.service.bench import BenchError, imu, pot
from gazechair.service.bench import bus as bench_bus
from gazechair.service.bench.bench import Bench
from gazesim.bank import Bank
from gazesim.bno055 import Bno055
from gazesim.pot import Pot

adafruit_bno055 = pytest.importorskip(
    "adafruit_bno055", reason="needs the extra bench: pip install gazechair[bench]"
)


class SimulatedBus:
    """Both devices on one bus, as wired on a bench; time passes only in sleep."""

    def __init__(self) -> None:
        bank = Bank.in_memory()
        self.pot = Pot(bank)
        self.imu = Bno055(bank)
        self.turning_deg_s = 0.0
        self.written: list[tuple[int, int]] = []  # instruction, count
        self.fails_after: int | None = None
        self._buses = {0x2C: BankI2C(bank.buffer, 0), 0x28: BankI2C(bank.buffer, 1)}
        self.bank = bank

    def sleep(self, duration_s: float) -> None:
        for _ in range(round(duration_s * 1000) + 1):
            self.imu.step(0.001, self.turning_deg_s)

    def _at(self, address: int) -> Any:
        if address not in self._buses:
            raise OSError(121, "Remote I/O error")
        return self._buses[address]

    def write(self, address: int, data: bytes) -> None:
        if address == 0x2C and len(data) == 2:
            self.written.append((data[0], data[1]))
            if self.fails_after is not None and len(self.written) == self.fails_after:
                raise OSError(121, "Remote I/O error")
        self._at(address).writeto(address, data)
        self.sleep(0.0)

    def read(self, address: int, count: int) -> bytes:
        data = bytearray(count)
        self._at(address).readfrom_into(address, data)
        return bytes(data)

    def write_read(self, address: int, data: bytes, count: int) -> bytes:
        self.write(address, data)
        return self.read(address, count)

    def close(self) -> None:
        pass


@pytest.fixture
def bus(monkeypatch: pytest.MonkeyPatch) -> SimulatedBus:
    simulated = SimulatedBus()
    clock = SimpleNamespace(sleep=simulated.sleep, monotonic=time.monotonic)
    monkeypatch.setattr(adafruit_bno055, "time", clock)
    monkeypatch.setattr(imu, "time", clock)
    return simulated


class User:
    """Reads every line, gives one answer, then only presses Enter."""

    def __init__(self, answer: str = "") -> None:
        self.lines: list[str] = []
        self.asked: list[str] = []
        self._answer = answer

    def say(self, line: str) -> None:
        self.lines.append(line)

    def ask(self, question: str) -> str:
        assert "DB9" in question
        self.asked.append(question)
        return self._answer if len(self.asked) == 1 else ""

    @property
    def read(self) -> str:
        return "\n".join(self.lines)


def run(bus: SimulatedBus, user: User, unplugged: bool = False) -> tuple[bool, dict[str, Any]]:
    bench = Bench(bus, user.say, user.ask)
    good = bench.run(unplugged)
    return good, json.loads(bench.as_json())


def test_finds_both_and_reads_the_wipers_back(bus: SimulatedBus) -> None:
    user = User()
    good, findings = run(bus, user)
    assert good
    assert findings["pot"]["address"] == 0x2C
    assert findings["pot"]["wipers"] == [128, 128], "midscale, as after power-on"
    assert findings["imu"]["address"] == 0x28


@pytest.mark.parametrize("answer", ["", "no", "yes", "y", "plugged"])
def test_writes_nothing_unless_the_user_says_unplugged(bus: SimulatedBus, answer: str) -> None:
    user = User(answer)
    good, findings = run(bus, user)
    assert good
    assert not bus.written
    assert findings["pot"]["sweep"] is None
    assert "sweep left out" in user.read


class Meter(User):
    """Notes both wipers whenever something is asked."""

    def __init__(self, bus: SimulatedBus) -> None:
        super().__init__("unplugged")
        self.shown: list[tuple[int, int]] = []
        self._bus = bus

    def ask(self, question: str) -> str:
        self.shown.append(self._bus.pot.poll())
        return super().ask(question)


def test_each_voltage_stays_until_the_user_has_measured_it(bus: SimulatedBus) -> None:
    meter = Meter(bus)
    good, _ = run(bus, meter)
    assert good
    assert meter.shown[1:] == [(85, 170), (170, 170), (254, 170), (170, 85), (170, 170), (170, 254)]
    assert bus.pot.poll() == (pot.NEUTRAL, pot.NEUTRAL)
    for question, volts, pin in zip(meter.asked[1:], "567567", "111222", strict=True):
        assert f"must show {volts} V" in question
        assert f"pin {pin} against" in question


class Interrupts(Meter):
    """Ends it at the nth measurement."""

    def __init__(self, bus: SimulatedBus, at: int, how: BaseException) -> None:
        super().__init__(bus)
        self._at, self._how = at, how

    def ask(self, question: str) -> str:
        answer = super().ask(question)
        if len(self.asked) == 1 + self._at:
            raise self._how
        return answer


@pytest.mark.parametrize("how", [KeyboardInterrupt(), EOFError()])
@pytest.mark.parametrize("at", [1, 3, 6])
def test_back_to_neutral_when_the_user_ends_it_at_a_measurement(
    bus: SimulatedBus, at: int, how: BaseException
) -> None:
    user = Interrupts(bus, at, how)
    with pytest.raises(type(how)):
        run(bus, user)
    assert user.shown[-1] != (pot.NEUTRAL, pot.NEUTRAL)
    assert bus.pot.poll() == (pot.NEUTRAL, pot.NEUTRAL)
    assert "back to neutral" in user.read


def test_ctrl_c_in_a_terminal_is_one_line(
    bus: SimulatedBus, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    user = Interrupts(bus, 1, KeyboardInterrupt())
    monkeypatch.setattr(bench_bus, "LinuxBus", lambda number: bus)
    monkeypatch.setattr("builtins.input", user.ask)
    monkeypatch.setattr("sys.stdin", SimpleNamespace(isatty=lambda: True))
    assert cli.main(["bench", "--bus", "7"]) == 2
    printed = capsys.readouterr()
    assert printed.err == "gazechair: stopped\n"
    assert "back to neutral" in printed.out


def test_a_firmware_that_writes_meanwhile_is_noticed(bus: SimulatedBus) -> None:
    user = User("unplugged")

    def ask(question: str) -> str:
        if user.asked:
            bus.write(0x2C, bytes((0x00, pot.NEUTRAL)))
        return User.ask(user, question)

    bench = Bench(bus, user.say, ask)
    with pytest.raises(BenchError, match="something else moved the wiper linear from 85"):
        bench.run(False)


@pytest.mark.parametrize("scripted", [True, False])
def test_sweeps_both_over_the_whole_range_and_back_to_neutral(
    bus: SimulatedBus, scripted: bool
) -> None:
    user = User("Unplugged ")
    good, findings = run(bus, user, unplugged=scripted)
    assert good
    assert len(user.asked) == (0 if scripted else 7)
    for instruction in (0x00, 0x80):
        counts = [count for at, count in bus.written if at == instruction]
        assert (min(counts), max(counts), counts[-1]) == (pot.LOWEST, pot.HIGHEST, pot.NEUTRAL)
    assert bus.pot.poll() == (pot.NEUTRAL, pot.NEUTRAL)
    assert findings["pot"]["neutral"]
    assert [each["wrong"] for each in findings["pot"]["sweep"]] == [[], []]
    assert ("measure it now" in user.read) == scripted


@pytest.mark.parametrize("fails_after", [1, 5, 20, 30])
def test_back_to_neutral_when_a_transfer_fails(bus: SimulatedBus, fails_after: int) -> None:
    bus.fails_after = fails_after
    user = User()
    with pytest.raises(BenchError, match="AD5282 at 0x2c stopped answering"):
        run(bus, user, unplugged=True)
    assert bus.pot.poll() == (pot.NEUTRAL, pot.NEUTRAL)
    assert "back to neutral" in user.read


def test_back_to_neutral_when_the_user_presses_ctrl_c(
    bus: SimulatedBus, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(read: Callable[[int, int], bytes]) -> Callable[[int, int], bytes]:
        def wrapped(address: int, count: int) -> bytes:
            if len(bus.written) == 7:
                bus.written.append((0, 0))
                raise KeyboardInterrupt
            return read(address, count)

        return wrapped

    monkeypatch.setattr(bus, "read", interrupted(bus.read))
    with pytest.raises(KeyboardInterrupt):
        run(bus, User(), unplugged=True)
    assert bus.pot.poll() == (pot.NEUTRAL, pot.NEUTRAL)


def test_says_when_it_cannot_go_back_to_neutral(bus: SimulatedBus) -> None:
    bus.pot.set_stuck(True)
    user = User()
    good, findings = run(bus, user, unplugged=True)
    assert not good
    assert not findings["pot"]["neutral"]
    assert findings["pot"]["sweep"][0]["wrong"]
    assert "keep the DB9 unplugged" in user.read


def test_nothing_found_is_said_for_each(bus: SimulatedBus) -> None:
    bus.pot.set_nak(True)
    bus.imu.set_nak(True)
    user = User()
    good, findings = run(bus, user)
    assert not good
    assert findings == {"pot": None, "imu": None, "ok": False}
    assert "AD5282: nothing answers" in user.read
    assert "BNO055: nothing answers" in user.read


def test_heading_and_gyro_count_to_the_left(bus: SimulatedBus) -> None:
    bus.turning_deg_s = 20.0
    _, findings = run(bus, User())
    assert findings["imu"]["gyro_z_deg_s"] == pytest.approx(20.0, abs=1.0)
    assert 0.0 < findings["imu"]["heading_deg"] < 30.0


def test_another_device_at_its_address_is_no_bno055(bus: SimulatedBus) -> None:
    slot = bus.bank.slot(1, 0x28)
    slot.write(0, b"\x55")
    bus.imu.step = lambda *_: None
    with pytest.raises(BenchError, match="what answers at 0x28 is no BNO055"):
        run(bus, User())
