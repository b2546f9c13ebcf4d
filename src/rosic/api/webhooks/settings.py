"""What is said of webhooks in the configuration, and how what they carry is signed."""

from __future__ import annotations

import base64
import binascii
import enum
import hashlib
import hmac
import ipaddress
from typing import TYPE_CHECKING, Final
from urllib.parse import urlsplit

import msgspec

from rosic.core.secret import Secret

if TYPE_CHECKING:
    from collections.abc import Iterable

BEGINS: Final = "whsec_"
LEAST_BYTES, MOST_BYTES = 24, 64
NAT64: Final = ipaddress.IPv6Network("64:ff9b::/96")


class WebhookTopic(enum.Enum):
    """Of what it may be told."""

    ORDERS = "orders"
    STOPS = "stops"
    ROBOTS = "robots"
    ALERTS = "alerts"


class WebhookSettings(msgspec.Struct, frozen=True, kw_only=True):
    """One that is told.

    Attributes:
        url: Where it is posted.
        secret: ``whsec_`` and base64, with which it is signed.
        topics: Of what it is told.
        private: It may be on this machine, or in a private network.
    """

    url: str
    secret: Secret
    topics: frozenset[WebhookTopic] = frozenset(WebhookTopic)
    private: bool = False


def key_of(secret: Secret) -> bytes:
    """Return the bytes of a secret.

    Raises:
        ValueError: It is none; one clear sentence without a full stop, which does not repeat it.
    """
    text = secret.reveal()
    try:
        key = base64.b64decode(text.removeprefix(BEGINS), validate=True)
    except (binascii.Error, ValueError):
        key = b""
    if not (text.startswith(BEGINS) and LEAST_BYTES <= len(key) <= MOST_BYTES):
        raise ValueError(
            f"A secret of a webhook is {BEGINS} and {LEAST_BYTES} to {MOST_BYTES} bytes in base64"
        )
    return key


def check_url(url: str) -> None:
    """See that something can be posted there.

    Raises:
        ValueError: It cannot; one clear sentence without a full stop.
    """
    try:
        parts = urlsplit(url)
        good = parts.scheme in {"http", "https"} and bool(parts.hostname) and parts.port != 0
    except ValueError:
        good = False
    if not good or " " in url:
        raise ValueError(f"{url[:200]!r} is no address to which something can be posted")


def is_private_url(url: str) -> bool:
    """Whether it names an address, instead of a name, that is none of the public network."""
    host = urlsplit(url).hostname or ""
    try:
        return is_private((host,))
    except ValueError:
        return False  # a name: where it leads is looked at before each post


def is_private(addresses: Iterable[str]) -> bool:
    """Whether any of these is no address of one machine of the public network."""
    return any(not _is_public(ipaddress.ip_address(each.partition("%")[0])) for each in addresses)


def _is_public(address: ipaddress.IPv4Address | ipaddress.IPv6Address) -> bool:
    """Whether it is public; an IPv6 address that carries one of IPv4 is as public as that."""
    if isinstance(address, ipaddress.IPv6Address):
        inner = address.ipv4_mapped or address.sixtofour
        if inner is None and address in NAT64:
            inner = ipaddress.IPv4Address(int(address) & 0xFFFFFFFF)
        if inner is not None:
            return _is_public(inner)
    return address.is_global and not address.is_multicast


def signed(key: bytes, message: str, at_s: int, body: bytes) -> dict[str, str]:
    """Return the headers that show who says it and when, as Standard Webhooks has them."""
    text = b".".join((message.encode(), str(at_s).encode(), body))
    digest = base64.b64encode(hmac.digest(key, text, hashlib.sha256)).decode()
    return {
        "webhook-id": message,
        "webhook-timestamp": str(at_s),
        "webhook-signature": f"v1,{digest}",
    }
