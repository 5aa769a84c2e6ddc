"""`gazechair flash`: puts the firmware on the board, so that it always has a whole one."""

from gazechair.service.flash.command import Flasher
from gazechair.service.flash.errors import FlashError

__all__ = ("FlashError", "Flasher")
