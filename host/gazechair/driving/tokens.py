"""Tokens: the host computes the age of a page's message by its own clock alone.

Every state carries a token, the host's clock in ms. A page returns one with `since`, the ms its own
clock has counted since the token arrived; `token + since` is the message's proof. Let the token
take `down` ms to the page, stay there for `since`, and let the answer take `up` ms back:

- the page sent at token + down + since: the proof is never later than the moment it stands for,
  so 300 ms from it (promise P3) end no later than 300 ms after the driver's last proof of pressing;
- the age that the host sees is down + up, however long the page kept the token. 100 ms in each
  direction is 200 ms, and leaves a proof 100 ms to live when it arrives, four repeats of a pressed
  button. If the waiting time counted too, ages would vary between 200 and 300 ms, and every second
  proof would be refused;
- a message delayed by a stalled network is as old as the stall, and refused, whenever it arrives;
- of the tokens of the last 500 ms the page uses the least delayed one, so that a picture
  that delays one state does not count against the driver.
"""

from __future__ import annotations

VALID_S = 0.25
_CLOCKS_DIFFER_MS = 2  # a page's clock may be this far ahead after 500 ms


class Tokens:
    """Issues tokens and judges proofs. All times are monotonic seconds."""

    def __init__(self, first_token: int = 0) -> None:
        """Tokens of an earlier host must not be near: draw `first_token` at random."""
        self._first_token = first_token

    def token(self, now_s: float) -> int:
        """The token of this moment."""
        return self._first_token + int(now_s * 1000)

    def fresh(self, proof: int | None, now_s: float) -> bool:
        """True for a proof at most 250 ms old. One ahead of the host's clock is forged."""
        if proof is None:
            return False
        return -_CLOCKS_DIFFER_MS <= self.token(now_s) - proof <= VALID_S * 1000

    def proven(self, proof: int, now_s: float) -> tuple[float, bool]:
        """The moment that `proof` stands for, and whether it is fresh."""
        return self.proven_s(proof, now_s), self.fresh(proof, now_s)

    def proven_s(self, proof: int, now_s: float) -> float:
        """The moment that `proof` stands for, never later than `now_s`."""
        age_ms = max(0, self.token(now_s) - proof)
        return now_s - age_ms / 1000
