"""Where a webhook is: looked up, and refused where it leads into a private network unasked."""

from __future__ import annotations

import asyncio
import socket
from typing import TYPE_CHECKING, Final
from urllib.parse import urlsplit

from rosic.api.webhooks.settings import is_private

if TYPE_CHECKING:
    from rosic.api.webhooks.settings import WebhookSettings

HTTPS: Final = "https"
PORTS: Final = {HTTPS: 443, "http": 80}


class RefusedAddress(Exception):
    """One of its addresses is of this machine or of a private network, and that is not said."""

    def __init__(self) -> None:
        super().__init__("it is in a private network, and private = true is not said")


def host_and_port(settings: WebhookSettings) -> tuple[str, int]:
    """Return what is looked up."""
    parts = urlsplit(settings.url)
    return parts.hostname or "", parts.port or PORTS[parts.scheme]


def shown(settings: WebhookSettings) -> str:
    """Return where it goes, without what may be secret in its path."""
    return urlsplit(settings.url).netloc.rpartition("@")[2]


async def addresses_of(settings: WebhookSettings) -> list[str]:
    """Look up where a webhook is now.

    Raises:
        RefusedAddress: It is not asked there.
        OSError, UnicodeError: It has no address.
    """
    host, port = host_and_port(settings)
    loop = asyncio.get_running_loop()
    found = await loop.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    addresses = [str(address[0]) for *_, address in found]
    if not settings.private and is_private(addresses):
        raise RefusedAddress
    return addresses
