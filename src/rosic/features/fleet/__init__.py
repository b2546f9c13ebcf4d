"""Tasks for several robots: given in a chat, carried out by orders like any other."""
