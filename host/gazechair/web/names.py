"""This machine's names and addresses, for the Host check, the certificate and the address shown."""

from __future__ import annotations

import contextlib
import fcntl
import ipaddress
import socket
import struct

from gazechair.config.settings import WebConfig, is_loopback

_SIOCGIFADDR = 0x8915  # Linux: the IPv4 address of a network interface
_EVERYWHERE = ("0.0.0.0", "::")


def own_names(*configured: str) -> frozenset[str]:
    """Names under which this machine is reached, lower case."""
    host = socket.gethostname().lower()
    return frozenset({"localhost", host, f"{host}.local", *map(str.lower, configured)} - {""})


def network_addresses() -> list[str]:
    """The IPv4 addresses of this machine's networks, loopback not among them."""
    found = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        for _, interface in socket.if_nameindex():
            request = struct.pack("256s", interface.encode()[:15])
            with contextlib.suppress(OSError):  # an interface without an address
                answer = fcntl.ioctl(probe.fileno(), _SIOCGIFADDR, request)
                address = socket.inet_ntoa(answer[20:24])
                if not ipaddress.ip_address(address).is_loopback:
                    found.append(address)
    return found


def certificate_names(web: WebConfig) -> list[str]:
    """The names in the certificate, the main one first."""
    names = [web.name] if web.name else []
    host = socket.gethostname().lower()
    names += [host, f"{host}.local", "localhost", "127.0.0.1"]
    if web.host in _EVERYWHERE:
        names += network_addresses()
    elif not is_loopback(web.host):
        names.append(web.host)
    return list(dict.fromkeys(names))


def shown_host(web: WebConfig) -> str:
    """The host part of the address shown to people, IPv6 in brackets."""
    host = web.name or web.host
    if host in _EVERYWHERE:
        host = next(iter(network_addresses()), "127.0.0.1")
    return f"[{host}]" if ":" in host else host
