"""Webhooks: whether they can be reached, by whom what goes there can be read, and how it is signed.

Nothing is posted: a connection is made and closed. ``rosic webhook test`` posts one event.
"""

from __future__ import annotations

import asyncio
import ssl
from importlib.util import find_spec
from typing import TYPE_CHECKING, Final

from rosic.api.webhooks.addresses import HTTPS, RefusedAddress, addresses_of, host_and_port, shown
from rosic.api.webhooks.settings import is_private, key_of
from rosic.app.setup.diagnostics_checks import DiagnosticFinding, FindingVerdict
from rosic.errors import how_to_install

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence

    from rosic.api.webhooks.settings import WebhookSettings

WITHIN_S: Final = 5.0
LEAST_DIFFERENT: Final = 12
"""Among 24 random bytes there are never fewer; in what somebody made up there mostly are."""
ABOUT: Final = "webhook"
LIBRARY: Final = "httpx"


async def examine_webhooks(
    webhooks: Sequence[WebhookSettings], within_s: float = WITHIN_S
) -> AsyncIterator[DiagnosticFinding]:
    """Look at every webhook, all at once; yield what was found in their order."""
    if webhooks and find_spec(LIBRARY) is None:
        text = f"webhooks need a library that is not installed: {how_to_install('client')}"
        yield DiagnosticFinding(ABOUT, FindingVerdict.LOOK, text)
        return
    for finding in await asyncio.gather(*(_examined(one, within_s) for one in webhooks)):
        yield finding


async def _examined(webhook: WebhookSettings, within_s: float) -> DiagnosticFinding:
    where = shown(webhook)
    try:
        async with asyncio.timeout(within_s):
            addresses = await addresses_of(webhook)
            await _connect(webhook, addresses)
    except RefusedAddress:
        text = "say private = true if that is meant"
        return _look(f"{where} is in a private network, so nothing is posted there: {text}")
    except (OSError, UnicodeError) as error:
        return _look(_why(error, where, within_s))
    return _of_reached(webhook, where, addresses)


def _why(error: OSError | UnicodeError, where: str, within_s: float) -> str:
    """Say why a webhook cannot be reached."""
    if isinstance(error, TimeoutError):
        return f"{where} does not answer within {within_s:g} s"
    if isinstance(error, ssl.SSLCertVerificationError):
        why = error.verify_message.rstrip(".")
        return f"the certificate of {where} is not trusted here: {why}"
    if isinstance(error, ssl.SSLError):
        return f"{where} does not speak TLS as it should"
    if isinstance(error, UnicodeError):
        return f"{where} is no name that can be looked up"
    return f"{where} cannot be reached ({error.strerror or type(error).__name__})"


def _of_reached(
    webhook: WebhookSettings, where: str, addresses: Sequence[str]
) -> DiagnosticFinding:
    private = is_private(addresses)
    if len(set(key_of(webhook.secret))) < LEAST_DIFFERENT:
        return _look(
            f"{where}: its secret is easily guessed, so others could sign what it takes for ours. "
            'Make one: echo "whsec_$(openssl rand -base64 32)"'
        )
    if not _is_tls(webhook) and not private:
        return _look(f"{where} is not encrypted: others may read what is posted there. Use https")
    network = "a private network, as is said" if private else "the public network"
    tls = "with TLS" if _is_tls(webhook) else "without TLS"
    text = f"{where} answers, {tls}, in {network}; what is posted is signed with its secret"
    return DiagnosticFinding(ABOUT, FindingVerdict.GOOD, text)


async def _connect(webhook: WebhookSettings, addresses: Sequence[str]) -> None:
    """Make a connection to the address that was looked at, and close it."""
    host, port = host_and_port(webhook)
    context = ssl.create_default_context() if _is_tls(webhook) else None
    named = host if context is not None else None
    _, writer = await asyncio.open_connection(
        addresses[0], port, ssl=context, server_hostname=named
    )
    writer.transport.abort()


def _is_tls(webhook: WebhookSettings) -> bool:
    return webhook.url.startswith(f"{HTTPS}:")


def _look(text: str) -> DiagnosticFinding:
    return DiagnosticFinding(ABOUT, FindingVerdict.LOOK, text)
