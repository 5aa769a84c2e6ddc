"""`gazechair flash`: installs the firmware so that the board always has a complete one."""

from gazechair.service.flash.command import Flasher
from gazechair.service.flash.errors import FlashError

__all__ = ("FlashError", "Flasher")
