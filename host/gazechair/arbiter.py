"""The arbiter, pure: of all that the pages say, what the board is told. Times: monotonic seconds.

One page owns the chair at a time; anyone's stop wins at once. A press (edge) that has ended, for
whatever reason, never moves the chair again: the driver must press anew.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from gazechair.outgoing import STOP_COMMAND, Command
from gazechair.page_messages import (
    DISARM,
    EMERGENCY,
    STOP,
    Arm,
    Beat,
    Drive,
    PageMessage,
)
from gazelink import codes

TOKEN_VALID_S = 0.25
TTL_S = 0.3
PAGE_SILENT_S = 0.3
ARM_ANSWER_S = 1.0  # an order to arm that the board has not followed by then has failed

ROLES = {"driver": codes.DRIVER, "caretaker": codes.CARETAKER}


@dataclass(frozen=True)
class Refusal:
    """Why a message was not followed."""

    what: str
    """ "cmd", "arm" or "message"."""
    reason: str
    """A key of the string tables."""
    detail: str


@dataclass
class _Client:
    role: int
    heard_s: float
    last_edge: int = 0  # newest page edge seen, moved or not
    told: set[str] = field(default_factory=set)  # refusals told about that edge


@dataclass(frozen=True)
class _Press:
    client: int
    page_edge: int
    command: Command
    alive: bool  # may still be refreshed


class Arbiter:
    """Not thread-safe: the owner locks. Call tick() at least every 50 ms."""

    def __init__(self, last_edge: int = 0, first_token: int = 0) -> None:
        """`last_edge`: board edges go on from here, 0..255; `first_token`: tokens begin here."""
        self._clients: dict[int, _Client] = {}
        self._next_client = 1
        self._last_edge = last_edge
        self._first_token = first_token
        self._press: _Press | None = None
        self._pages_edge = (0, 0, 0)  # board edge, client, page edge: to answer in page edges
        self._owner: int | None = None
        self._arm_asked_s: float | None = None
        self._state = codes.DISARMED
        self._session = 0
        self._board_edge = 0
        self._orders: list[tuple[int, int]] = []
        self.page_silent = False
        """The owner has not been heard for 300 ms."""

    # What comes out

    @property
    def command(self) -> Command:
        """What the board is to be told now, and again until it changes."""
        return STOP_COMMAND if self._press is None else self._press.command

    def take_orders(self) -> list[tuple[int, int]]:
        """New (action, owner) orders since the last call, in order."""
        orders, self._orders = self._orders, []
        return orders

    @property
    def owner(self) -> int | None:
        """Client id of the page that drives, None for nobody."""
        return self._owner

    @property
    def owner_code(self) -> int:
        """codes.NOBODY, DRIVER or CARETAKER."""
        return codes.NOBODY if self._owner is None else self._clients[self._owner].role

    def page_edge(self, client: int) -> int:
        """The page's own edge of the press the board last took from it, 0 for none."""
        board_edge, of_client, page_edge = self._pages_edge
        return page_edge if client == of_client and self._board_edge == board_edge != 0 else 0

    # Tokens

    def issue_token(self, now_s: float) -> int:
        """A token that is valid for 250 ms: milliseconds of the host's clock since its start."""
        return self._first_token + int(now_s * 1000)

    def _fresh(self, token: int | None, now_s: float) -> bool:
        return token is not None and 0 <= self._age_ms(token, now_s) <= TOKEN_VALID_S * 1000

    def _age_ms(self, token: int, now_s: float) -> int:
        return self.issue_token(now_s) - token

    def _deadline_s(self, wish: Drive, now_s: float) -> float:
        # From page to wheels: the page proved the holding after it got its token, so counting from
        # the token's birth makes the way through the network part of the time to live.
        return now_s + TTL_S - self._age_ms(wish.token, now_s) / 1000

    # What goes in

    def connect(self, role: str, now_s: float) -> int:
        """A page of `role` has come; its client id. Raises KeyError on an unknown role."""
        client = self._next_client
        self._next_client += 1
        self._clients[client] = _Client(ROLES[role], now_s)
        return client

    def disconnect(self, client: int, now_s: float) -> None:
        """A page has gone. When it drove: stop and disarm."""
        if self._press is not None and self._press.client == client:
            self._stop()
        if client == self._owner:
            self._order(codes.DISARM, client)
            self._owner = None
        self._clients.pop(client, None)

    def receive(self, client: int, message: PageMessage, now_s: float) -> Refusal | None:
        """Act on one message; a refusal if it was not followed and its page should be told."""
        page = self._clients.get(client)
        if page is None:
            return Refusal("message", "not_owner", "this page is not connected any more")
        self.tick(now_s)
        if isinstance(message, Drive):
            return self._drive(client, page, message, now_s)
        if isinstance(message, Arm):
            return self._arm(client, page, message, now_s)
        if isinstance(message, Beat):
            if self._fresh(message.token, now_s):
                self._heard(client, page, now_s)
            return None
        if message is STOP:
            self._stop()
        elif message is DISARM:
            self._stop()
            self._order(codes.DISARM, client)
            self._owner = None
        elif message is EMERGENCY:
            self._stop()
            self._order(codes.EMERGENCY_STOP, client)
            self._owner = None
        elif page.role != codes.CARETAKER:
            detail = "only the caretaker resets faults; or press the button at the chair for 3 s"
            return Refusal("message", "not_owner", detail)
        else:
            self._order(codes.RESET_FAULTS, client)
        return None

    def board(self, session: int, state: int, edge: int, now_s: float) -> None:
        """What the board is now: session (0 = none), codes.DISARMED.., edge it last accepted."""
        if session != self._session:
            self._session = session
            self._stop()
        was = self._state
        self._state = state
        self._board_edge = edge
        # Just asked to arm, the board may still be on its way from an earlier disarming.
        if state == codes.DISARMED != was and self._arm_asked_s is None:
            self._end_press()
            self._owner = None
        self.tick(now_s)

    def tick(self, now_s: float) -> None:
        """Let time act: an owner gone silent is stopped, an unanswered order to arm lapses."""
        if self._arm_asked_s is not None and now_s - self._arm_asked_s > ARM_ANSWER_S:
            self._arm_asked_s = None
            if self._state == codes.DISARMED:
                self._stop()
                self._owner = None
        owner = None if self._owner is None else self._clients[self._owner]
        self.page_silent = owner is not None and now_s - owner.heard_s > PAGE_SILENT_S
        if self.page_silent:
            self._stop()
        press = self._press
        if press is not None and now_s >= press.command.ttl_deadline_s:
            self._end_press()

    def _heard(self, client: int, page: _Client, now_s: float) -> None:
        page.heard_s = now_s
        if client == self._owner:
            self.page_silent = False

    # Driving

    def _drive(self, client: int, page: _Client, wish: Drive, now_s: float) -> Refusal | None:
        if not self._fresh(wish.token, now_s):
            return Refusal("cmd", "stale_token", "the command was too long on its way")
        self._heard(client, page, now_s)
        new = wish.edge > page.last_edge
        if new:
            page.last_edge = wish.edge
            page.told.clear()
        if client != self._owner:
            reason = "not_armed" if self._owner is None else "not_owner"
            return self._refuse_once(client, page, reason)
        if self._session == 0:
            return self._refuse_once(client, page, "not_connected")
        if self._state != codes.ARMED:
            return self._refuse_once(client, page, "not_armed")
        if new:
            self._begin_press(client, page, wish, now_s)
            return None
        press = self._press
        if press is None or press.page_edge != wish.edge or not press.alive:
            return self._refuse_once(client, page, "needs_new_command")
        if (press.command.verb, press.command.mode) != (wish.verb, wish.mode):
            self._stop()
            return self._refuse_once(client, page, "needs_new_command")
        deadline_s = max(press.command.ttl_deadline_s, self._deadline_s(wish, now_s))
        self._press = replace(press, command=replace(press.command, ttl_deadline_s=deadline_s))
        return None

    def _begin_press(self, client: int, page: _Client, wish: Drive, now_s: float) -> None:
        edge = self._last_edge % 255 + 1
        if edge == self._board_edge:
            edge = edge % 255 + 1  # the board knows it from another host's life
        self._last_edge = edge
        deadline_s = self._deadline_s(wish, now_s)
        command = Command(wish.verb, wish.mode, edge, page.role, deadline_s)
        self._press = _Press(client, wish.edge, command, alive=True)
        self._pages_edge = (edge, client, wish.edge)

    def _refuse_once(self, client: int, page: _Client, reason: str) -> Refusal | None:
        # A held button repeats every 50 ms; once a press is enough to say why it does not move.
        if reason in page.told:
            return None
        page.told.add(reason)
        return Refusal("cmd", reason, f"press {page.last_edge} does not move the chair: {reason}")

    def _arm(self, client: int, page: _Client, wish: Arm, now_s: float) -> Refusal | None:
        if not self._fresh(wish.token, now_s):
            return Refusal("arm", "stale_token", "the wish to drive was too long on its way")
        self._heard(client, page, now_s)
        if self._session == 0:
            return Refusal("arm", "not_connected", "the board is not connected")
        free = self._owner in (None, client)
        if not free and page.role != codes.CARETAKER:
            return Refusal("arm", "not_owner", "another page drives; it must stop driving first")
        self._stop()
        self._owner = client
        self._arm_asked_s = now_s
        self._order(codes.ARM, client)
        return None

    def _stop(self) -> None:
        self._press = None

    def _end_press(self) -> None:
        # It stays the last command, without time to live: a step may finish, and the board goes
        # on explaining why it overruled this press until the page lets go.
        if self._press is not None and self._press.alive:
            command = replace(self._press.command, ttl_deadline_s=0.0)
            self._press = replace(self._press, command=command, alive=False)

    def _order(self, action: int, client: int) -> None:
        self._orders.append((action, self._clients[client].role))
