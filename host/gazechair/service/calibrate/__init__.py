"""`gazechair calibrate`: the heading sensor on the board; the camera, from a picture and a file."""
