"""One-time codes: short enough to type with the eyes, invalid after one use or a few minutes."""

from __future__ import annotations

import hashlib
import secrets
from dataclasses import dataclass

# 30 characters that are hard to confuse: no 0 and O, no 1, I and L, no U. 8 of them are 39 bits.
ALPHABET = "23456789ABCDEFGHJKMNPQRSTVWXYZ"
LENGTH = 8
VALID_S = 600.0
MOST_OPEN = 4


@dataclass(frozen=True)
class OneTimeCode:
    """A code as shown to people, XXXX-XXXX."""

    text: str
    role: str
    ends_s: float
    """Monotonic time after which it is worthless."""


class OneTimeCodes:
    """The codes that are open. Not thread-safe; times are monotonic seconds.

    Only digests are stored, so that a lookup takes no longer for an almost right guess.
    """

    def __init__(self) -> None:
        self._open: dict[bytes, OneTimeCode] = {}

    def new(self, role: str, now_s: float, valid_s: float = VALID_S) -> OneTimeCode:
        """A new code for a device of `role`. Closes the oldest if too many are open."""
        self._close_old(now_s)
        while len(self._open) >= MOST_OPEN:
            del self._open[next(iter(self._open))]
        signs = "".join(secrets.choice(ALPHABET) for _ in range(LENGTH))
        code = OneTimeCode(f"{signs[:4]}-{signs[4:]}", role, now_s + valid_s)
        self._open[_digest(code.text)] = code
        return code

    def is_open(self, text: str, now_s: float) -> bool:
        """True while the code could still be used."""
        self._close_old(now_s)
        return _digest(text) in self._open

    def find(self, text: str, now_s: float) -> OneTimeCode | None:
        """The open code; None for a wrong, used or late one."""
        self._close_old(now_s)
        return self._open.get(_digest(text))

    def use(self, code: OneTimeCode) -> None:
        """Mark the code as used."""
        self._open.pop(_digest(code.text), None)

    def _close_old(self, now_s: float) -> None:
        self._open = {digest: code for digest, code in self._open.items() if code.ends_s > now_s}


def _digest(text: str) -> bytes:
    signs = "".join(sign for sign in text.upper() if sign.isalnum())
    return hashlib.sha256(signs.encode()).digest()
