"""The end of a gateway, which comes in time whatever happens."""

from __future__ import annotations

import asyncio
import logging
import os
import signal
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from rosic.app.admin.dispatch import AdminDispatcher
from rosic.contracts.console import Console
from rosic.core.i18n import filled, in_language, joined, said
from rosic.core.identity import OPERATOR
from rosic.errors import MessengerFault

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Sequence

    from rosic.app.gateway import Gateway
    from rosic.contracts.messenger import Messenger

    Say = Callable[[str], object]


# ---- console ----

# The terminal at which somebody sits: Ctrl-C brings robots to rest, a second one ends.

AGAIN: Final = said("Ctrl-C again ends ROSIC. To let robots move again: resume all")
NOT_HEARD: Final = said(
    "Nothing that is typed here is heard any more, stop included; ROSIC goes on for {others}. "
    "Ctrl-C brings every robot to rest, and a second one ends it."
)
AND: Final = said(" and ")


def console_of(messengers: Iterable[Messenger]) -> Console | None:
    """Return the terminal at which somebody sits, if there is one."""
    found = (one for one in messengers if isinstance(one, Console) and one.at_hand)
    return next(found, None)


def read_at(console: Console, gateway: Gateway, text: str) -> str:
    """Return a sentence as whoever sits at a terminal reads it."""
    return in_language(text, gateway.languages.of_reader(console.address, console.locale))


async def mind_console(
    console: Console, gateway: Gateway, leave: Callable[[], object], others: tuple[str, ...]
) -> None:
    """Follow what is pressed at a terminal, until somebody leaves by it.

    Args:
        console: The terminal.
        gateway: Whose robots a first Ctrl-C brings to rest.
        leave: Ends everything.
        others: Names of the other messengers, for which it goes on after Ctrl-D.
    """
    ended = asyncio.create_task(console.ended.wait())
    resting: set[asyncio.Task[None]] = set()  # held: the loop itself keeps no task alive
    try:
        while True:
            pressed = asyncio.create_task(console.interrupted.wait())
            await asyncio.wait((pressed, ended), return_when=asyncio.FIRST_COMPLETED)
            pressed.cancel()
            if console.interrupted.is_set():
                if console.take_interrupts() > 1:
                    leave()
                    return
                showing = await _bring_to_rest(console, gateway)
                resting.add(showing)
                showing.add_done_callback(resting.discard)
            elif ended.done() and not others:
                leave()
                return
            elif ended.done():
                _show(console, gateway, filled(NOT_HEARD, others=joined(AND, others)))
                ended = asyncio.create_task(asyncio.Event().wait())  # it ends once
    finally:
        for task in (ended, *resting):
            task.cancel()


async def _bring_to_rest(console: Console, gateway: Gateway) -> asyncio.Task[None]:
    """Stop every robot now; what is measured of it is shown as it comes, and keeps no key waiting.

    Returns:
        Shows it. Cancelling that ends nothing but the showing.
    """
    found = gateway.rooms.authoriser.directory.at(console.address)
    lines = AdminDispatcher(gateway).stop(by=found[0].id if found is not None else OPERATOR)
    # The stop is given by now, and nothing was waited for.
    _show(console, gateway, await anext(lines))
    return asyncio.create_task(_show_rest(console, gateway, lines))


async def _show_rest(console: Console, gateway: Gateway, lines: AsyncIterator[str]) -> None:
    async for line in lines:
        _show(console, gateway, line)
    _show(console, gateway, AGAIN)


def _show(console: Console, gateway: Gateway, text: str) -> None:
    with suppress(MessengerFault):  # nobody reads it, and the robots come to rest all the same
        console.show(read_at(console, gateway, text))


# ---- closing ----

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
