"""Where an interpreter is: what the configuration may name, and what is to be said about it."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final, NamedTuple
from urllib.parse import urlsplit

from rosic.core.hosts import is_this_machine

if TYPE_CHECKING:
    from collections.abc import Iterator

COMPLETIONS: Final = "/v1/chat/completions"
TOLD: Final = (
    "People are told once, and may say /interpreter off. A server on this machine keeps it here."
)
EXAMPLE: Final = "For example http://127.0.0.1:11434 or https://llm.example.com."
_HOST: Final = re.compile(r"[a-z0-9](?:[a-z0-9.-]{0,251}[a-z0-9])?|[0-9a-f:.]{2,45}")
_PATH: Final = re.compile(r"(?:/[A-Za-z0-9._~-]{1,64}){0,8}/?")
_PORTS: Final = {"http": 80, "https": 443}


class Endpoint(NamedTuple):
    """An address of the form ``http://HOST[:PORT][/PATH]``, taken apart.

    Attributes:
        host: A name or a literal address, in small letters.
        path: Of the call itself.
    """

    tls: bool
    host: str
    port: int
    path: str

    @property
    def is_loopback(self) -> bool:
        """Whether what is sent there stays on this machine."""
        return is_this_machine(self.host)

    @property
    def authority(self) -> str:
        """Host and port, as an address has them; without the port where it is the usual one."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        usual = self.port == _PORTS["https" if self.tls else "http"]
        return host if usual else f"{host}:{self.port}"


def parse_endpoint(text: str) -> Endpoint:
    """Take an address apart. With or without ``/v1`` at its end, the same call is made.

    Raises:
        ValueError: It is none; one clear sentence, which does not repeat it.
    """
    try:
        parts = urlsplit(text)
        port, host = parts.port, parts.hostname or ""
    except ValueError:
        raise ValueError("that is no address of a server") from None
    if parts.scheme not in _PORTS:
        raise ValueError("an endpoint begins with http:// or https://")
    if "@" in parts.netloc:
        raise ValueError("an endpoint names no account: put the key under 'key'")
    if parts.query or parts.fragment or "?" in text or "#" in text:
        raise ValueError("an endpoint is an address without ? and #")
    if not _HOST.fullmatch(host) or port == 0:
        raise ValueError("that is no address of a server")
    if not _PATH.fullmatch(parts.path):
        raise ValueError("the path of an endpoint has letters, digits and . _ ~ - alone")
    base = parts.path.rstrip("/").removesuffix("/v1")
    return Endpoint(
        tls=parts.scheme == "https",
        host=host,
        port=port or _PORTS[parts.scheme],
        path=f"{base}{COMPLETIONS}",
    )


def advice_on(endpoint: Endpoint, *, keyed: bool) -> Iterator[tuple[str, str]]:
    """Yield what its owner should know of an endpoint: a sentence, and what can be done.

    Args:
        endpoint: Where it is.
        keyed: Whether a key goes along.
    """
    if endpoint.is_loopback:
        return
    leaves = (
        f"What people here write and ROSIC does not understand leaves this machine: it is sent to "
        f"{endpoint.authority}, with the robots and skills that they may see. Each such line may "
        "cost what its owner asks for a call."
    )
    yield leaves, TOLD
    if not endpoint.tls:
        what = "What they write and the key go" if keyed else "What they write goes"
        yield (
            f"{what} to {endpoint.authority} in the clear: whoever is on the way can read along.",
            "Use https://.",
        )
