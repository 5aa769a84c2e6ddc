"""The arbiter: selects from all pages' messages what the board receives. Pure.

Times are monotonic seconds. One page owns the chair at a time; a stop from any driver or caretaker
takes effect at once. The caretaker may take over at any time, a driver when there is no owner. An
input (a plug-in) never owns the chair: it drives alongside its person's page, while that owns it. A
press (edge) that has ended, for any reason, never moves the chair again: its person must press
again. An auto mode needs no holding: it lasts under supervision (Watch) until anything is pressed.
"""

from __future__ import annotations

import math
from dataclasses import replace

from gazechair.board.board_commands import Bypass, Command
from gazechair.driving.bypass_button import BypassButton
from gazechair.driving.clients import ROLES, Client
from gazechair.driving.help_call import HelpCall
from gazechair.driving.messages import (
    DISARM,
    EMERGENCY,
    END_BYPASS,
    LET_GO,
    RELEASE,
    STOP,
    Arm,
    Beat,
    Call,
    Cap,
    Drive,
    HoldBypass,
    PageMessage,
    Reset,
    Take,
    UseMode,
    Watch,
)
from gazechair.driving.mode_context import ModeOutput
from gazechair.driving.press import DrivingPress
from gazechair.driving.refusal import Refusal, What, what_of
from gazechair.driving.stops import Stops
from gazechair.driving.tokens import Tokens
from gazelink import codes

LOOK_S = 0.025  # longest interval between calls of tick()
_TO_WHEELS_S = 0.005  # from here through the line and a tick of the board
THERE_S = 3.0  # a message from a caretaker's page this recently: a call would reach somebody
MODE_ANSWER_S = 0.3  # a pressed mode must answer within this, or the press ends
ARM_ANSWER_S = 1.0  # an order to arm that the board has not followed by then has failed


