"""The simulator: a chair in a room with every device, down to registers and bytes."""
