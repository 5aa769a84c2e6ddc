"""Guessing codes: locked out by address, and limited for all addresses together. Injected time.

A right code is 1 of 30**8 = 6.6e11. An address has 5 guesses, then waits 1 min, 2, 4, ... 15 min
after each further one; all addresses together have 10 at once and then one every 2 s. While a code
is open (10 min) that is 310 guesses at most: with 4 open codes a chance of 2e-9. 10,000 guesses
take over 5 hours, while a code lives 10 minutes. Paired devices never come here.
"""

from __future__ import annotations

import ipaddress
from collections import OrderedDict
from dataclasses import dataclass

from gazechair.rate_limit import RateLimit

FREE_GUESSES = 5
_FIRST_WAIT_S = 60.0
_LONGEST_WAIT_S = 900.0
_FORGET_S = 3600.0
_ALL_PER_S = 0.5
_ALL_BURST = 10
_MOST_ADDRESSES = 1000


@dataclass
class _Address:
    wrong: int
    until_s: float
    last_s: float


class Lockout:
    """Not thread-safe; times are monotonic seconds."""

    def __init__(self) -> None:
        self._addresses: OrderedDict[str, _Address] = OrderedDict()
        self._all = RateLimit(_ALL_PER_S, _ALL_BURST)

    def wait_s(self, address: str, now_s: float) -> float:
        """0 when a guess from `address` may be looked at, else how long it must wait.

        Looking takes one of the guesses that all addresses share.
        """
        entry = self._addresses.get(_group(address))
        if entry is not None and now_s < entry.until_s:
            return entry.until_s - now_s
        return 0.0 if self._all.allow(now_s) else 1.0 / _ALL_PER_S

    def wrong(self, address: str, now_s: float) -> None:
        """The guess was wrong."""
        group = _group(address)
        entry = self._addresses.pop(group, None)
        if entry is None or now_s - entry.last_s > _FORGET_S:
            entry = _Address(0, 0.0, now_s)
        entry.wrong += 1
        entry.last_s = now_s
        if entry.wrong >= FREE_GUESSES:
            doublings = min(entry.wrong - FREE_GUESSES, 10)
            entry.until_s = now_s + min(_FIRST_WAIT_S * 2**doublings, _LONGEST_WAIT_S)
        self._addresses[group] = entry
        while len(self._addresses) > _MOST_ADDRESSES:
            self._addresses.popitem(last=False)

    def right(self, address: str) -> None:
        """The guess was right: its address begins anew."""
        self._addresses.pop(_group(address), None)


def _group(address: str) -> str:
    # Whoever has one IPv6 address has 2**64 of them.
    try:
        ip = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    if ip.version == 6:
        mapped = ip.ipv4_mapped
        return str(mapped) if mapped else str(ipaddress.ip_network((ip, 64), strict=False))
    return str(ip)
