# What the tests of the safety promises share. "Neutral" = both wipers read the stored centre; times
# count from the event on the board.

from gazeboard.boards import bank_layout as at
from gazeboard.boards import pins
from gazelink import codes, messages

ENABLE_AT = at.PINS_AT + pins.ENABLE * at.PIN_SIZE


def fault(rig, bit):
    return rig.app.safety.faults & (1 << bit) != 0


def armed(rig):
    return rig.app.safety.state == codes.ARMED


def toggles(rig, ms):
    # How often the enable line changed its level in the next `ms` ticks.
    count = 0
    level = rig.bank[ENABLE_AT + at.PIN_OUT]
    for _ in range(ms):
        rig.one_ms()
        if rig.bank[ENABLE_AT + at.PIN_OUT] != level:
            level = rig.bank[ENABLE_AT + at.PIN_OUT]
            count += 1
    return count


def stays_still_until_pressed_anew(rig):
    # P14: the press that was interrupted never moves the chair again, a new one does.
    for _ in range(400):
        rig.one_ms()
        assert rig.neutral(), rig.why()
    if not armed(rig):
        rig.release()
        rig.arm()
    rig.press(codes.FORWARD)
    rig.until(lambda: not rig.neutral(), 60)


def ask(rig, request, index=0, value=0, within_ms=5):
    # The board's answer: (value in force, refused).
    rig.reply = None
    rig.send(messages.SETTING, (request, index, value))
    rig.until(lambda: rig.reply is not None, within_ms)
    return rig.reply["value"], rig.reply["refused"]
