"""The simulator: a chair in a room, and each device of it, down to registers and bytes."""
