"""Robots on a live ROS 2 graph: found, looked at, and drafted as profiles."""
