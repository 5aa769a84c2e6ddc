"""The demo: simulator, firmware and host started together, with its own check."""
