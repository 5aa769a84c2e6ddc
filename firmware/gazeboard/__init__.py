# Firmware package: safety, motion, turning, devices and the link to the host.
