# The estimate of the floor's slope: what it makes of a deviation, and how far that slides.

from gazeboard.turning.slope import Slope

_FAST_Q10 = 20 << 10


class Model:
    def __init__(self, lag_ms, dead_ms):
        self.lag_ms = lag_ms
        self.dead_ms = dead_ms


# A slope after so many samples of a chair that turns.
def moved(samples, rate_q10=_FAST_Q10):
    slope = Slope(Model(320, 200))
    for _ in range(samples):
        slope.learn(0, 0, rate_q10)
    return slope


def test_nothing_is_known_at_the_start_of_a_turn():
    slope = Slope(Model(320, 200))
    for _ in range(2):
        assert (slope.drift_q8, slope.slides_q8, slope.slides_braked_q8) == (0, 0, 0)
        slope.learn(4096, 0, 0)
        assert slope.drift_q8 == 0, "it has not moved yet"
        for _ in range(100):
            slope.learn(512, 0, _FAST_Q10)
        slope.look_ahead(5000)
        assert slope.drift_q8 > 0 and slope.slides_q8 > 0 and slope.slides_braked_q8 > 0
        slope.start()


def test_time_passes_while_the_chair_turns_at_half_a_degree_a_second():
    # 9 samples more make a tenth of a second of 10, not of 9 or of samples at rest.
    for rate_q10, counts in ((512, True), (-512, True), (511, False), (-511, False), (0, False)):
        slope = moved(9, rate_q10)
        slope.learn(1600, 0, 0)
        assert slope.drift_q8 == 0
        slope.learn(1600, 0, rate_q10)
        assert (slope.drift_q8 > 0) == counts, rate_q10
    slope = moved(99)
    slope.learn(256, 0, 0)
    assert slope.drift_q8 == 16 * 9 * 160 // (81 + 14), "0.9 s"
    slope.learn(256, 0, _FAST_Q10)
    assert slope.drift_q8 == 16 * 10 * 160 // (100 + 14), "1 s"


def test_the_slope_and_a_wrong_gain_share_the_deviation():
    # Of a deviation r in t seconds and over the way w, the likeliest slope is
    # r t / (t^2 + (0.064 / 0.8)^2 w^2 + (0.3 / 0.8)^2): degrees, rounded down to 1/256.
    for samples in (10, 30, 200):
        tenths = samples // 10
        slope = moved(samples)
        for way_q4 in (0, 19, 20, 160, -160, 720, 2879, -2880):
            # Hundredths of a square second; the way's share in whole ones.
            all_of_it = tenths * tenths + (way_q4 * way_q4) // 400 + 14
            for drift_q8 in (-360, -100, -1, 0, 1, 99, 360):
                # The deviation, 1/16 degree, from which on it is as much.
                least_q4 = -(-drift_q8 * all_of_it // (160 * tenths))
                for rest_q4 in (least_q4 - 1, least_q4, least_q4 + 1):
                    slope.learn(rest_q4 * 16 + 15, way_q4, 0)
                    share = rest_q4 * 160 * tenths
                    assert slope.drift_q8 * all_of_it <= share, (samples, way_q4, rest_q4)
                    assert (slope.drift_q8 + 1) * all_of_it > share, (samples, way_q4, rest_q4)


def test_no_floor_slopes_by_more():
    for rest_q8, drift_q8 in ((46080, 400), (-46080, -400)):
        slope = moved(50)
        slope.learn(rest_q8, 0, _FAST_Q10)
        assert slope.drift_q8 == drift_q8


def test_it_slides_until_the_rate_is_below_half_a_degree_a_second():
    # At 1000 the way is the time in ms.
    for lag_ms, dead_ms, half_ms, halves_ms in ((320, 200, 160, 220), (700, 300, 350, 481)):
        slope = Slope(Model(lag_ms, dead_ms))
        all_ms = lag_ms + dead_ms
        for sign in (1, -1):
            slope.drift_q8 = sign * 1000
            for halvings in range(9):
                # The way from which on the rate is 2^halvings half degrees/s.
                way_q8 = -(-(all_ms << halvings) // 8)
                slides_ms = dead_ms + half_ms + halvings * halves_ms
                braked_ms = min(slides_ms, all_ms + half_ms)
                before_ms = slides_ms - halves_ms if halvings else 0
                for side in (1, -1):
                    slope.look_ahead(side * way_q8)
                    assert slope.slides_q8 == sign * slides_ms
                    assert slope.slides_braked_q8 == sign * braked_ms
                    slope.look_ahead(side * (way_q8 - 1))
                    assert slope.slides_q8 == sign * before_ms
