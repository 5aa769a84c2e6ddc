"""From what people ask to what the board is sent: tokens, presses, the arbiter, control."""
