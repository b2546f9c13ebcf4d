"""How programs speak: what they say becomes a line of the grammar, whatever they say it over."""
