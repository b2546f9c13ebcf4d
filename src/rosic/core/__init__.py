"""The words of the domain: pure values and decisions. No I/O, no clock, no randomness."""
