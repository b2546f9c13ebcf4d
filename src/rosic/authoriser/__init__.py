"""Who is this? People, their addresses and keys, conversations, and what a tap stands for."""
