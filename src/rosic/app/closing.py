"""The end of a gateway, which comes in time whatever happens."""

from __future__ import annotations

import asyncio
import logging
import os
from contextlib import suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Awaitable

    from rosic.app.gateway import Gateway

# A signal ends everything within 5 s; what is left of them belongs to the interpreter.
CLOSE_WITHIN_S = 4.3

log = logging.getLogger("rosic.gateway")


async def close_in_time(gateway: Gateway, seconds: float = CLOSE_WITHIN_S) -> None:
    """Close a gateway; what is not closed in time is left to the record, which is on disk.

    Its orders read "unknown" then, and the next start holds their robots.
    """
    task = asyncio.ensure_future(_quietly(gateway.close()))
    done, _ = await asyncio.wait((task,), timeout=seconds)
    if not done:
        log.error("not everything came to rest in time; the next start says what is unknown")
        logging.shutdown()
        os._exit(0)


async def _quietly(closing: Awaitable[None]) -> None:
    with suppress(asyncio.CancelledError):
        try:
            await closing
        except Exception:
            log.exception("closing")
