"""What happens, told to other software: signed, in order per robot, tried again for a day."""
