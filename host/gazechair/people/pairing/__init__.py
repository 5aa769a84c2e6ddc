"""Pairing: one-time codes, paired devices, their roles and their revocation."""

from gazechair.people.pairing.desk import Paired, PairingDesk, Rejected
from gazechair.people.pairing.store import Device, StoreError

__all__ = ["Device", "Paired", "PairingDesk", "Rejected", "StoreError"]
