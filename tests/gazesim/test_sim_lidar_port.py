"""The S2 on its pty, driven by the library the host uses: rplidar-roboticia."""

import threading
import time

import pytest
import rplidar
import serial

from gazesim.bank import Bank
from gazesim.pty_port import PtyPort
from gazesim.world import World


@pytest.fixture
def lidar_path(tmp_path, monkeypatch):
    """A lidar in the test room, streaming in real time."""
    # A pty has no modem lines: what a USB port ignores raises there.
    monkeypatch.setattr(serial.Serial, "_update_dtr_state", lambda self: None)
    world = World(Bank.in_memory(), "wall")
    port = PtyPort(tmp_path / "lidar")
    port.plug()
    stopping = threading.Event()

    def run():
        last_s = time.monotonic()
        while not stopping.wait(0.002):
            now_s = time.monotonic()
            steps = min(20, int((now_s - last_s) * 1000))
            last_s += steps / 1000 if steps < 20 else now_s - last_s
            world.lidar.receive(port.read())
            for _ in range(steps):
                port.write(world.step(0.001))

    thread = threading.Thread(target=run, name="lidar")
    thread.start()
    yield tmp_path / "lidar"
    stopping.set()
    thread.join()
    port.unplug()


def test_the_library_identifies_it_and_reads_scans(lidar_path):
    device = rplidar.RPLidar(str(lidar_path), baudrate=1_000_000, timeout=20)
    device.stop()
    info = device.get_info()
    assert info["model"] == 0x71
    assert info["firmware"] == (1, 2)
    assert info["hardware"] == 18
    assert bytes.fromhex(info["serialnumber"]).startswith(b"SIM")
    assert device.get_health() == ("Good", 0)
    scans = device.iter_scans(max_buf_meas=False, min_len=1000)
    next(scans)
    scan = next(scans)
    ahead = sorted(mm for _, angle_deg, mm in scan if angle_deg < 1 or angle_deg > 359)
    assert ahead[len(ahead) // 2] == pytest.approx(3500, abs=20)
    device.stop()
    device.stop_motor()
    device.disconnect()
