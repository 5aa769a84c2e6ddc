"""Cable and ports over real ptys; every wait is for a condition, with a generous time-out."""

import errno
import os
import socket
import time
import tty

import pytest
import serial

from gazesim.cable import Cable
from gazesim.pty_port import PtyPort
from patience import wait_until

GENEROUS_S = 20.0


def open_raw(path):
    fd = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    tty.setraw(fd)
    return fd


def read_some(fd):
    try:
        return os.read(fd, 4096)
    except BlockingIOError:
        return b""


@pytest.fixture
def line(tmp_path):
    """A running cable, and the board's end of it."""
    cable = Cable(tmp_path / "board")
    ours, boards = socket.socketpair()
    boards.settimeout(GENEROUS_S)
    cable.connect_board(ours.fileno())
    cable.start()
    yield cable, boards
    cable.stop()
    ours.close()
    boards.close()


def test_a_port_is_raw_both_ways(tmp_path):
    port = PtyPort(tmp_path / "port")
    port.plug()
    host = open_raw(tmp_path / "port")
    every = bytes(range(256))
    wait_until(port.host_open)
    assert port.write(every) == 256
    assert wait_until(lambda: read_some(host)) == every
    os.write(host, every)
    assert wait_until(port.read) == every
    os.close(host)
    port.unplug()


def test_what_nobody_listens_to_is_lost(tmp_path):
    port = PtyPort(tmp_path / "port")
    port.plug()
    assert not port.host_open()
    assert port.write(b"lost") == 4
    host = open_raw(tmp_path / "port")
    wait_until(port.host_open)
    port.write(b"heard")
    assert wait_until(lambda: read_some(host)) == b"heard"
    os.close(host)
    wait_until(lambda: not port.host_open())
    port.unplug()


def test_a_host_that_does_not_read_holds_up_the_writer(tmp_path):
    port = PtyPort(tmp_path / "port")
    port.plug()
    host = open_raw(tmp_path / "port")
    wait_until(port.host_open)
    written = 0
    while (count := port.write(bytes(4096))) and written < 1 << 20:
        written += count
    assert 0 < written < 1 << 20
    os.close(host)
    port.unplug()


def test_bytes_go_through_the_cable_both_ways(line):
    cable, board = line
    host = open_raw(cable.port.path)
    wait_until(cable.host_open)
    os.write(host, b"\x00up\x03\xff")
    assert board.recv(100) == b"\x00up\x03\xff"
    board.sendall(b"\x00down\x11\x13")
    assert wait_until(lambda: read_some(host)) == b"\x00down\x11\x13"
    os.close(host)


def test_pulled_the_host_gets_an_error_and_plugged_the_path_is_back(line):
    cable, board = line
    host = open_raw(cable.port.path)
    wait_until(cable.host_open)
    cable.pull()
    assert not cable.port.path.exists()

    def broken():
        try:
            return os.read(host, 1) == b""
        except BlockingIOError:
            return False
        except OSError as error:
            return error.errno == errno.EIO

    wait_until(broken, "an error at the host")
    os.close(host)
    cable.plug()
    host = open_raw(cable.port.path)
    os.write(host, b"again")
    assert board.recv(100) == b"again"
    os.close(host)


def test_pyserial_opens_it(line):
    cable, board = line
    with serial.Serial(str(cable.port.path), 115200, timeout=GENEROUS_S, exclusive=True) as port:
        port.write(b"hello")
        assert board.recv(100) == b"hello"
        wait_until(cable.host_open)
        board.sendall(b"board")
        assert port.read(5) == b"board"


def test_a_new_board_gets_the_line(line):
    cable, old = line
    host = open_raw(cable.port.path)
    old.close()
    ours, new = socket.socketpair()
    new.settimeout(GENEROUS_S)
    cable.connect_board(ours.fileno())
    os.write(host, b"to the new one")
    assert new.recv(100) == b"to the new one"
    cable.connect_board(-1)
    for end in (ours, new):
        end.close()
    os.close(host)


def test_dropped_corrupt_and_doubled_bytes(line):
    cable, board = line
    host = open_raw(cable.port.path)
    cable.set_damage(corrupt=1.0)
    os.write(host, b"aaaa")
    damaged = board.recv(100)
    assert len(damaged) == 4
    assert b"a" not in damaged
    cable.set_damage(duplicate=1.0)
    os.write(host, b"ab")
    assert board.recv(100) == b"aabb"
    cable.set_damage(drop=1.0)
    os.write(host, b"gone")
    wait_until(lambda: cable.to_board.wait_s(0.0) is None)
    time.sleep(0.05)  # a dropped byte cannot be waited for
    cable.set_damage()
    os.write(host, b"back")
    assert board.recv(100).endswith(b"back")
    with pytest.raises(ValueError, match="is not within"):
        cable.set_damage(drop=1.5)
    os.close(host)


def test_delayed_bytes_come_in_order_and_not_before(line):
    cable, board = line
    host = open_raw(cable.port.path)
    cable.set_damage(delay_ms=100.0)
    sent_s = time.monotonic()
    os.write(host, b"one")
    os.write(host, b"two")
    got = b""
    while len(got) < 6:
        got += board.recv(100)
    assert got == b"onetwo"
    assert time.monotonic() - sent_s >= 0.1
    os.close(host)


def test_a_terminal_can_be_the_board(tmp_path):
    master, slave = os.openpty()
    cable = Cable(tmp_path / "board")
    fd = cable.connect_tty(os.ttyname(slave))
    cable.start()
    host = open_raw(cable.port.path)
    os.write(host, b"\x03raw\r")
    assert wait_until(lambda: os.read(master, 100)) == b"\x03raw\r"
    cable.stop()
    for end in (master, slave, fd, host):
        os.close(end)
