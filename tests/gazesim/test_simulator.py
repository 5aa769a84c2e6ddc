"""The simulator as a process: ready line, control socket, the board on MicroPython, a clean end."""

import json
import os
import select
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

import gazesetup
from gazeboard.boards.bank_devices import BankI2C
from gazelink import frame, messages
from gazesim import __main__ as gazesim_command
from gazesim.bank import Bank
from gazesim.simulator import RIG_FAULTS, Simulator
from gazesim.world import World
from patience import wait_until

GENEROUS_S = 60.0


def start(folder, *arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "gazesim", "--dir", str(folder), *arguments],
        env=gazesetup.source_environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


class Running:
    """A simulator that is ready, and a connection to its control socket."""

    def __init__(self, folder, *arguments):
        self.process = start(folder, *arguments)
        if not select.select([self.process.stdout], [], [], GENEROUS_S)[0]:
            self.process.kill()
            pytest.fail(f"the simulator is not ready after {GENEROUS_S:g} s")
        line = self.process.stdout.readline()
        assert line, self.process.stderr.read()
        self.ready = json.loads(line)
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.settimeout(GENEROUS_S)
        self._socket.connect(self.ready["control"])
        self._lines = self._socket.makefile("rwb")

    def raw(self, line):
        self._lines.write(line + b"\n")
        self._lines.flush()
        return json.loads(self._lines.readline())

    def do(self, what, **arguments):
        return self.raw(json.dumps({"do": what, **arguments}).encode())

    def hang_up(self):
        self._lines.close()
        self._socket.close()

    def end(self):
        self.hang_up()
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(timeout=GENEROUS_S)
        self.process.stdout.close()
        self.process.stderr.close()
        return code


@pytest.fixture(scope="module")
def simulator(tmp_path_factory, micropython):
    running = Running(
        tmp_path_factory.mktemp("sim"), "--room", "wall", "--micropython", str(micropython.path)
    )
    yield running
    assert running.end() == 0
    for port in ("board", "lidar"):
        assert not os.path.lexists(running.ready[port])


def board_says_hello(path):
    """Whether a good HELLO of a board comes out of the port within a while."""
    decoder = frame.Decoder()
    fd = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)

    def hello():
        try:
            data = os.read(fd, 4096)
        except BlockingIOError:
            return False
        return any(decoder.feed(byte) and decoder.buf[0] == messages.HELLO.type_id for byte in data)

    try:
        return wait_until(hello, "HELLO")
    finally:
        os.close(fd)


def test_ready_says_where_everything_is(simulator):
    assert simulator.ready["ready"] is True
    for key in ("board", "lidar", "control"):
        assert os.path.exists(simulator.ready[key])
    assert simulator.ready["camera"].startswith("http://127.0.0.1:")


def test_the_board_runs_and_its_wipers_are_neutral(simulator):
    truth = simulator.do("truth")
    assert truth["room"] == "wall"
    assert truth["wipers"] == [170, 170]
    assert truth["relay_closed"] is False
    assert wait_until(lambda: simulator.do("truth")["tick_ms"] > truth["tick_ms"], "a tick")
    assert board_says_hello(simulator.ready["board"])


def test_the_wiper_log_tells_every_change_with_its_time(simulator):
    log = simulator.do("wiper_log", since=0)
    number, at_s, linear, turn = log["entries"][-1]
    assert (linear, turn) == (170, 170)
    assert at_s <= time.monotonic()
    assert log["last"] == number
    assert simulator.do("wiper_log", since=number)["entries"] == []


def test_the_cable_pulled_and_plugged(simulator):
    port = simulator.ready["board"]
    assert simulator.do("pull_cable") == {"ok": True}
    assert not os.path.lexists(port)
    assert "cable_pulled" in simulator.do("truth")["faults"]
    assert simulator.do("plug_cable") == {"ok": True}
    assert board_says_hello(port)


def test_a_board_reset_boots_again_and_its_port_comes_back(simulator):
    boots = simulator.do("truth")["boot_count"]
    assert simulator.do("inject", fault="board_reset") == {"ok": True}
    wait_until(lambda: simulator.do("truth")["boot_count"] == boots + 1, "a boot")
    assert board_says_hello(simulator.ready["board"])


def test_a_board_without_power_and_with_it_again(simulator):
    boots = simulator.do("truth")["boot_count"]
    simulator.do("inject", fault="board_off")
    assert not os.path.lexists(simulator.ready["board"])
    simulator.do("clear", fault="board_off")
    wait_until(lambda: simulator.do("truth")["boot_count"] == boots + 1, "a boot")
    assert board_says_hello(simulator.ready["board"])


def test_a_board_without_power_does_not_reset(simulator):
    boots = simulator.do("truth")["boot_count"]
    simulator.do("inject", fault="board_off")
    simulator.do("inject", fault="board_reset")
    assert not os.path.lexists(simulator.ready["board"])
    assert simulator.do("truth")["boot_count"] == boots
    simulator.do("clear", fault="board_off")
    wait_until(lambda: simulator.do("truth")["boot_count"] == boots + 1, "a boot")


