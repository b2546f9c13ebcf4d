"""The operator's interface: what ``rosic`` commands ask of a running gateway, or of its data."""
