"""A lidar's bytes and process, for the other benchmarks."""
