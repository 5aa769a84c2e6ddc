"""Files that the calibration puts on the board: Adafruit's installed driver, and the program."""

from __future__ import annotations

import importlib.util
from pathlib import Path

from gazechair.commissioning.calibrate.errors import CalibrateError

# Module -> path on the board: what adafruit_bno055 imports over I2C, and no more.
_DRIVER = {
    "adafruit_bno055": "adafruit_bno055.py",
    "adafruit_bus_device": "adafruit_bus_device/__init__.py",
    "adafruit_bus_device.i2c_device": "adafruit_bus_device/i2c_device.py",
    "adafruit_register": "adafruit_register/__init__.py",
    "adafruit_register.i2c_struct": "adafruit_register/i2c_struct.py",
}
PROGRAM = "board_program"


def driver_files() -> dict[str, bytes]:
    """Path within a folder on the board -> content, unmodified.

    Raises CalibrateError when a package is not installed.
    """
    files = {}
    for module, path in _DRIVER.items():
        try:
            spec = importlib.util.find_spec(module)
        except ModuleNotFoundError:  # of the package that it is in
            spec = None
        if spec is None or spec.origin is None:
            raise CalibrateError(
                f"Adafruit's {module} is not installed; run `pip install 'gazechair[bench]'`"
            )
        files[path] = Path(spec.origin).read_bytes()
    files[f"{PROGRAM}.py"] = Path(__file__).with_name(f"{PROGRAM}.py").read_bytes()
    return files
