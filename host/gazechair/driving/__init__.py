"""From the pages' requests to the command for the board: tokens, presses, arbiter, control."""
