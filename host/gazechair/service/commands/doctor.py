"""The command `gazechair doctor`."""

from __future__ import annotations

import argparse
from typing import Any

from gazechair.config import configuration


def add(commands: Any) -> None:
    """Add it to argparse's subparsers `commands`."""
    doctor = commands.add_parser("doctor", help="check this machine and say what to do")
    doctor.add_argument("--json", action="store_true", help="print the findings as JSON")
    configuration.add_option(doctor)
    doctor.set_defaults(act=_doctor)


def _doctor(options: argparse.Namespace) -> int:
    from gazechair.service import doctor

    findings = doctor.examine(options.config)
    print(doctor.as_json(findings) if options.json else doctor.as_text(findings))
    return 1 if doctor.failed(findings) else 0
