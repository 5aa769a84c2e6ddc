"""The fuzzer of the whole firmware: deterministic, replayable, and neither blind nor too strict."""

from pathlib import Path

import pytest

from gazelink import codes
from gazeprove import fuzz, fuzz_mutants
from gazeprove.fuzz_facts import Violation
from gazeprove.fuzz_host import Reader
from gazeprove.fuzz_life import Life

pytestmark = pytest.mark.costly

SEED = 1


@pytest.fixture
def life(tmp_path: Path) -> Life:
    """A life that is armed."""
    life = Life(SEED, str(tmp_path), log=True)
    life.run(life.ready())
    assert life.enabled, life.state
    return life


def test_a_life_follows_from_its_seed() -> None:
    """Run twice, it takes the same ticks and does the same."""
    one, other = fuzz.live(SEED), fuzz.live(SEED)
    assert one == other
    assert one.ticks > 1000


def test_episodes_that_are_left_out_are_not_run() -> None:
    """What is left of a life is shorter."""
    assert len(fuzz.live(SEED, frozenset({0, 3})).episodes) == 2


@pytest.mark.parametrize("planted", fuzz_mutants.PLANTED, ids=lambda planted: planted.name)
def test_planted_mistakes_fit_the_firmware(planted: fuzz_mutants.Planted, tmp_path: Path) -> None:
    """Each changes its one place, and the copy still compiles."""
    fuzz_mutants.plant(planted, tmp_path)
    compile((tmp_path / planted.file).read_text(), planted.file, "exec")


def test_a_press_moves_and_a_stop_ends_it(life: Life) -> None:
    """The rig drives: a proof over a chair that stands says nothing."""
    life.run(life.drive(verb=codes.FORWARD, mode=codes.CONTINUOUS))
    assert life.moving
    life.host.let_go()
    life.run(iter((5,)))
    assert not life.moving


def test_the_oracle_sees_a_wiper_that_moves_by_itself(life: Life) -> None:
    """Nobody asked for it."""
    life.world.pot.registers[0] = 200
    with pytest.raises(Violation, match="P13"):
        life.oracle.ticked(200, 170, True, False, False)


def test_the_oracle_sees_an_enable_line_that_nobody_armed(tmp_path: Path) -> None:
    """No order was given."""
    life = Life(SEED, str(tmp_path))
    life.run(iter((900,)))
    life.world.enable = 1
    with pytest.raises(Violation, match="P14"):
        life.oracle.ticked(170, 170, True, False, False)


def test_the_oracle_sees_a_motion_that_outlives_its_press(life: Life) -> None:
    """P3: 300 ms after the last command there may be none."""
    life.run(life.drive(verb=codes.FORWARD, mode=codes.CONTINUOUS))
    life.host.says_command = False
    life.run(iter((310,)))
    assert not life.moving
    with pytest.raises(Violation, match="P3"):
        life.oracle.ticked(200, 170, True, False, False)


def test_the_reader_refuses_what_is_damaged() -> None:
    """Garbage is counted, and the next frame is looked for."""
    reader = Reader()
    assert reader.take(bytearray(b"\x05abcd\x00\x00\x03\x01"), b"\0\0\0\0") == []
    assert reader.broken == 2
