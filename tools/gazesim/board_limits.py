"""What a board of this firmware reports as its limits, for tools without a connected board."""

from gazeboard.core import limits
from gazechair.board.state import BoardLimits

LIMITS = BoardLimits(
    limits.COMMAND_TTL_MS,
    limits.AUTO_TTL_MS,
    limits.CLEARANCE_OLD_MS,
    limits.WIPER_MIN,
    limits.WIPER_MAX,
    limits.WIPER_SPAN,
)
