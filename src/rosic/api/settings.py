"""What is said of the API in the configuration."""

from __future__ import annotations

import ipaddress
import re
from typing import Final
from urllib.parse import urlsplit

import msgspec

from rosic.core.hosts import is_this_machine
from rosic.core.rate_limit import RateLimit

LISTEN: Final = "127.0.0.1:8765"
PORT_MOST: Final = 65_535
LOCAL_NAMES: Final = ("localhost", "127.0.0.1", "::1")


class HostPort(msgspec.Struct, frozen=True):
    """Where something listens: a numeric address of this machine, and a port; 0: any free one."""

    host: str
    port: int

    def __str__(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    @property
    def is_loopback(self) -> bool:
        """Whether only this machine reaches it."""
        return is_this_machine(self.host)

    @property
    def names(self) -> frozenset[str]:
        """The names by which a client may say that it reaches it."""
        return frozenset({self.host, *(LOCAL_NAMES if self.is_loopback else ())})


def parse_listen(text: str) -> HostPort:
    """Read where to listen: ``127.0.0.1:8765``, ``[::1]:8765``.

    Raises:
        ValueError: It is none; one clear sentence without a full stop.
    """
    host, _, port = text.strip().rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    try:
        ipaddress.ip_address(host)
        number = int(port) if port.isascii() and port.isdigit() else -1
    except ValueError:
        number = -1
    if not 0 <= number <= PORT_MOST:
        raise ValueError(f"{text!r} is no address and port of this machine")
    return HostPort(host, number)


_ORIGIN: Final = re.compile(
    r"https?://[a-z0-9.-]+(:[0-9]{1,5})?|https?://\[[0-9a-f:]+\](:[0-9]{1,5})?"
)


def parse_origin(text: str) -> str:
    """Read the origin of a page, as browsers say it: ``https://panel.example.org``.

    Raises:
        ValueError: It is none; one clear sentence without a full stop.
    """
    if not _ORIGIN.fullmatch(text):
        raise ValueError(f"{text!r} is no origin of a page")
    return text


def hostname(host: str) -> str:
    """Return the name in the header ``Host``, without its port; empty: it is none."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


class ServingLimits(msgspec.Struct, frozen=True, kw_only=True):
    """What clients may take of the gateway.

    Attributes:
        connections: At a time; the oldest that asks nothing gives way to whoever comes.
        head_s, body_s, file_s: So long the head, the body, the file of a request may take.
        idle_s: So long a connection may ask nothing more.
        head_bytes: Of one request.
        stalled_s: So long a client may take nothing of what it is sent.
        reads: Of one caller; orders and stops do not count.
    """

    connections: int = 1_000
    head_s: float = 10.0
    body_s: float = 30.0
    file_s: float = 300.0
    idle_s: float = 20.0
    head_bytes: int = 32_768
    stalled_s: float = 10.0
    reads: RateLimit = RateLimit(burst=200.0, per_s=20.0)


class OpenedTopicSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A topic of a robot's ROS graph that clients of rosbridge may use, besides those it reports.

    Attributes:
        name: ``/chatter``.
        type: ``std_msgs/msg/String``.
        robot: Whose it is: whoever may see that robot may subscribe.
        subscribe: Whether anybody may.
        publish: The right on that robot that lets one publish, as ``share``; empty: nobody may.
    """

    name: str
    type: str
    robot: str
    subscribe: bool = True
    publish: str = ""


class ApiSettings(msgspec.Struct, frozen=True, kw_only=True):
    """How the API is served.

    Attributes:
        listen: Where.
        hosts: Names by which it may be reached, besides the address it listens on.
        url: How people reach it: what links lead to; empty: by the address it listens on.
        certificate, private_key: Files in PEM; with them it speaks TLS itself.
        proxies: Addresses of proxies before it, whose word on the client's address and on TLS
            counts.
        limits: What clients may take.
        topics: That are open to clients of rosbridge, besides what robots report.
        rosbridge: Where clients of rosbridge come in besides, as they expect; None: nowhere.
        origins: Pages elsewhere that may be such clients, with a key or a ticket and no cookie.
    """

    listen: HostPort
    hosts: tuple[str, ...] = ()
    url: str = ""
    certificate: str = ""
    private_key: str = ""
    proxies: tuple[str, ...] = ()
    limits: ServingLimits = ServingLimits()
    topics: tuple[OpenedTopicSettings, ...] = ()
    rosbridge: HostPort | None = None
    origins: tuple[str, ...] = ()

    @property
    def reached_at(self) -> str:
        """Where people reach it."""
        scheme = "https" if self.certificate else "http"
        return self.url or f"{scheme}://{self.listen}"

    @property
    def is_tls(self) -> bool:
        """Whether browsers reach it by https, so that cookies are for https alone."""
        return bool(self.certificate) or self.url.startswith("https://")
