"""Who may talk to this chair: one-time codes, paired devices, their roles and their revocation."""

from gazechair.pairing.desk import Paired, PairingDesk, Rejected
from gazechair.pairing.store import Device, StoreError

__all__ = ["Device", "Paired", "PairingDesk", "Rejected", "StoreError"]
