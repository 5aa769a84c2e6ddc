"""A producer's process without pipes: takes messages and datagrams, steps the kind, sends values.

A step that takes longer than a value lives continues in its own thread; meanwhile the chair
stands, and this reports so. One that is only late, on a busy machine, stops nothing: the value
before it still lives.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, Future, wait
from typing import Any, Protocol

from gazechair.base.latest_value import Clock
from gazechair.picture.newest import Shot
from gazechair.producers.contract import STEP_S, Ask, Output, Press, Producer, Sensed, SpotProducer
from gazechair.producers.exchange import MESSAGE_OLD_S, pack
from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Lidars, Piece
from gazechair.sensing.mapping.locating.whereabouts import Whereabouts
from gazechair.sensing.odometry.estimate import Estimate

PULSE_S = 0.25
_WAITS_S = 0.03  # for a step, in a tick
_LATE_S = 0.1  # after a value, before it reports that it thinks
_BORN_S = 0.05  # a value is born at the end of its step, at most this long after its beginning
_DUE_S = 1e-6  # rounding
_HANGS_S = 20.0  # a longer step counts as hanging
_OLD_S = 0.5  # older data in the inbox is useless
_KEPT_S = 4.0  # before a press: longer than following a person looks back
_IDLE = Output(None)
_STANDS = (0, 0)


class Out(Protocol):
    """Destination of its reports; see RecordWriter."""

    def data(self, payload: bytes) -> None: ...


class Runner:
    """Feed it with `on_message` and `received`; call `tick` when it is due, see `left_s`.

    A hang or an exception ends it.
    """

    def __init__(
        self,
        producer: Producer,
        lidars: Lidars,
        out: Out,
        thinker: Executor,
        clock: Clock,
        picture: Callable[[], Shot | None] = lambda: None,
    ) -> None:
        """`thinker`: runs one step at a time; `picture`: the newest, None: no newer one."""
        self._producer = producer
        self._lidars = lidars
        self._out = out
        self._thinker = thinker
        self._clock = clock
        self._picture = picture
        self._ask: Ask | None = None
        self._known_ask = 0  # the ask that the kind has received
        self._answered = 0  # the ask that it has ended with this answer
        self._answer = _IDLE
        self._press: Press | None = None
        self._begun = 0  # the press that the kind has received
        self._over = 0  # the press that the kind has ended
        self._step: Future[Output] | None = None
        self._step_of, self._step_s = 0, 0.0
        self._value_s = float("-inf")  # the birth of the newest value of this press
        self._shown = _IDLE
        self._received: deque[tuple[float, Piece | Estimate | Motion]] = deque()
        self._where: Whereabouts | None = None
        self._cap_permille = 1000
        self._message_s = self._sent_s = float("-inf")
        self._due_s = clock()

    def left_s(self, now_s: float) -> float:
        """Seconds until `tick` is due: every STEP_S, and at once after a press."""
        left_s = self._due_s - now_s
        return left_s if left_s > _DUE_S else 0.0

    def on_message(self, message: Mapping[str, Any]) -> None:
        """Process a message from the daemon; see exchange."""
        self._message_s = float(message["at_s"])
        ask = message.get("ask")
        self._ask = None if ask is None else Ask(**ask)
        number = int(message["press"])
        if number == 0:
            self._press = None
            return
        self._cap_permille = int(message["cap_permille"])
        if self._press is not None and self._press.number == number:
            return
        more = message["target"], message["settings"], message["may_reverse"]
        self._press = Press(number, *more, self._message_s)
        self._due_s = min(self._due_s, self._clock())

    def received(
        self, data: HalfTurn | Motion | Estimate | Whereabouts | None, now_s: float
    ) -> None:
        """Process data from the inbox."""
        if isinstance(data, HalfTurn):
            piece = self._lidars.piece(data) if data.last_s > now_s - _OLD_S else None
            if piece is not None:
                self._keep(piece, now_s)
        elif isinstance(data, (Estimate, Motion)):
            self._keep(data, now_s)
        elif isinstance(data, Whereabouts):
            self._where = data

    def _keep(self, item: Piece | Estimate | Motion, now_s: float) -> None:
        self._received.append((now_s, item))
        while self._received[0][0] < now_s - _KEPT_S:
            self._received.popleft()

    def tick(self, now_s: float) -> None:
        """Send what is due now. Raises what the kind raises, RuntimeError when it hangs."""
        self._due_s = max(self._due_s + STEP_S, now_s)
        press = self._press if now_s - self._message_s <= MESSAGE_OLD_S else None
        if self._step is None and press is not None and press.number != self._over:
            self._begin(press, now_s)
        ask = self._ask if press is None and now_s - self._message_s <= MESSAGE_OLD_S else None
        if self._step is None and ask is not None and ask.number != self._answered:
            self._begin_waiting(ask, now_s)
        if self._step is not None:
            wait((self._step,), _WAITS_S)
            if self._step.done():
                self._finish(press)
                return
            if now_s - self._step_s > _HANGS_S:
                raise RuntimeError(f"a step takes longer than {_HANGS_S:g} s")
            mine = press is not None and press.number == self._begun
            if mine and self._clock() < self._value_s + _LATE_S:
                return
        now_s = self._clock()
        if press is not None and press.number == self._over:
            self._send(now_s, press.number, self._shown)  # repeat: only the newest record is read
        elif press is not None:
            known = self._shown if self._begun == press.number else _IDLE
            self._send(now_s, press.number, Output(_STANDS, "thinks", known.reason, known.shown))
        elif now_s >= self._sent_s + PULSE_S:  # alive, though not pressed
            over = ask is not None and ask.number == self._answered
            self._send(now_s, 0, self._answer if over else _IDLE, self._answered if over else 0)

    def _sensed(self) -> Sensed:
        sensed = Sensed(where=self._where, picture=self._picture(), cap_permille=self._cap_permille)
        self._where = None
        for _, one in self._received:
            if isinstance(one, Piece):
                sensed.pieces.append(one)
            elif isinstance(one, Estimate):
                sensed.estimates.append(one)
            else:
                sensed.motions.append(one)
        self._received.clear()
        return sensed

    def _begin_waiting(self, ask: Ask, now_s: float) -> None:
        kind, sensed = self._producer, self._sensed()
        if not isinstance(kind, SpotProducer):
            raise TypeError("a spot was chosen for a kind that has none")
        anew, self._known_ask = ask.number != self._known_ask, ask.number

        def work() -> Output:
            if anew:
                kind.ask(ask)
            return kind.wait(sensed, now_s)

        self._step_of, self._step_s = 0, now_s
        self._step = self._thinker.submit(work)

    def _begin(self, press: Press, now_s: float) -> None:
        sensed = self._sensed()
        anew, self._begun = press.number != self._begun, press.number
        if anew:
            self._shown, self._value_s = _IDLE, float("-inf")

        def work() -> Output:
            if anew:
                self._producer.press(press)
            return self._producer.step(sensed, now_s)

        self._step_of, self._step_s = press.number, now_s
        self._step = self._thinker.submit(work)

    def _finish(self, press: Press | None) -> None:
        assert self._step is not None
        output, self._step = self._step.result(), None
        born_s = min(self._clock(), self._step_s + _BORN_S)
        if self._step_of == 0:
            if output.state == "ended":
                self._answered, self._answer = self._known_ask, output
            if press is None:
                self._send(born_s, 0, output, self._known_ask)
            return
        if press is None or press.number != self._step_of:
            return  # it belongs to a press that is over
        self._shown, self._value_s = output, born_s
        if output.stick is None:
            self._over = press.number
        self._send(born_s, press.number, output)

    def _send(self, born_s: float, press: int, output: Output, ask: int = 0) -> None:
        self._sent_s = born_s
        self._out.data(pack(born_s, press, output, ask))
