"""Puts the outbox in its place: what is owed to somebody outlives the process that owes it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.contracts.messenger import alarm_to
from rosic.gateway.delivery.notifier import UndeliverableHandler
from rosic.gateway.delivery.outbox import Outbox

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.app.features import FeatureSetup
    from rosic.app.settings import GatewayParts
    from rosic.core.identity import PrincipalId
    from rosic.core.records import Memory
    from rosic.errors import MessengerFault
    from rosic.gateway.delivery.sender import ChatSender
    from rosic.gateway.stop import StopLane


def owe_over_crashes(
    parts: GatewayParts,
    furnishing: FeatureSetup,
    stop_lane: StopLane,
    teller: ChatSender,
    memory: Memory,
    name: Callable[[PrincipalId], str],
) -> Outbox:
    """Have alarms, notices and the answers to stops written down, and admins told of thieves."""
    outbox = Outbox(parts.store, parts.clock, parts.entropy, teller)
    furnishing.retracting.begin(parts.store.note, furnishing.reach.messengers, memory.facts)
    furnishing.reach.outbox = stop_lane.outbox = outbox
    outbox.dress = furnishing.reach.dress
    elsewhere = UndeliverableHandler(furnishing.reach, furnishing.admins, name)
    teller.gone = elsewhere.gone

    def warn(fault: MessengerFault) -> None:
        """Tell the admins wherever they are reached that somebody else acts for a messenger.

        Through that messenger too: whoever has its token may take the words away again, but not
        from every phone that has shown them.
        """
        furnishing.reach.tell(furnishing.admins(), fault.sentence, urgent=True)

    for messenger in parts.messengers:
        alarm_to(messenger, warn)
    return outbox
