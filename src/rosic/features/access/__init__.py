"""The chat side of people: coming in, being somebody, and being locked out."""
