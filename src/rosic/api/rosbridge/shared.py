"""What all clients of rosbridge share."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias

from rosic.api.rosbridge.calls import ClientCalls
from rosic.container.records import KeptAnswer
from rosic.contracts.background_tasks import BackgroundTasks
from rosic.core.identity import command_id
from rosic.core.message import Chat
from rosic.core.rate_limit import Bucket, RateLimit
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
    from rosic.core.identity import Caller, PrincipalId
    from rosic.errors import RosicError

    Refused: TypeAlias = tuple[str, str, str]
    """An op, what it names, and the sentence."""

REFUSALS_AT_MOST: Final = 256
WRITTEN: Final = RateLimit(burst=60.0, per_s=0.5)
"""What is written down of one caller, over all connections."""
CALLERS_AT_MOST: Final = 1_000
KINDS_AT_MOST: Final = 128
AGAIN_S: Final = 1.0
"""The same refusal is told, and counted, at most so often."""
PAUSE_S: Final = 10.0
"""What was not refused for so long is written down anew."""
GOES_ON_S: Final = 60.0
"""What is refused all the time is written down so often: some clients publish for ever."""


class _Times(NamedTuple):
    """When a refusal was told, written down, and met last."""

    told_s: float = float("-inf")
    written_s: float = float("-inf")
    met_s: float = float("-inf")


class RefusalPace:
    """How often the same refusal is told to one client, and written down."""

    def __init__(self) -> None:
        self._met: dict[Refused, _Times] = {}

    def meet(self, refused: Refused, now_s: float) -> tuple[bool, bool]:
        """Take in that something is refused; return whether it is told, and written down."""
        before = self._met.get(refused, _Times())
        told = now_s - before.told_s >= AGAIN_S
        written = now_s - before.met_s >= PAUSE_S or now_s - before.written_s >= GOES_ON_S
        if len(self._met) > KINDS_AT_MOST:
            self._met.clear()
        self._met[refused] = _Times(
            now_s if told else before.told_s, now_s if written else before.written_s, now_s
        )
        return told, written


class RefusalNotes:
    """Has refusals written down and counted, as those of orders are."""

    def __init__(self, context: ApiContext) -> None:
        self._context = context
        self._clock = context.kernel.machine_clock
        self._writing: BackgroundTasks[None] = BackgroundTasks()
        self._rates: dict[PrincipalId, Bucket] = {}
        self._run = f"{context.kernel.machine_clock.wall_ns():x}"
        self._serial = 0

    def note(self, caller: ApiCaller, why: RosicError, asked: str, *, written: bool) -> None:
        """Count a refusal that is told, and write it down; a disk that hangs keeps nobody waiting.

        It was told on the connection: no later run says it again.
        """
        if not isinstance(why, Refusal) or len(self._writing) >= REFUSALS_AT_MOST:
            return
        with contextlib.suppress(Unrecognised):
            known = self._context.kernel.rooms.authoriser.stand_for(caller.principal)
            self._context.kernel.pipeline.hooks.refused(known, why)
            if written and self._may_write(caller.principal):
                self._serial += 1
                serial = f"{self._run}-{self._serial}"
                self._writing.begin(self._written(caller, known, why, asked, serial))

    def _may_write(self, principal: PrincipalId) -> bool:
        now_ns = self._clock.monotonic_ns()
        if principal not in self._rates:
            if len(self._rates) >= CALLERS_AT_MOST:
                self._rates.clear()
            self._rates[principal] = Bucket(WRITTEN, now_ns)
        return not self._rates[principal].take(now_ns)

    async def _written(
        self, caller: ApiCaller, known: Caller, why: Refusal, asked: str, serial: str
    ) -> None:
        address = caller.address
        cid = command_id(address.platform, address.account, "rosbridge", serial)
        chat = Chat(address.platform, address.account)
        name = self._context.messenger(caller).name
        answer = KeptAnswer(name, chat, "", str(why.sentence), asked[:200])
        container = self._context.kernel.rooms.container
        with contextlib.suppress(Repeated):
            await container.refuse(cid, known, why, answer)
            container.told(cid)


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
