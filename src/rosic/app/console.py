"""The terminal at which somebody sits: Ctrl-C brings robots to rest, a second one ends."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from rosic.app.admin.dispatch import AdminDispatcher
from rosic.contracts.console import Console
from rosic.core.i18n import filled, in_language, joined, said
from rosic.core.identity import OPERATOR
from rosic.errors import MessengerFault

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterable

    from rosic.app.gateway import Gateway
    from rosic.contracts.messenger import Messenger

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
