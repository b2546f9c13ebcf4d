"""What exactly do they mean? And it is on disk before anything moves."""
