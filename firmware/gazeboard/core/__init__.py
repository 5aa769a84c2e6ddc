# Safety core: decides, 1000 times a second, whether and how the chair moves. Pure: no devices.