def test_a_board_that_starts_finds_its_devices_cold():
    """The potentiometer and the heading sensor hang on its 3.3 V."""
    world = World(Bank.in_memory())
    found = []

    def power_cycle():
        bus = BankI2C(world.bank.buffer, 1)
        with pytest.raises(OSError, match="19"):
            bus.readfrom_mem_into(0x28, 0x00, bytearray(1))
        found.append(world.pot.poll())

    simulator = SimpleNamespace(world=world)
    simulator.board = SimpleNamespace(kill=lambda: None, power_cycle=power_cycle)
    simulator.switch_off = lambda: Simulator.switch_off(simulator)
    simulator.switch_on = lambda: Simulator.switch_on(simulator)
    world.faults.add(simulator, RIG_FAULTS)
    world.bank.slot(0, 0x2C).write(0, bytes((170, 170)))  # the board was running
    world.faults.inject("board_off")
    world.faults.clear("board_off")
    assert found == [(0x80, 0x80)]


def test_a_hanging_board_stands_still_and_goes_on(simulator):
    simulator.do("inject", fault="board_hang")
    time.sleep(0.1)
    stood = simulator.do("truth")["tick_ms"]
    time.sleep(0.1)
    assert simulator.do("truth")["tick_ms"] == stood
    simulator.do("clear", fault="board_hang")
    wait_until(lambda: simulator.do("truth")["tick_ms"] > stood, "a tick")


def test_the_lidar_unplugged_and_plugged(simulator):
    simulator.do("inject", fault="lidar_unplugged")
    assert not os.path.lexists(simulator.ready["lidar"])
    simulator.do("clear", fault="lidar_unplugged")
    assert os.path.exists(simulator.ready["lidar"])


def test_teleport_and_profile(simulator):
    assert simulator.do("teleport", x_m=1.0, y_m=0.5, heading_deg=90.0) == {"ok": True}
    assert simulator.do("profile", name="5.1") == {"ok": True}
    truth = simulator.do("truth")
    assert (truth["x_m"], truth["y_m"], truth["heading_deg"]) == (1.0, 0.5, 90.0)
    assert truth["profile"] == "5.1"


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        (b"{", "Expecting"),
        (b"[]", "a request is a JSON object"),
        (b"\xff\xff\xff", "decode"),
        (b"{}", "can't do None; can do truth"),
        (b'{"do": ["truth"]}', "can't do"),
        (b'{"do": "inject"}', "inject needs 'fault', a name"),
        (b'{"do": "inject", "fault": "flood"}', "no fault 'flood'"),
        (b'{"do": "inject", "fault": "tilt", "roll_deg": [1]}', "roll_deg is not a number"),
        (b'{"do": "teleport", "x_m": 1}', "teleport needs 'y_m', a number"),
        (b'{"do": "teleport", "x_m": 1e400, "y_m": 0, "heading_deg": 0}', "x_m is not within"),
        (b'{"do": "wiper_log", "since": NaN}', "since"),
        (b'{"do": "wiper_log", "since": 1%s}' % (b"0" * 400), "since is not within"),
        (b'{"do": "inject", "fault": "obstacle", "size_m": 0}', "size_m is not within 0.05..2.0"),
        (b'{"do": "inject", "fault": "cable_damage", "drop": 2}', "drop is not within"),
        (b"[" * 4000, ""),  # which limit ends it depends on the Python
        (b'{"do": "profile", "name": "9"}', "no profile '9'"),
    ],
)
def test_a_bad_request_is_refused_with_the_reason(simulator, line, reason):
    error = simulator.raw(line)["error"]
    assert error
    assert reason in error
    assert "time_s" in simulator.do("truth")  # and nothing died


def test_quit_ends_it_and_the_board_with_it(tmp_path):
    running = Running(tmp_path)  # the board on CPython
    assert running.do("quit") == {"ok": True}
    assert running.process.wait(timeout=GENEROUS_S) == 0
    running.hang_up()
    assert not os.path.lexists(running.ready["control"])
    assert running.process.stderr.read() == ""


def test_killed_it_takes_the_board_along(tmp_path):
    running = Running(tmp_path)
    children = Path(f"/proc/{running.process.pid}/task/{running.process.pid}/children")
    (board,) = map(int, children.read_text().split())
    running.process.kill()
    running.process.wait(timeout=GENEROUS_S)

    def gone():
        try:
            stat = Path(f"/proc/{board}/stat").read_text()
        except FileNotFoundError:
            return True
        return stat.rpartition(")")[2].split()[0] == "Z"

    wait_until(gone, "the board's end")
    running.hang_up()


def test_a_second_one_in_the_same_folder_is_refused(simulator):
    folder = Path(simulator.ready["board"]).parent
    process = start(folder)
    out, err = process.communicate(timeout=GENEROUS_S)
    assert process.returncode == 2
    assert out == ""
    assert "in use by another simulator" in err


def test_a_board_that_can_not_be_run_is_refused_in_one_line(tmp_path):
    process = start(tmp_path, "--micropython", str(tmp_path / "nowhere"))
    _, err = process.communicate(timeout=GENEROUS_S)
    assert process.returncode == 2
    assert err.count("\n") == 1
    assert "the board does not start" in err


def test_a_port_that_can_not_be_made_is_refused_in_one_line(tmp_path, monkeypatch, capsys):
    def exhausted():
        raise OSError("out of pty devices")

    monkeypatch.setattr(os, "openpty", exhausted)
    monkeypatch.setattr(sys, "argv", ["gazesim", "--dir", str(tmp_path)])
    switch_s = sys.getswitchinterval()
    handlers = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)}
    try:
        code = gazesim_command.main()
    finally:
        sys.setswitchinterval(switch_s)
        for number, handler in handlers.items():
            signal.signal(number, handler)
    assert code == 2
    _, err = capsys.readouterr()
    assert err.count("\n") == 1
    assert f"no pseudo-terminal for {tmp_path}" in err
