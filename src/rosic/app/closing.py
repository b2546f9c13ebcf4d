"""The end of a gateway, which comes in time whatever happens."""

from __future__ import annotations

import asyncio
import logging
import os
import signal
from contextlib import suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from rosic.app.gateway import Gateway

    Say = Callable[[str], object]

# A signal ends everything within 5 s; what is left of them belongs to the interpreter.
CLOSE_WITHIN_S = 4.3

ENDS = (signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1, signal.SIGUSR2, signal.SIGALRM)
"""The last three mean nothing here; left alone they end a process before motion is at rest."""

log = logging.getLogger("rosic.gateway")


def on_signals(leave: Callable[[], object], interrupt: Callable[[], object] | None = None) -> None:
    """Call ``leave`` when a signal would end this process: SIGTERM, SIGINT, SIGHUP and others.

    Args:
        leave: Ends it.
        interrupt: Called for SIGINT instead, where somebody sits at a terminal.
    """
    loop = asyncio.get_running_loop()
    for number in ENDS:
        loop.add_signal_handler(number, leave)
    loop.add_signal_handler(signal.SIGINT, leave if interrupt is None else interrupt)


async def close_in_time(
    gateway: Gateway, seconds: float = CLOSE_WITHIN_S, *, status: int = 0, say: Say = log.warning
) -> None:
    """Close a gateway; what is not closed in time is left to the record, which is on disk.

    Its orders read "unknown" then. A robot that is not at rest by then has been told to come to
    rest all the while; it is latched, so that the next start moves it for nobody before a resume.
    When time is over the process ends there and then with ``status``; ``say`` says so before.
    """
    task = asyncio.ensure_future(_quietly(gateway.close()))
    done, _ = await asyncio.wait((task,), timeout=seconds)
    if not done:
        say(await _leave(gateway))
        logging.shutdown()
        os._exit(status)


async def _leave(gateway: Gateway) -> str:
    """Hold what is not at rest. Return what to say of it."""
    left = gateway.not_at_rest()
    if not left:
        return "Not everything could be closed in time; the next start says what is unknown."
    kept = await gateway.hold([profile.id for profile in left])
    return left_behind([profile.shown for profile in left], kept=kept)


def left_behind(shown: Sequence[str], *, kept: bool) -> str:
    """Return what is said of robots that were not at rest when time was over.

    Args:
        shown: Their names; at least one.
        kept: Whether it is on disk that they are held.
    """
    names = " and ".join(filter(None, (", ".join(shown[:-1]), shown[-1])))
    one = len(shown) == 1
    if one:
        what = "is still coming to rest, as it was told"
        then = "stays stopped until somebody resumes it"
    else:
        what = "are still coming to rest, as they were told"
        then = "stay stopped until somebody resumes them"
    if not kept:
        then = "this could not be written down: after a restart, look before you move anything"
    return f"{names} {what}, and {then}."


async def _quietly(closing: Awaitable[None]) -> None:
    with suppress(asyncio.CancelledError):
        try:
            await closing
        except Exception:
            log.exception("closing")
