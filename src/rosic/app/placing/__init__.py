"""Puts each part of a gateway in its place: made from what is written, bound to the rooms."""
