"""May they, now? Rights, rates and who has which robot."""
