"""Programs that speak the Model Context Protocol: what they call becomes lines of the grammar."""

from __future__ import annotations

from rosic.messengers.mcp.messenger import McpMessenger, mcp_messenger

__all__ = ["McpMessenger", "mcp_messenger"]
