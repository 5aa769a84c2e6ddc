"""Slows down guessing of codes: after a few wrong ones each guess from an address waits a second.

Time is injected. A right code is never locked out: it is checked a second after its first attempt,
whatever others guess, even from the same address. So guessing is slowed, not locked; a code's
length protects it. It is 1 of 30**8 = 6.6e11; strangers get a quarter of a processor for all their
requests (gazechair.web.processor_share), which is under 1000 guesses a second. For all of a code's
10 minutes that is 600,000 guesses: with 4 open codes a chance of 4e-6. Paired devices are not
checked here.
"""

from __future__ import annotations

import hashlib
import ipaddress
from collections import OrderedDict
from dataclasses import dataclass

FREE_GUESSES = 5
WAIT_S = 1.0
_FORGET_S = 3600.0
_MOST_ADDRESSES = 1000
_MOST_REQUESTS = 5000  # more than can arrive in WAIT_S


@dataclass
class _Address:
    wrong: int
    last_s: float


class Lockout:
    """Not thread-safe; times are monotonic seconds."""

    def __init__(self) -> None:
        self._addresses: OrderedDict[str, _Address] = OrderedDict()
        self._requests: OrderedDict[bytes, float] = OrderedDict()  # when it may be checked

    def wait_s(self, address: str, code: str, now_s: float) -> float:
        """0 when `code` from `address` may be checked now, else the seconds until it may."""
        entry = self._addresses.get(_group(address))
        if entry is None or entry.wrong < FREE_GUESSES or now_s - entry.last_s > _FORGET_S:
            return 0.0
        request = hashlib.sha256(f"{_group(address)} {code}".encode("utf-8", "replace")).digest()
        due_s = self._requests.setdefault(request, now_s + WAIT_S)
        if now_s >= due_s:
            del self._requests[request]
            return 0.0
        while len(self._requests) > _MOST_REQUESTS:
            self._requests.popitem(last=False)
        return due_s - now_s

    def wrong(self, address: str, now_s: float) -> None:
        """The guess was wrong."""
        group = _group(address)
        entry = self._addresses.pop(group, None)
        if entry is None or now_s - entry.last_s > _FORGET_S:
            entry = _Address(0, now_s)
        entry.wrong += 1
        entry.last_s = now_s
        self._addresses[group] = entry
        while len(self._addresses) > _MOST_ADDRESSES:
            self._addresses.popitem(last=False)

    def right(self, address: str) -> None:
        """The guess was right: the count of its address restarts."""
        self._addresses.pop(_group(address), None)


def _group(address: str) -> str:
    # An attacker with one IPv6 address has 2**64 of them.
    try:
        ip = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    if ip.version == 6:
        mapped = ip.ipv4_mapped
        return str(mapped) if mapped else str(ipaddress.ip_network((ip, 64), strict=False))
    return str(ip)
