"""The faults of the lidar that can be injected, by name."""

from __future__ import annotations

from collections.abc import Callable

from gazesim.faults import Argument, Fault
from gazesim.s2 import S2
from gazesim.s2_beams import Beams


def _lidar(name: str) -> tuple[Callable[..., None], Callable[[S2], None]]:
    """A yes-or-no fault that is an attribute of the lidar."""

    def set_it(lidar: S2) -> None:
        setattr(lidar, name, True)

    def end_it(lidar: S2) -> None:
        setattr(lidar, name, False)

    return set_it, end_it


def _lidar_share(name: str) -> tuple[Callable[..., None], Callable[[S2], None]]:
    """A fault that hits a share of the lidar's bytes."""

    def set_it(lidar: S2, share: float) -> None:
        setattr(lidar, name, share)

    def end_it(lidar: S2) -> None:
        setattr(lidar, name, 0.0)

    return set_it, end_it


def _lidar_beams(name: str) -> tuple[Callable[..., None], Callable[[S2], None]]:
    """A fault of the lidar's beams whose one argument is the value of attribute `name`."""

    def set_it(lidar: S2, **arguments: float) -> None:
        (value,) = arguments.values()
        setattr(lidar.beams, name, value)

    def end_it(lidar: S2) -> None:
        setattr(lidar.beams, name, getattr(Beams, name))

    return set_it, end_it


def _cover(lidar: S2, from_deg: float, to_deg: float) -> None:
    lidar.beams.covered_deg = (from_deg, to_deg)


def _uncover(lidar: S2) -> None:
    lidar.beams.covered_deg = None


def _freeze_lidar(lidar: S2, frozen: bool) -> None:
    lidar.beams.frozen = frozen


LIDAR_FAULTS = (
    Fault("lidar_stall", "lidar falls silent", *_lidar("stalled")),
    Fault("lidar_protection_stop", "lidar in protection stop", *_lidar("protection_stop")),
    Fault("lidar_mirror_blocked", "lidar's mirror stands still", *_lidar("mirror_blocked")),
    Fault("lidar_power_dip", "lidar's supply sags: it is idle", S2.power_dip),
    Fault(
        "lidar_frozen",
        "lidar repeats its last turn for ever",
        lambda one: _freeze_lidar(one, True),
        lambda one: _freeze_lidar(one, False),
    ),
    Fault(
        "lidar_covered",
        "an arc of the lidar's window is covered",
        _cover,
        _uncover,
        (Argument("from_deg", -90.0, -180.0, 180.0), Argument("to_deg", 90.0, -180.0, 180.0)),
    ),
    Fault(
        "lidar_noise",
        "lidar's ranges scatter",
        *_lidar_beams("noise_m"),
        (Argument("noise_m", 0.03, 0.0, 0.5),),
    ),
    Fault(
        "lidar_speckle",
        "a share of the lidar's beams brings back nothing real",
        *_lidar_beams("speckle"),
        (Argument("share", 0.001, 0.0, 1.0),),
    ),
    Fault(
        "lidar_corrupt",
        "a share of the lidar's bytes is wrong",
        *_lidar_share("corrupt"),
        (Argument("share", 0.001, 0.0, 1.0),),
    ),
    Fault(
        "lidar_drop",
        "a share of the lidar's bytes is lost",
        *_lidar_share("drop"),
        (Argument("share", 0.001, 0.0, 1.0),),
    ),
)
