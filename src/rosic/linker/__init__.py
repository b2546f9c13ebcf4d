"""Which robot, where, and what did it answer? Routes, mailboxes and the stop lane."""
