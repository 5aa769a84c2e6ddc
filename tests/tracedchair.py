"""A chair in virtual time whose host logs the board's trace, and three drives of it."""

from __future__ import annotations

from pathlib import Path

from gazelink import codes
from gazereplay.recording import virtual_log
from gazesim.chair_rig import LinkedChair
from gazesim.lockstep_link import LockstepLink


class TracedChair(LinkedChair):
    """In virtual time; its host logs the frames of the line, and nothing else."""

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self._log = virtual_log(folder, lambda: self.now_ms)

        def witness(way: str, at_s: float, frame: bytes) -> None:
            self._log.write(way, int(at_s * 1e9), frame)

        sessions = iter(range(7, 9999)).__next__
        self.link = LockstepLink(self.cable, self.now_s, sessions, witness, traced=True)

    def close(self) -> Path:
        """Finish the file."""
        self.run(60)  # the line has it all
        path = self._log.path
        assert path is not None
        self._log.close()
        return path


def drive(chair: TracedChair) -> None:
    """Forward until something is in the way, a step, and the host falls silent."""
    chair.arm()
    chair.press(codes.FORWARD)
    chair.run(500)
    chair.blocked = 1
    chair.run(200)
    chair.release()
    chair.run(600)
    chair.blocked = 0
    chair.press(codes.LEFT, codes.STEP)
    chair.run(2500)
    chair.press(codes.RIGHT)
    chair.run(500)
    chair.link.alive = False
    chair.run(300)
    chair.link.alive = True
    chair.run(300)


def faults(chair: TracedChair) -> None:
    """Wipers, heading, service loop, tick and lidar fail, and the button at the chair."""
    chair.arm()
    chair.press(codes.LEFT)
    chair.run(300)
    chair.world.faults.inject("imu_freeze")
    chair.run(200)
    chair.world.faults.clear("imu_freeze")
    chair.run(300)
    chair.press(codes.FORWARD)
    chair.run(300)
    chair.board.blocked = True
    chair.run(80)
    chair.board.blocked = False
    chair.run(300)
    chair.sees = False
    chair.run(500)
    chair.sees = True
    chair.run(400)
    chair.press(codes.BACKWARD)
    chair.run(200)
    chair.board.hung = True
    chair.run(30)
    chair.board.hung = False
    chair.run(700)
    chair.world.faults.inject("wiper_nak")
    chair.run(100)
    chair.world.faults.clear("wiper_nak")
    chair.run(500)


def restart(chair: TracedChair) -> None:
    """The board is reset while it drives."""
    chair.arm()
    chair.press(codes.LEFT)
    chair.run(400)
    chair.board.reset()
    chair.release()
    chair.run(1500)
    chair.arm()
    chair.press(codes.RIGHT)
    chair.run(400)
