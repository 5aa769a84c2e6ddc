# The feedback controllers P, PI, PD, PID: to the unit, both ways, within their range.

from boardtest import no_allocation, raises
from gazeboard.turning.pid import OUTPUT_MAX, PD, PI, PID, P, scaled


def test_p_is_proportional_and_odd():
    p = P(320)  # 20 permille a degree
    for degrees in range(-40, 41):
        assert p.update(degrees * 16, 0, 1) == degrees * 20
    assert p.update(2880, 0, 1) == OUTPUT_MAX
    assert p.update(-2880, 0, 1) == -OUTPUT_MAX


def test_pi_removes_what_p_leaves_and_reset_forgets():
    pi = PI(160, 160)  # 10 permille a degree, 10 more a second
    for _ in range(1000):
        out = pi.update(160, 0, 1)
    assert 195 <= out <= 205  # 10 degrees: 100 by P, 100 by I after one second
    pi.reset()
    assert pi.update(160, 0, 1) == 100


def test_integral_does_not_wind_up():
    pi = PI(3200, 3200)
    for _ in range(100000):
        pi.update(2880, 0, 1)
    ms = 0
    while pi.update(-16, 0, 1) > 0:
        ms += 1
        assert ms < 100


def test_derivative_brakes():
    pd = PD(320, 160)
    assert pd.update(160, 0, 1) == 200
    assert pd.update(160, 160, 1) == 100  # 10 degrees/s towards the setpoint: 10 permille each


def test_both_directions_are_rounded_towards_zero():
    for permille in range(-3, 4):
        for rest in (0, 1, 255):
            product = 256 * abs(permille) + rest
            assert scaled(product) == abs(permille)
            assert scaled(-product) == -abs(permille)


def test_the_output_ends_at_full_deflection():
    for sign in (1, -1):
        p = P(1600)  # 100 permille a degree
        assert p.update(sign * 159, 0, 1) == sign * 993
        assert p.update(sign * 160, 0, 1) == sign * 1000
        assert p.update(sign * 161, 0, 1) == sign * 1000


def test_what_a_controller_lacks_counts_for_nothing():
    assert P(0).update(0, -32768, 1) == 0
    assert PI(0, 160).update(0, -32768, 1) == 0
    pd = PD(0, 160)
    for _ in range(100):
        assert pd.update(2880, 0, 10) == 0


def test_the_integral_is_of_error_and_time():
    # 1 permille/(degree s), 1 degree: a permille in exactly a second, however it is sampled.
    for dt_ms in (1, 2, 10):
        pi = PI(0, 16)
        for ms in range(dt_ms, 3001, dt_ms):
            assert pi.update(16, 0, dt_ms) == ms // 1000


def test_the_integral_begins_at_nothing():
    # A permille is 256000 units.
    pi = PI(0, 1)
    for _ in range(2):
        assert pi.update(0, 0, 1) == 0, "not below"
        for _ in range(8):
            pi.update(2880, 0, 10)
        pi.update(2559, 0, 10)
        assert pi.update(9, 0, 1) == 0, "one unit short"
        assert pi.update(1, 0, 1) == 1
        pi.reset()


def test_the_integral_alone_may_be_full_deflection_and_no_more():
    for sign in (1, -1):
        pid = PID(0, 3200, 160)  # damped by 600 permille
        for _ in range(1000):
            pid.update(sign * 2880, sign * 960, 10)
        assert pid.update(0, sign * 960, 10) == sign * 400
        assert pid.update(0, sign * 480, 10) == sign * 700


def test_nothing_is_added_while_the_output_is_full():
    for sign in (1, -1):
        pid = PID(3200, 16, 0)
        for _ in range(100):
            assert pid.update(sign * 80, 0, 10) == sign * 1000
        assert pid.update(0, 0, 10) == 0
    # Full by both together: 900 from the rate, 10 degrees * 10 permille a second.
    for sign in (1, -1):
        pid = PID(0, 160, 160)
        for _ in range(300):
            pid.update(sign * 160, -sign * 1440, 10)
        assert 99 <= sign * pid.update(0, 0, 10) <= 100
    # A last unit neither: 999 is what the integral alone comes to.
    pid = PID(0, 3200, 0)
    for _ in range(1000):
        assert pid.update(8, 0, 10) <= 999
    for _ in range(100):
        assert pid.update(1, 0, 10) == 999


def test_a_full_output_lets_the_integral_go_back():
    for sign in (1, -1):
        pid = PID(0, 160, 160)
        for _ in range(500):
            pid.update(sign * 160, 0, 10)
        assert 499 <= sign * pid.update(0, 0, 10) <= 501
        for _ in range(300):  # back by 300 permille, while the rate alone makes it full
            assert pid.update(-sign * 160, -sign * 1600, 10) == sign * 1000
        assert 199 <= sign * pid.update(0, 0, 10) <= 201


def test_gains_outside_their_range_are_refused():
    for make in (lambda: PID(-1, 0, 0), lambda: PID(0, 3201, 0), lambda: PID(0, 0, 9999)):
        assert "is outside 0..3200" in raises(ValueError, make)


def test_products_stay_within_31_bits():
    pid = PID(3200, 3200, 3200)
    for error in (-2880, 2880):
        for rate in (-32768, 32767):
            for _ in range(3):
                no_allocation(lambda: pid.update(error, rate, 10))
