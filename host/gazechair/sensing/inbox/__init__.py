"""The inbox of every process that uses scans: half turns, the board's reports, estimates."""
