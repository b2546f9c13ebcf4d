"""What overtakes everything else: a stop, and a cancel. Obeyed before anything is understood."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from rosic.core.language import Cancel

if TYPE_CHECKING:
    from rosic.contracts.messenger import Messenger
    from rosic.core.language import Halt
    from rosic.core.message import Inbound
    from rosic.gateway.cancel import CancelLane
    from rosic.gateway.order_execution import OrderExecutor
    from rosic.gateway.stop import StopLane


class UrgentLane:
    """Takes stops and cancels, and finds out whose robots are meant where they name none."""

    def __init__(self, stop_lane: StopLane, cancels: CancelLane, executor: OrderExecutor) -> None:
        self._stop_lane = stop_lane
        self._cancels = cancels
        self._executor = executor

    async def take(self, messenger: Messenger, inbound: Inbound, urgent: Halt | Cancel) -> bool:
        """Stop or cancel now. Return whether nothing else is to be read in the message."""
        where = (messenger.name, inbound.chat.id)
        # A button stands beneath a message, and a reply answers one: mostly somebody's order.
        under = inbound.under if inbound.nonce is not None else inbound.answers
        names = urgent.names
        if not names and inbound.answers:
            names = self._executor.shown_in(where, inbound.answers)
        if isinstance(urgent, Cancel):
            return await self._cancels.cancel(messenger, inbound, names)
        own_of = partial(self._executor.shown_in, where, under)
        own = own_of if under else _nobodys
        answered = await self._stop_lane.stop(messenger, inbound, names, own)
        heard = inbound.text if inbound.nonce is None else inbound.nonce
        return answered and "\n" not in heard.strip()


def _nobodys(_principal: str) -> tuple[str, ...]:
    """Of a stop beneath nothing, no robot carries out an order that it was meant for."""
    return ()
