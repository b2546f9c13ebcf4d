"""The operator's desk: what ``rosic`` commands ask of a running gateway, or of its data."""
