"""First drive: leads a caretaker with a phone from a freshly flashed board to a driving chair."""
