"""Adapters to what guesses, outside ROSIC, what words mean; each owes `contracts.interpreter`."""
