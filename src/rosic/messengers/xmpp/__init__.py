"""XMPP: one account at anybody's server; outbound connections only (docs/messengers/xmpp.md)."""

from __future__ import annotations

from rosic.messengers.xmpp.messenger import XmppMessenger, xmpp_messenger

__all__ = ["XmppMessenger", "xmpp_messenger"]
