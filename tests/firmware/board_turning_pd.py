# The PD controller that holds a heading: to the unit, both ways, within its range.

from boardtest import no_allocation, raises
from gazeboard.turning.pd import OUTPUT_MAX, PD, scaled


def test_the_output_is_proportional_and_odd():
    pd = PD(320, 0)  # 20 permille a degree
    for degrees in range(-40, 41):
        assert pd.update(degrees * 16, 0) == degrees * 20
    assert pd.update(2880, 0) == OUTPUT_MAX
    assert pd.update(-2880, 0) == -OUTPUT_MAX


def test_derivative_brakes():
    pd = PD(320, 160)
    assert pd.update(160, 0) == 200
    assert pd.update(160, 160) == 100  # 10 degrees/s towards the setpoint: 10 permille each
    assert pd.update(160, -160) == 300


def test_both_directions_are_rounded_towards_zero():
    for permille in range(-3, 4):
        for rest in (0, 1, 255):
            product = 256 * abs(permille) + rest
            assert scaled(product) == abs(permille)
            assert scaled(-product) == -abs(permille)


def test_the_output_ends_at_full_deflection():
    for sign in (1, -1):
        pd = PD(1600, 0)  # 100 permille a degree
        assert pd.update(sign * 159, 0) == sign * 993
        assert pd.update(sign * 160, 0) == sign * 1000
        assert pd.update(sign * 161, 0) == sign * 1000


def test_a_gain_of_nothing_counts_for_nothing():
    assert PD(0, 0).update(2880, -32768) == 0
    assert PD(0, 160).update(2880, 0) == 0
    assert PD(320, 0).update(0, -32768) == 0


def test_gains_outside_their_range_are_refused():
    for kp_q4, kd_q4 in ((-1, 0), (3201, 0), (0, -1), (0, 3201)):
        assert "is outside 0..3200" in raises(ValueError, lambda: PD(kp_q4, kd_q4))
    PD(3200, 3200)


def test_products_stay_within_31_bits():
    pd = PD(3200, 3200)
    for error in (-2880, 2880):
        for rate in (-32768, 32767):
            no_allocation(lambda: pd.update(error, rate))