class Arbiter:
    """Not thread-safe: the owner locks. Call tick() at least every LOOK_S."""

    def __init__(self, last_edge: int = 0, first_token: int = 0) -> None:
        """`last_edge`: board edges continue from here, 0..255; `first_token`: first token."""
        self.cap_permille = 1000
        """The highest permitted output, 50..1000."""
        self.ttl_s = 0.0
        """How long a command lives, as reported by the board; nothing moves before that."""
        self.help = HelpCall()
        self.stops = Stops()
        self._emergency_s = 0.0
        self.tokens = Tokens(first_token)
        self._bypass = BypassButton(last_edge)
        self._clients: dict[int, Client] = {}
        self._next_client = 1
        self._press = DrivingPress(last_edge)
        self._mode_press = 0
        self._owner: int | None = None
        self._arm_requested_s: float | None = None
        self._state = codes.DISARMED
        self._session = 0
        self._board_edge = 0
        self._orders: list[tuple[int, int]] = []
        self.auto_modes: frozenset[str] = frozenset()
        """Modes that drive while nobody holds a button."""
        self.page_silent = False
        """No message from the owner has arrived for page_silent_s."""

    # Results

    @property
    def command(self) -> Command:
        """What the board receives now, and again until it changes."""
        return replace(self._press.command, cap_permille=self.cap_permille)

    @property
    def bypass(self) -> Bypass | None:
        """The caretaker's bypass button as sent to the board, None: not pressed."""
        return self._bypass.sent

    def take_orders(self) -> list[tuple[int, int]]:
        """New (action, owner) orders since the last call, in order."""
        orders, self._orders = self._orders, []
        return orders

    @property
    def owner(self) -> int | None:
        """Client id of the page that drives, None for no owner."""
        return self._owner

    @property
    def owner_code(self) -> int:
        """codes.NOBODY, DRIVER or CARETAKER."""
        return codes.NOBODY if self._owner is None else self._clients[self._owner].role

    def role(self, client: int) -> str:
        """The role of a page, "viewer" for a closed one."""
        return self._clients[client].role_name if client in self._clients else "viewer"

    def is_input(self, client: int) -> bool:
        """True for an input, False for a page."""
        return client in self._clients and self._clients[client].is_input

    def page_edge(self, client: int) -> int:
        """The page's own edge of the press that the board last accepted from it, 0 for none."""
        return self._press.page_edge(client, self._board_edge)

    def caretaker_is_there(self, now_s: float) -> bool:
        """True if a caretaker's page is connected: a call would reach it."""
        pages = [p for p in self._clients.values() if not p.is_input]
        return any(p.role == codes.CARETAKER and now_s - p.received_s <= THERE_S for p in pages)

    @property
    def mode_press(self) -> tuple[str, int]:
        """The mode that is pressed now ("" for none), and the number of that press."""
        press = self._press.now
        if press is None or not press.alive:
            return "", self._mode_press
        return self._press.mode, self._mode_press

    @property
    def auto(self) -> str:
        """The mode that drives while nobody holds it, "" for none."""
        return self._press.mode if self._press.auto else ""

    @property
    def auto_over(self) -> str:
        """The auto mode that was ended before reaching its goal, "" for none."""
        return "" if self._press.auto else self._press.unfinished

    def press_number(self) -> int:
        """The board's number for a press that belongs to no page."""
        return self._press.next_number(self._board_edge)

    @property
    def page_silent_s(self) -> float:
        """An owner who is silent for longer is stopped: a step ends when a command would."""
        return self.ttl_s - LOOK_S - _TO_WHEELS_S

    # Events

    def connect(self, role: str, now_s: float, is_input: bool = False) -> int:
        """Add a page of `role`, or an input; its client id. KeyError: unknown role."""
        client = self._next_client
        self._next_client += 1
        self._clients[client] = Client(ROLES[role], role, now_s, is_input)
        return client

    def disconnect(self, client: int) -> None:
        """A page has closed. If it drove: stop and disarm."""
        self._press.gone(client)
        if client == self._owner:
            self._order(codes.DISARM, client)
            self._owner = None
        self._bypass.gone(client)
        self._clients.pop(client, None)

    def receive(
        self, client: int, message: PageMessage, now_s: float, offered: bool = True
    ) -> Refusal | None:
        """Act on one message; returns a refusal for its page. `offered`: its mode is offered."""
        page = self._clients.get(client)
        if page is None:
            return Refusal("message", "not_owner", "this page is not connected any more")
        self.tick(now_s)
        if isinstance(message, Beat):
            if self.tokens.fresh(message.proof, now_s):
                self._received(client, page, now_s, message.proof)
            return None
        if page.role == codes.NOBODY:
            return Refusal("message", "not_allowed", "this device may only watch")
        if isinstance(message, Drive | UseMode):
            return self._drive(client, page, message, now_s, offered)
        if isinstance(message, Watch):
            watches = page.role == codes.CARETAKER or self._may_drive(client, page)
            if watches and self.tokens.fresh(message.proof, now_s):
                self._press.watch(page.role, self.tokens.proven_s(message.proof, now_s))
            return None
        if isinstance(message, Arm):
            return self._own(client, page, message, now_s)
        if isinstance(message, Call):
            return self.help.receive(page.role, message, now_s)
        if message in (STOP, DISARM, EMERGENCY):
            self.stops.sent(client, now_s)
        if message is STOP:
            self._press.drop()
        elif message is LET_GO:
            self._press.release(client)
        elif message is DISARM:
            self._disarm(client)
        elif message is EMERGENCY:
            self._press.drop()
            self._order(codes.EMERGENCY_STOP, client)
            self._owner, self._emergency_s = None, now_s
        elif message is RELEASE:
            if client == self._owner:
                self._disarm(client)
        else:
            return self._care(client, page, message, now_s)
        return None

    def _care(
        self, client: int, page: Client, message: PageMessage, now_s: float
    ) -> Refusal | None:
        if page.role != codes.CARETAKER:  # only they may do this
            detail = "only the caretaker may; faults also clear by a 3 s press at the chair"
            return Refusal(what_of(message), "not_allowed", detail)
        if isinstance(message, Take):
            return self._own(client, page, message, now_s)
        if isinstance(message, Reset):
            return self._reset(client, message, now_s)
        if isinstance(message, Cap):
            self.cap_permille = message.permille
        elif isinstance(message, HoldBypass):
            return self._hold_bypass(client, message, now_s)
        elif message is END_BYPASS:
            self._bypass.release(client)
        return None

    def _reset(self, client: int, message: Reset, now_s: float) -> Refusal | None:
        sent_s, fresh = self.tokens.proven(message.proof, now_s)
        # An emergency stop outlasts every reset that was sent before it.
        if not fresh or sent_s < self._emergency_s:
            return Refusal("reset", "stale_token", "the reset was too long on its way")
        self._order(codes.RESET_FAULTS, client)
        return None

    def board(
        self, session: int, state: int, edge: int, now_s: float, override: int = codes.NO_REASON
    ) -> None:
        """The board's report: session (0 = none), codes.DISARMED.., edge it last accepted."""
        self._press.overruled(edge, override)
        if session != self._session:
            self._session = session
            self._press.drop()
        was, self._state = self._state, state
        self._board_edge = edge
        if was == codes.ARMED != state:
            self._press.end()
        # Right after an order to arm, the board may still be completing an earlier disarming.
        if state == codes.DISARMED != was and self._arm_requested_s is None:
            self._owner = None
        self.tick(now_s)

    def tick(self, now_s: float) -> None:
        """Process timeouts: stop a silent owner, end an unanswered order to arm."""
        self._bypass.tick(now_s)
        if self._arm_requested_s is not None and now_s - self._arm_requested_s > ARM_ANSWER_S:
            self._arm_requested_s = None
            if self._state == codes.DISARMED:
                self._press.drop()
                self._owner = None
        owner = None if self._owner is None else self._clients[self._owner]
        self.page_silent = owner is not None and now_s - owner.received_s > self.page_silent_s
        if self.page_silent or self._input_silent(now_s):
            self._press.drop()
        self._press.tick(now_s)

    def _input_silent(self, now_s: float) -> bool:
        # A step that an input began outlives its proof, like a page's, but not its input.
        press = self._press.now
        by = None if press is None else self._clients.get(press.client)
        return by is not None and by.is_input and now_s - by.received_s > self.page_silent_s

    def _received(self, client: int, page: Client, now_s: float, proof: int | None) -> None:
        # An input that keeps repeating an old time counts as dead since then.
        page.received_s = now_s
        if page.is_input and proof is not None:
            page.received_s = self.tokens.proven_s(proof, now_s)
        if client == self._owner:
            self.page_silent = False

    # Driving

    def mode_output(
        self, mode: str, number: int, output: ModeOutput, till_s: float, now_s: float, reached: bool
    ) -> None:
        """The output of `mode` in its press `number`: (linear, turn), None: it has ended.

        `till_s`: when that expires; `reached`: it ended at its goal. Ignored without a live press
        on this mode.
        """
        self.tick(now_s)
        if self.mode_press != (mode, number):
            return
        if output is None:
            self._press.come_to_its_end(reached)
        elif now_s < till_s:
            self._press.steer(*output, min(till_s, now_s + self.ttl_s))

    def _may_drive(self, client: int, page: Client) -> bool:
        # The owner's page, and the inputs of that page's person.
        return client == self._owner or (page.is_input and page.role == self.owner_code)

    def _drive(
        self, client: int, page: Client, message: Drive | UseMode, now_s: float, offered: bool
    ) -> Refusal | None:
        what = what_of(message)
        proven_s, fresh = self.tokens.proven(message.proof, now_s)
        began_s = self._press.began_s(client, message.edge, proven_s)
        if not fresh:
            return Refusal(what, "stale_token", "the command was too long on its way")
        self._received(client, page, now_s, message.proof)
        new = self._press.is_new(client, message.edge)
        if new:
            page.refused.clear()
            self._pressed(client, now_s)
        if not offered or not self._may_drive(client, page):
            reason = "not_armed" if self._owner is None else "not_owner"
            return self._refuse_once(what, page, message.edge, reason if offered else "no_answer")
        if self._session == 0 or self._state != codes.ARMED:
            reason = "not_armed" if self._session else "not_connected"
            return self._refuse_once(what, page, message.edge, reason)
        deadline_s = proven_s + min(self.ttl_s, message.life_s)
        auto = isinstance(message, UseMode) and message.mode in self.auto_modes
        if new and began_s < self.stops.of_others_s(client, presses=auto):
            alive = False
        elif isinstance(message, UseMode):
            alive = self._drive_by(client, page, message, deadline_s, new, now_s)
        elif alive := new:
            self._press.drive(client, message, page.role, deadline_s, self._board_edge)
        else:
            alive = self._press.drive_on(client, message, deadline_s)
        return None if alive else self._refuse_once(what, page, message.edge, "needs_new_command")

    def _pressed(self, client: int, now_s: float) -> None:
        # It ends an auto motion, and one that was pressed before but is longer on its way.
        self._press.pressed()
        self.stops.pressed(client, now_s)

    def _drive_by(
        self, client: int, page: Client, message: UseMode, till_s: float, new: bool, now_s: float
    ) -> bool:
        if new:
            auto, answer_s = message.mode in self.auto_modes, now_s + MODE_ANSWER_S
            till_s = math.inf if auto else till_s
            self._press.drive_by(client, message, page.role, till_s, self._board_edge, answer_s)
            self._press.auto = auto
            self._mode_press += 1
        elif not self._press.drive_by_on(client, message, till_s):
            return False
        # A press proves that its person is present, and so does continuing to press.
        self._press.watch(page.role, self.tokens.proven_s(message.proof, now_s))
        return True

    def _refuse_once(self, what: What, page: Client, edge: int, reason: str) -> Refusal | None:
        # A pressed button repeats all the time; one refusal per press is enough.
        if reason in page.refused:
            return None
        page.refused.add(reason)
        return Refusal(what, reason, f"press {edge} does not move the chair: {reason}")

    def _own(self, client: int, page: Client, message: Arm | Take, now_s: float) -> Refusal | None:
        what = what_of(message)
        if page.is_input:
            return Refusal(what, "not_allowed", "an input drives alongside its person's page")
        if not self.tokens.fresh(message.proof, now_s):
            return Refusal(what, "stale_token", "the request to drive was too long on its way")
        if what == "arm" and self._owner not in (None, client):
            return Refusal(what, "not_owner", "another page drives; it must stop driving first")
        # Armed, the board hands over: it stops, and waits for the new owner's own press.
        self._received(client, page, now_s, None)
        if self._session == 0:
            return Refusal(what, "not_connected", "the board is not connected")
        self._press.drop()
        self._owner = client
        self._arm_requested_s = now_s
        self._order(codes.ARM, client)
        return None

    def _hold_bypass(self, client: int, message: HoldBypass, now_s: float) -> Refusal | None:
        proven_s, fresh = self.tokens.proven(message.proof, now_s)
        if not fresh:
            return Refusal("bypass", "stale_token", "the bypass was too long on its way")
        new = self._bypass.is_new(client, message.edge)
        if new:
            self._pressed(client, now_s)
        return self._bypass.hold(client, message.edge, proven_s + self.ttl_s, new)

    def _disarm(self, client: int) -> None:
        self._press.drop()
        self._order(codes.DISARM, client)
        self._owner = None

    def _order(self, action: int, client: int) -> None:
        self._orders.append((action, self._clients[client].role))
