# The board's devices: line to the host, heading sensor, potentiometer, files.
