"""The tables of the configuration that say how ROSIC is reached by, and tells, other software."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import msgspec

from rosic.api.settings import OpenedTopicSettings, parse_listen, parse_origin
from rosic.api.webhooks.settings import WebhookTopic, check_url, is_private_url
from rosic.contracts.file_rules import ValidationFinding

if TYPE_CHECKING:
    from collections.abc import Iterator

WITHOUT_TLS: Final = "public address, no TLS"
LISTEN_EXAMPLE: Final = 'For example listen = "127.0.0.1:8765".'
PRIVATE: Final = "This address is in a private network, so nothing is posted there."
METRICS_EXAMPLE: Final = 'For example listen = "127.0.0.1:9464".'
ORIGIN_EXAMPLE: Final = 'As browsers say it, for example "https://panel.example.org".'


class ApiTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The API beside the chat, and the page; nothing listens, if nothing stands here.

    Attributes:
        listen: Address of this machine and port: ``127.0.0.1:8765``.
        hosts: Names by which it is reached, besides that address.
        url: What links to it begin with, as people reach it: ``https://robots.example.org``.
        certificate: File of its TLS certificate, with the chain; PEM.
        private_key: File of the certificate's key; PEM.
        proxies: Addresses of the proxies before it, whose word on clients counts.
        without_tls: ``public address, no TLS`` serves others than this machine in the clear.
        rosbridge: Where clients of rosbridge come in besides: ``127.0.0.1:9090``.
        origins: Pages elsewhere that may be clients of rosbridge: ``https://panel.example.org``.
        topic: Topics for clients of rosbridge, besides those that robots' profiles name.
    """

    listen: str = ""
    hosts: tuple[str, ...] = ()
    url: str = ""
    certificate: str = ""
    private_key: str = ""
    proxies: tuple[str, ...] = ()
    without_tls: str = ""
    rosbridge: str = ""
    origins: tuple[str, ...] = ()
    topic: tuple[OpenedTopicSettings, ...] = ()


class MetricsTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Metrics for Prometheus; nothing listens, if nothing stands here.

    Attributes:
        listen: Address of this machine and port, of its own: ``127.0.0.1:9464``.
        hosts: Names by which it is reached, besides that address.
        without_tls: ``public address, no TLS`` lets other machines read them, in the clear.
    """

    listen: str = ""
    hosts: tuple[str, ...] = ()
    without_tls: str = ""


class WebhookTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Software elsewhere that is told what happens, by posts that are signed.

    Attributes:
        url: Where it is posted: ``https://hooks.example.org/rosic``.
        secret: ``whsec_`` and 24 to 64 bytes in base64; better one that stands elsewhere.
        events: Of what it is told: ``orders``, ``stops``, ``robots``, ``alerts``; left out: of all.
        private: It may be on this machine or in a private network.
    """

    url: str
    secret: str | dict[str, str]
    events: tuple[WebhookTopic, ...] = tuple(WebhookTopic)
    private: bool = False


def posted(webhook: WebhookTable) -> Iterator[ValidationFinding]:
    """Yield what is wrong with a table of a webhook."""
    try:
        check_url(webhook.url)
    except ValueError as wrong:
        yield ValidationFinding(("url",), f"{wrong}.", "It begins with https://")
        return
    if not webhook.private and is_private_url(webhook.url):
        yield ValidationFinding(
            ("url",), PRIVATE, "Say private = true if that is meant, or name another address."
        )


def measured(metrics: MetricsTable) -> Iterator[ValidationFinding]:
    """Yield what is wrong with the table of metrics."""
    if not metrics.listen:
        if metrics != MetricsTable():
            yield ValidationFinding(
                ("listen",), "No address is named, so nothing listens.", METRICS_EXAMPLE
            )
        return
    try:
        listen = parse_listen(metrics.listen)
    except ValueError as wrong:
        yield ValidationFinding(("listen",), f"{wrong}.", METRICS_EXAMPLE)
        return
    if not listen.is_loopback and metrics.without_tls != WITHOUT_TLS:
        yield ValidationFinding(
            ("listen",),
            f"{metrics.listen} is reached from other machines, and nothing there is encrypted.",
            f'Have an agent on this machine read it; or say without_tls = "{WITHOUT_TLS}".',
        )


def served(api: ApiTable) -> Iterator[ValidationFinding]:
    """Yield what is wrong with the table of the API."""
    if not api.listen:
        if api != ApiTable():
            yield ValidationFinding(
                ("listen",), "No address is named, so nothing listens.", LISTEN_EXAMPLE
            )
        return
    if bool(api.certificate) != bool(api.private_key):
        yield ValidationFinding(
            ("certificate",), "A certificate and its private key belong together.", "Name both."
        )
    yield from _listening(api, "listen", api.listen)
    if api.rosbridge:
        yield from _listening(api, "rosbridge", api.rosbridge)
        if api.rosbridge == api.listen:
            yield ValidationFinding(
                ("rosbridge",), f"The API listens on {api.listen} already.", "Name another port."
            )
    for number, origin in enumerate(api.origins):
        try:
            parse_origin(origin)
        except ValueError as wrong:
            yield ValidationFinding(("origins", number), f"{wrong}.", ORIGIN_EXAMPLE)


def _listening(api: ApiTable, key: str, where: str) -> Iterator[ValidationFinding]:
    try:
        listen = parse_listen(where)
    except ValueError as wrong:
        yield ValidationFinding((key,), f"{wrong}.", LISTEN_EXAMPLE.replace("listen", key))
        return
    in_clear = not (api.certificate or (api.proxies and api.url.startswith("https://")))
    if not listen.is_loopback and in_clear and api.without_tls != WITHOUT_TLS:
        yield ValidationFinding(
            (key,),
            f"{where} is reached from other machines, and nothing there is encrypted.",
            "Name a certificate, or a proxy and its https url; or say without_tls = "
            f'"{WITHOUT_TLS}".',
        )
