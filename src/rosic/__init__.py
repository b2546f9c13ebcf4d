"""ROSIC carries messages from a chat to ROS 2 robots, and brings back what they really did.

A message passes four rooms in one order: authoriser, organiser, container, linker. That path is
`rosic.gateway`; `docs/README.md` leads to the rest. Nothing is imported here, so that importing
a single module stays cheap.
"""

from __future__ import annotations

__version__ = "0.1.0"
