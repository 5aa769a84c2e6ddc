"""The configuration: one TOML file, the rules its values obey, and every default."""
