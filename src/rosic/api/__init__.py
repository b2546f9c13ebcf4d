"""The API beside the chat: REST, a WebSocket and rosbridge over the same four rooms."""
