"""Pairing: a device gets a role by a one-time code, until that is revoked."""

from gazechair.people.pairing.desk import Paired, PairingDesk, Rejected
from gazechair.people.pairing.store import Device, StoreError

__all__ = ["Device", "Paired", "PairingDesk", "Rejected", "StoreError"]
