"""The board's reports, decoded from the message table: its state, statistics and identity."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from gazelink import codes
from gazelink.settings_table import PROFILES, profile_row


@dataclass(frozen=True)
class BoardLimits:
    """What is compiled into the board, by the names of its LIMITS frame."""

    command_ttl_ms: int
    auto_ttl_ms: int
    clearance_old_ms: int
    wiper_min: int
    wiper_max: int
    wiper_span: int


@dataclass(frozen=True)
class BoardId:
    """Who answered the handshake."""

    name: str
    version: str
    """ "major.minor.patch" of its firmware."""
    simulated: bool
    boot: int
    """Drawn by the board at each reset, 0..65535."""
    session: int
    """Chosen by this host, 1..65535."""
    limits: BoardLimits


@dataclass(frozen=True)
class BoardState:
    """One STATE frame and what is known with it.

    Numbers are as in gazelink.codes, in words by the `..._name` properties.
    """

    state: int
    motion: int
    override: int
    """Why the present command is overruled; 0 = it is not."""
    arm_reason: int
    """What prevents arming; 0 = ready."""
    first_fault: int
    faults: int
    """Bit set, bits of codes.FAULTS."""
    heading_deg: float
    """0..360, counter-clockwise positive; meaningless while a heading fault is set."""
    linear_permille: int
    """What the board puts out, of full deflection: forward positive, 0 = neutral."""
    turn_permille: int
    """The same, left positive."""
    edge: int
    """Edge of the command the board last accepted, 1..255; 0 = none yet."""
    decisions: int
    """2 bits per direction."""
    board_ms: int
    """The board's tick clock, modulo 65536."""
    received_s: float
    """Monotonic time of arrival."""
    relay_checked: bool = False
    """The board has reported that it monitors its safety relay; see relay."""
    settings: Mapping[str, int] = field(default_factory=dict)
    """The settings in force that the host goes by, as far as known; see known_settings."""

    @property
    def state_name(self) -> str:
        """One of codes.STATES."""
        return name_of(codes.STATES, self.state)

    @property
    def motion_name(self) -> str:
        """One of codes.MOTIONS."""
        return name_of(codes.MOTIONS, self.motion)

    @property
    def override_name(self) -> str:
        """Name of the reason, "none" when nothing is overruled."""
        return str(codes.reason_name(self.override))

    @property
    def arm_reason_name(self) -> str:
        """Name of what prevents arming, "none" when nothing does."""
        return str(codes.reason_name(self.arm_reason))

    @property
    def decision_names(self) -> dict[str, str]:
        """{direction: one of codes.DECISIONS}."""
        return {
            direction: codes.DECISIONS[(self.decisions >> (2 * at)) & 3]
            for at, direction in enumerate(codes.DIRECTIONS)
        }

    @property
    def profile(self) -> str | None:
        """The selected speed profile, one of settings_table.PROFILES; None: not known."""
        row = self.settings.get("profile", len(PROFILES))
        return PROFILES[row] if row < len(PROFILES) else None

    @property
    def tuned(self) -> bool | None:
        """Whether the selected speed profile is tuned; None: not known."""
        if self.profile is None:
            return None
        tuned = self.settings.get(profile_row(self.settings["profile"], "tuned"))
        return None if tuned is None else tuned != 0

    @property
    def step_deg(self) -> float | None:
        """How far a step turn goes; None: not known."""
        step_q4_deg = self.settings.get("step_turn_q4_deg")
        return None if step_q4_deg is None else step_q4_deg / 16

    @property
    def heading_known(self) -> bool:
        """False while the board reports any fault of the heading."""
        return not self.faults & codes.HEADING_FAULTS


@dataclass(frozen=True)
class BoardStats:
    """One STATS frame: counters by the names of the message table."""

    counters: dict[str, int]
    received_s: float


def name_of(names: tuple[str, ...], number: int) -> str:
    """names[number], or "unknown_<number>" from a newer board."""
    return names[number] if number < len(names) else f"unknown_{number}"
