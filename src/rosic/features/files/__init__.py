"""Files: from a person into their container, from there to a robot, and back."""
