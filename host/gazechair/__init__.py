"""The host daemon and the `gazechair` command: serial link, lidar, camera, arbiter, web server."""

import logging

# Commands print their results; only the daemon shows what its parts log.
logging.getLogger(__name__).addHandler(logging.NullHandler())
