"""The pages' port for spots in the picture: {"k": "spot"}, fresh, from the page that drives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from gazechair.driving.control import Control
from gazechair.driving.driver_port import DriverPort, Message, RelayingPort
from gazechair.driving.messages import BadMessage, Watch, parse
from gazechair.driving.refusal import Refusal
from gazechair.producers.spot_service import At

Choose = Callable[[str, At | None, float], bool]


class SpotPort(RelayingPort):
    """The DriverPort `port` with spots added. A spot moves nothing."""

    def __init__(self, port: DriverPort, control: Control, choose: Choose) -> None:
        """`choose`: as SpotService.choose, of all kinds."""
        super().__init__(port)
        self._control = control
        self._choose = choose

    def receive(self, client: int, message: Message) -> list[Message]:
        if message.get("k") != "spot":
            return super().receive(client, message)
        refusal = self._spot(client, message)
        return [] if refusal is None else [refusal.message()]

    def _spot(self, client: int, message: Message) -> Refusal | None:
        try:
            fresh = parse({**message, "k": "watch"})
            tile, at = message.get("tile"), _at(message.get("at"))
            if not isinstance(tile, str):
                raise BadMessage('spot: "tile" must be the name of a tile')
        except BadMessage as error:
            return Refusal("spot", "bad_message", str(error))
        assert isinstance(fresh, Watch)
        at_s, in_time = self._control.proven(fresh.proof)
        if not in_time:
            return Refusal("spot", "stale_token", "the spot was too long on its way")
        if not self._control.snapshot(client)["you"]:
            return Refusal("spot", "not_owner", "another page drives")
        if not self._choose(tile, at, at_s):
            return Refusal("spot", "no_answer", f"no tile {tile[:20]}")
        return None


def _at(value: Any) -> At | None:
    if value is None:
        return None
    if isinstance(value, list) and len(value) == 2 and all(map(_is_share, value)):
        return float(value[0]), float(value[1])
    raise BadMessage('spot: "at" must be two numbers 0..1, or null')


def _is_share(value: Any) -> bool:
    return type(value) in (int, float) and 0.0 <= value <= 1.0  # nan is not
