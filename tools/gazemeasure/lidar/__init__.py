"""A lidar simulated for the other benchmarks: its bytes, its process, its damage."""
