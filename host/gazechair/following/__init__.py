"""Follows a person: legs in scans, who is followed, and the request that keeps behind them."""
