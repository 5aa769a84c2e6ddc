"""Tokens: how the host knows, by its own clock alone, how old a page's message is.

Every state carries a token, the host's clock in ms. A page echoes one with `since`, the ms its own
clock has counted since the token arrived; `token + since` is the message's proof. Be the token
`down` ms on its way to the page, kept there for `since`, and the answer `up` ms on its way back:

- the page spoke at token + down + since: the proof is never later than the moment it stands for,
  so 300 ms from it (promise P3) end no later than 300 ms after the driver's last proof of holding;
- the age that the host sees is down + up, however long the page kept the token. 100 ms each way is
  200 ms, and leaves a proof 100 ms to live when it arrives, four repeats of a held button long.
  Were the waiting counted too, ages would swing between 200 and 300 ms, and every second proof
  would be refused;
- what a stalled network held back is as old as the stall, and refused, whenever it arrives;
- of the tokens of the last 500 ms the page uses the one that was delayed least, so that a picture
  in the way of one state does not count against the driver.
"""

from __future__ import annotations

VALID_S = 0.25
TTL_S = 0.3
_CLOCKS_DIFFER_MS = 2  # a page's clock may be this far ahead after 500 ms


class Freshness:
    """Issues tokens and judges proofs. All times are monotonic seconds."""

    def __init__(self, first_token: int = 0) -> None:
        """Tokens of another host's life should not be near: draw `first_token` at random."""
        self._first_token = first_token

    def token(self, now_s: float) -> int:
        """The token of this moment."""
        return self._first_token + int(now_s * 1000)

    def fresh(self, proof: int | None, now_s: float) -> bool:
        """True for a proof at most 250 ms old. One that is ahead of the host's clock is made up."""
        if proof is None:
            return False
        return -_CLOCKS_DIFFER_MS <= self.token(now_s) - proof <= VALID_S * 1000

    def deadline_s(self, proof: int, now_s: float) -> float:
        """When what was proven by `proof` has to end."""
        age_ms = max(0, self.token(now_s) - proof)
        return now_s + TTL_S - age_ms / 1000
