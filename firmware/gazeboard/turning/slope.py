# Estimate of the floor's slope, which turns a moving chair in either direction.
#
# Learned within a turn and discarded after it, because the slope differs at another heading.
# Integers, no allocation.

from gazelink.const import const
from gazelink.native import micropython

_SAMPLE_MS = const(10)
_MOVING_Q10 = const(512)  # slower than half a degree/s the brakes hold it
_MOST_Q8 = const(400)  # degrees/s; a floor hardly slopes more


class Slope:
    # model: a ChairModel. drift_q8: the slope's effect, 1/256 degree/s, left positive; slides_q8
    # and slides_braked_q8: how far until the chair stands, released or by counter-deflection.

    def __init__(self, model):
        self._model = model
        self.start()

    @micropython.native
    def start(self):
        self.drift_q8 = 0
        self.slides_q8 = 0
        self.slides_braked_q8 = 0
        self._moved_ms = 0

    # A sample. rest_q8: what neither the model nor the casters explain since the start, while the
    # model turned way_q4. The slope and a wrong gain share it by how likely either is to have done
    # it (standard deviations 0.8 degrees/s, 6.4 %; noise 0.3 degrees).
    @micropython.native
    def learn(self, rest_q8, way_q4, rate_q10):
        if not -_MOVING_Q10 < rate_q10 < _MOVING_Q10:
            self._moved_ms += _SAMPLE_MS
        time = self._moved_ms // 100
        drift_q8 = (rest_q8 >> 4) * time * 160 // (time * time + way_q4 * way_q4 // 400 + 14)
        self.drift_q8 = max(-_MOST_Q8, min(_MOST_Q8, drift_q8))

    # How far that turns it until it stands. way_q8: how far the model still turns after release;
    # the rate then falls to what the brakes stop in some halvings.
    @micropython.native
    def look_ahead(self, way_q8):
        lag_ms = self._model.lag_ms
        dead_ms = self._model.dead_ms
        rate = abs(way_q8) * 8 // (lag_ms + dead_ms)  # half degrees/s
        slides_ms = 0
        if rate:
            slides_ms = dead_ms + (lag_ms >> 1)
            while rate > 1:
                rate >>= 1
                slides_ms += (lag_ms * 11) >> 4
        self.slides_q8 = self.drift_q8 * slides_ms // 1000
        braked_ms = dead_ms + lag_ms + (lag_ms >> 1)
        self.slides_braked_q8 = self.drift_q8 * min(slides_ms, braked_ms) // 1000
