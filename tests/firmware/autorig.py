# An auto motion in the core, under way: what the tests of board_core_auto begin with.

from gazesim.core_rig import Core


def going(linear=500, turn=0):
    core = Core()
    core.arm()
    core.auto(linear, turn)
    core.tick()
    assert core.moving(), core.why()
    return core


# Its press has ended, and only a new one goes on.
def spent(core, reason):
    assert not core.moving(), core.why()
    assert core.safety.override == reason, core.why()
    assert core.safety.edge == 0
    core.watched = True
    core.hold_ms = core.hold_ms or 150
    for _ in range(50):
        core.tick()
        assert not core.moving(), core.why()
    core.auto()
    core.tick()
    assert core.moving(), core.why()
    return True
