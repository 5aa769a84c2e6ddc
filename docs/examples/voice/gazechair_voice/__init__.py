"""An input of gazechair: spoken words, recognised offline on this machine."""
