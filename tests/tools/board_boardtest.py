# The tests' own tools: what no_allocation() and raises() must catch.

from boardtest import HAS_NATIVE, no_allocation, raises

_buffer = bytearray(8)


def _index():
    _buffer[3] = _buffer[2] + 1 & 0xFF


def _make_list():
    return [1]


def _make_float():
    return len(_buffer) / 3


def _raise():
    try:
        raise ValueError
    except ValueError:
        pass


def test_plain_arithmetic_on_a_buffer_passes():
    no_allocation(_index)


def test_every_kind_of_allocation_is_caught():
    for call in (_make_list, _make_float, _raise):
        if HAS_NATIVE:
            assert "allocates" in raises(AssertionError, no_allocation, call)
        else:
            no_allocation(call)


def test_raises_gives_the_text():
    def refuse(text):
        raise ValueError(text)

    assert raises(ValueError, refuse, "why") == "why"


def test_raises_fails_when_nothing_is_raised():
    assert "ValueError not raised" in raises(AssertionError, raises, ValueError, _index)
