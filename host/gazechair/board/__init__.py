"""The host's side of the microcontroller: the serial link, its protocol, state and orders."""
