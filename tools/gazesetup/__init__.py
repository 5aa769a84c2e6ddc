"""Prepares a fresh machine to run and test gazechair, with the standard library only."""

from gazesetup.m7 import find_m7
from gazesetup.micropython import MicroPython, ensure_micropython
from gazesetup.mosquitto import ensure_mosquitto
from gazesetup.packages import (
    ensure_chromium,
    ensure_headless_shell,
    ensure_icp_slam,
    ensure_qemu,
    headless_chromium,
)
from gazesetup.paths import LOCAL, ROOT, source_environment
from gazesetup.progress import NotAvailable, note, say
from gazesetup.pypy import ensure_pypy
from gazesetup.venv import ensure_venv, enter_venv, run_module
from gazesetup.wasm import ensure_wasm

__all__ = [
    "LOCAL",
    "ROOT",
    "MicroPython",
    "NotAvailable",
    "ensure_chromium",
    "ensure_headless_shell",
    "ensure_icp_slam",
    "ensure_micropython",
    "ensure_mosquitto",
    "ensure_pypy",
    "ensure_qemu",
    "ensure_venv",
    "ensure_wasm",
    "enter_venv",
    "find_m7",
    "headless_chromium",
    "note",
    "run_module",
    "say",
    "source_environment",
]
