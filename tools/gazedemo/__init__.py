"""The demo: simulator, firmware and host together as a newcomer starts them, and its own check."""
