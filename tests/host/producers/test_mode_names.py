"""No plug-in may have the name of one of gazechair's own modes: their values would mix."""

from __future__ import annotations

import pytest

from gazechair.config import configuration
from gazechair.config.configuration import ConfigError
from gazechair.producers import places, tiles
from gazechair.producers.tiles import people

_TILES = [tile for tile, *_ in tiles.TILES.values()]
OURS = [
    "places",
    *people(True),
    *_TILES,
    *(f"{tile}-12" for tile in _TILES),
    f"{places._PREFIX}-1a2b3c4d-1",
]


@pytest.mark.parametrize("name", OURS)
def test_it_is_refused_as_the_name_of_a_plug_in(name: str) -> None:
    with pytest.raises(ConfigError, match=f"{name} is gazechair's own"):
        configuration.parse(f"[mode.{name}]\n")
