"""What rooms and adapters expect of each other, as Protocols with guarantees."""
