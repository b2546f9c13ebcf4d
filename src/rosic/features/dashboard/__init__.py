"""One message a chat that shows how robots are, edited in place: the paper's status panel."""
