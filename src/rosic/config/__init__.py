"""Files people write, read with the line of everything: profiles, missions, the configuration."""
