# The program that the board starts at power-on.
# First, before any other import: enable line off, both wipers neutral (promise P1).
try:
    from machine import I2C, Pin

    Pin("D2", Pin.OUT, value=0)
    try:
        _bus = I2C(0, freq=400000, timeout=300)
        _bus.writeto(0x2C, b"\x00\xaa")
        _bus.writeto(0x2C, b"\x80\xaa")
    except OSError:
        pass  # no answer from the pot: the relay stays open, and the firmware reports it
    from micropython import kbd_intr

    # The button at the chair pressed at power-on: the plain REPL, for a firmware that hangs below.
    # SystemExit would be a soft reset, which starts this file again and again.
    if Pin("D5", Pin.IN, Pin.PULL_UP).value() == 0:
        raise RuntimeError("button pressed at power-on: no firmware, MicroPython's REPL")
    # A host that is already talking sends byte 3 in every frame: no Ctrl-C, or it ends us here.
    kbd_intr(-1)
except ImportError:
    I2C = None  # not a microcontroller: the virtual board does the same first

from gazeboard.app import App
from gazeboard.io import bootlog
from gazelink import codes

if I2C is None:
    from gazeboard.boards.virtual import from_environment as find_board
else:
    from gazeboard.boards.teensy40 import Teensy40 as find_board


def main():
    board = find_board()
    damaged = bootlog.damaged(board)
    refusal = codes.NO_REASON
    if not board.hard_timer:
        refusal = codes.NO_HARD_TIMER
        words = "needs MicroPython 1.27 or newer"
    elif bootlog.watchdog_boots(board) >= bootlog.LIMIT:
        # It hangs at every start: enable off, and the REPL for a person to examine it.
        refusal = codes.WATCHDOG_BOOTS
        words = "3 watchdog resets: REPL"
    if refusal:
        ended = bootlog.last_words(board, codes.FAULT_REASON + refusal, words)
        if ended != bootlog.CLEARED or refusal != codes.WATCHDOG_BOOTS:
            board.open_repl()
            return
        bootlog.forget(board)
    try:
        board.run(App(board, 1 << codes.STORAGE if damaged else 0))
    except Exception as error:
        bootlog.send_fault(
            board,
            codes.FAULT_REASON + codes.SERVICE_STALLED,
            "%s: %s" % (type(error).__name__, error),
        )
        raise


main()
