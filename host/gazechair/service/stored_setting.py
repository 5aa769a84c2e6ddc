"""A setting of the board put in force and in its flash, or in neither."""

from __future__ import annotations

from gazechair.service.board_settings import BoardSettings, SettingsError


def store(board: BoardSettings, index: int, value: int) -> None:
    """Set and save; raises SettingsError, after what was in force before is so again."""
    before, saving = board.get(index), False
    try:
        board.set(index, value)
        saving = True
        board.save()
    except SettingsError:
        board.set(index, before)
        if saving:  # an earlier try may be in the flash, and only its answer was lost
            board.save()
        raise
