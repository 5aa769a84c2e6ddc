"""Host daemon and `gazechair` command: board link, sensors, odometry, maps, auto motions, pages."""

import logging
import os

# Before numpy: its helper threads wait by spinning, on the cores that the chair's processes need.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Commands print their results; only the daemon shows what its parts log.
logging.getLogger(__name__).addHandler(logging.NullHandler())
