# What is flashed: safety, motion, control, devices and link of the board.
