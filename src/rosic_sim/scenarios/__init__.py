"""Plays: what ROSIC is for, told by a few people and simulated robots in half a minute."""
