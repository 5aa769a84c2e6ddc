"""The microcontroller as the host knows it: the serial link, its protocol, state and orders."""
