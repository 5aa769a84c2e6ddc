# Started at power-on. First act, before any other import: enable line off, both wipers neutral
# (P1).
try:
    from machine import I2C, Pin

    Pin("D2", Pin.OUT, value=0)
    try:
        _bus = I2C(0, freq=400000, timeout=300)
        _bus.writeto(0x2C, b"\x00\xaa")
        _bus.writeto(0x2C, b"\x80\xaa")
    except OSError:
        pass  # no answer from the pot: the relay stays open, and the firmware will say so
except ImportError:
    I2C = None  # not a microcontroller: the virtual board does the same first

from gazeboard.app import App

if I2C is None:
    from gazeboard.boards.virtual import from_environment as find_board
else:
    from gazeboard.boards.teensy40 import find_board

board = find_board()
board.run(App(board))
