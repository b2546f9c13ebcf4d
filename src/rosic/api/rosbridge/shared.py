"""What all clients of rosbridge share."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.api.rosbridge.calls import ClientCalls
from rosic.container.records import KeptAnswer
from rosic.contracts.background_tasks import BackgroundTasks
from rosic.core.identity import command_id
from rosic.core.message import Chat
from rosic.errors import Refusal, Repeated, Unrecognised

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.api.ordering import CallerRequests
    from rosic.api.rosbridge.calls import FollowedGoals
    from rosic.api.rosbridge.drive import LiveTopics
    from rosic.api.rosbridge.introspection import GraphIntrospection
    from rosic.api.rosbridge.messages import Told
    from rosic.api.rosbridge.topics import TopicDirectory, TopicHub
    from rosic.errors import RosicError

REFUSALS_AT_MOST: Final = 256


class RefusalNotes:
    """Has refusals written down and counted, as those of orders are."""

    def __init__(self, context: ApiContext) -> None:
        self._context = context
        self._writing: BackgroundTasks[None] = BackgroundTasks()
        self._run = f"{context.kernel.machine_clock.wall_ns():x}"
        self._serial = 0

    def note(self, caller: ApiCaller, why: RosicError, asked: str) -> None:
        """Write a refusal down; a disk that hangs keeps nobody waiting."""
        if not isinstance(why, Refusal) or len(self._writing) >= REFUSALS_AT_MOST:
            return
        self._serial += 1
        self._writing.begin(self._written(caller, why, asked, f"{self._run}-{self._serial}"))

    async def _written(self, caller: ApiCaller, why: Refusal, asked: str, serial: str) -> None:
        rooms, address = self._context.kernel.rooms, caller.address
        with contextlib.suppress(Unrecognised, Repeated):
            known = rooms.authoriser.stand_for(caller.principal)
            self._context.kernel.pipeline.hooks.refused(known, why)
            cid = command_id(address.platform, address.account, "rosbridge", serial)
            chat = Chat(address.platform, address.account)
            name = self._context.messenger(caller).name
            answer = KeptAnswer(name, chat, "", str(why.sentence), asked[:200])
            await rooms.container.refuse(cid, known, why, answer)


class RosbridgeParts(NamedTuple):
    """What all clients share.

    Attributes:
        context: The rooms.
        speech: Places orders, and stops.
        directory: Who may use which topics.
        hub: What is open on graphs.
        driven: What is driven by topics.
        introspection: Tells clients what there is.
        followed: Tells how far goals are.
        refusals: Writes them down.
    """

    context: ApiContext
    speech: CallerRequests
    directory: TopicDirectory
    hub: TopicHub
    driven: LiveTopics
    introspection: GraphIntrospection
    followed: FollowedGoals
    refusals: RefusalNotes

    def calls_of(self, caller: ApiCaller, say: Callable[[Told], None]) -> ClientCalls:
        """Return what carries out the calls of one client."""
        return ClientCalls(
            self.context, self.speech, self.introspection, self.followed, caller, say
        )
