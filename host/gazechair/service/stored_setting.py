"""A setting of the board put in force and in its flash, or in neither."""

from __future__ import annotations

from gazechair.service.board_settings import BoardSettings, SettingsError, may_be_done


def store(board: BoardSettings, index: int, value: int) -> None:
    """Set and save; raises SettingsError, after what was in force before is so again."""
    before, saving = board.get(index), False
    try:
        board.set(index, value)
        saving = True
        board.save({index: value})
    except SettingsError as error:
        board.set(index, before)
        if saving and may_be_done(error):
            board.save({index: before})
        raise
