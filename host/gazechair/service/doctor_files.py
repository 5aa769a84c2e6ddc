"""Which files of the state folder are damaged, for the doctor: changes none of them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from gazechair.alerts.diary import Diary
from gazechair.base.health import DEGRADED, LOST, HealthRegistry, HealthState
from gazechair.commissioning.tune.forward_store import ForwardStore
from gazechair.config.settings import Config
from gazechair.driving.speed_cap_store import SpeedCapStore
from gazechair.people.pairing.store import DeviceStore
from gazechair.people.profiles import Profiles, house_fields
from gazechair.picture.floor_store import FloorStore


def damaged(folder: Path, config: Config) -> Iterator[HealthState]:
    """What is wrong with files of the state folder `folder`, which exists.

    The results of the first drive are checked by the host alone, whose room uses this one.
    """
    parts = HealthRegistry()
    DeviceStore(folder, parts.part("devices"))
    Profiles(folder, house_fields(config), parts.part("profiles"))
    SpeedCapStore(folder, parts.part("speed cap")).read()
    Diary(folder, parts.part("alerts")).read()
    ForwardStore(folder, parts.part("forward"))
    FloorStore(folder, parts.part("camera"))
    yield from (found for found in parts.states().values() if found.state in (DEGRADED, LOST))
