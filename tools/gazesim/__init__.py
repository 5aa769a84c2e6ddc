"""The simulator: a chair in a room with every device, down to registers and bytes.

The virtual chair comes in four depths, each with what the one before leaves out:
core_rig    the board's core alone, inputs set by hand (runs on MicroPython too)
board_rig   the whole firmware, scripted devices and a small host (runs on MicroPython too)
chair_rig   the whole firmware from main.py on, USB line, devices, chair and room; a host's link
simulator   all of it as processes in real time
"""
