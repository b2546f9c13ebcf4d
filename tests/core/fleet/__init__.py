"""Tests of the fleet as a value machine."""
