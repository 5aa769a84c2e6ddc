"""The configuration: one TOML file, the rules for its values, and the defaults."""
