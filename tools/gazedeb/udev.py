"""udev rules for the chair's devices: permissions and names."""

from __future__ import annotations

from gazechair.board import ports


def rules() -> str:
    """The rules file: one line for each USB device that is a board or a lidar.

    The rules also keep ModemManager from probing a board that has just been plugged in.
    """
    lines = ["# Written by tools/deb from the host's table of USB devices."]
    for vendor, product, role, what in ports.KNOWN:
        if role == ports.OTHER:
            continue
        lines.append(f"# {what}")
        match = ['SUBSYSTEM=="tty"', f'ATTRS{{idVendor}}=="{vendor:04x}"']
        if product is not None:
            match.append(f'ATTRS{{idProduct}}=="{product:04x}"')
        does = [
            'GROUP="dialout"',  # as the advice in ports.PERMIT; the service's user is in it
            'MODE="0660"',
            'ENV{ID_MM_DEVICE_IGNORE}="1"',
            f'SYMLINK+="gazechair/{role}-$env{{ID_SERIAL_SHORT}}"',
        ]
        lines.append(", ".join([*match, *does]))
    return "\n".join(lines) + "\n"
