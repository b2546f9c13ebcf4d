"""``rosic webhook test``: posts one event, signed, and says what became of it."""

from __future__ import annotations

import argparse
import asyncio
import base64
import time
from pathlib import Path
from typing import TYPE_CHECKING

from rosic.api.schemas import moment
from rosic.api.webhooks.addresses import addresses_of
from rosic.api.webhooks.settings import BEGINS, WebhookSettings, check_url, is_private, key_of
from rosic.app.config import load_config
from rosic.cli.client import CONFIG
from rosic.core.secret import Secret
from rosic.errors import ConfigurationError, Fault, how_to_install
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Post one event of the type "test" to a webhook, signed as every other, and say how it was
taken. The secret is that of the [[webhook]] with this address, or one that is made for the test and
shown."""
SECRET_BYTES = 32


def test(arguments: Sequence[str]) -> int:
    """Post once. Return 0 if it was taken.

    Raises:
        RosicError: It was not, and why.
    """
    parser = argparse.ArgumentParser(prog="rosic webhook test", description=ABOUT)
    parser.add_argument("url", metavar="URL")
    parser.add_argument("-c", "--config", metavar="FILE", help=f"where it stands ({CONFIG})")
    options = parser.parse_args(arguments)
    try:
        check_url(options.url)
    except ValueError as wrong:
        raise ConfigurationError(f"{wrong}.", hint="It begins with https://") from wrong
    known = _known(options.url, options.config)
    settings = known or _made(options.url)
    return asyncio.run(_test(settings, made=known is None))


def _known(url: str, config: str | None) -> WebhookSettings | None:
    found = config or (CONFIG if Path(CONFIG).exists() else None)
    for known in () if found is None else load_config(found).webhooks:
        if known.url == url:
            return known
    return None


def _made(url: str) -> WebhookSettings:
    """Return what is tested where nothing is configured: wherever it is, and whoever asks sees."""
    made = SystemEntropy().token(SECRET_BYTES)
    secret = Secret(f"{BEGINS}{base64.b64encode(made).decode()}")
    print(
        f"No [[webhook]] has this address, so this secret is made for the test: {secret.reveal()}"
    )
    key_of(secret)
    return WebhookSettings(url=url, secret=secret, private=True)


async def _test(settings: WebhookSettings, *, made: bool) -> int:
    try:
        from rosic.api.webhooks.delivery import (  # noqa: PLC0415 - an extra
            NotTaken,
            WebhookDelivery,
            WebhookEvent,
        )
    except ImportError as error:
        raise ConfigurationError(
            f"Webhooks need a library that is not installed ({error.name}).",
            hint=f"Run: {how_to_install('client')}",
        ) from error
    clock = SystemClock()
    delivery = WebhookDelivery(settings, clock, "test")
    begun = time.monotonic()
    try:
        event = WebhookEvent("test", moment(clock.wall_ns()), {"robot": ""})
        status = await delivery.post(f"msg_test_{clock.wall_ns():x}", event)
    except NotTaken as why:
        raise Fault(f"It was not taken: {why}.") from why
    finally:
        await delivery.close()
    print(f"Taken ({status}), in {time.monotonic() - begun:.2f} s.")
    if made and is_private(await addresses_of(settings)):
        print(
            "This address is in a private network: a [[webhook]] is posted there only if it says "
            "private = true."
        )
    return 0
