"""Which robot, where, and what did it answer? Routes, queues and the stop lane."""
