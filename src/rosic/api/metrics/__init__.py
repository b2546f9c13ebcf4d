"""What an operator's monitoring reads of a gateway, on a port of its own."""
