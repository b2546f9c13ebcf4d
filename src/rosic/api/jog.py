"""Live control by whoever listens to events: a stick, keys or a gamepad steer one robot.

The first sample begins an order like any other, with its rights, its lease and its record; later
ones steer it. After its end nothing goes on by itself: a sample counts again only once the controls
were let go (I6).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import msgspec

from rosic.api.schemas import Name
from rosic.core.i18n import said
from rosic.core.message import AnswerState
from rosic.core.sample_gate import LATE_S, SampleVerdict
from rosic.core.time_units import SECOND_NS
from rosic.errors import RosicError
from rosic.gateway.live_control import LiveInput

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable

    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.api.live_orders import LiveOrders

ROBOTS_AT_MOST: Final = 4
"""That one connection steers at a time."""
CLAIMED_WITHIN_S: Final = 10.0
MILLISECOND_NS: Final = 1_000_000
NUMBER_MOST: Final = 2**53

DRIVING: Final = said("Driving live. Letting go brings it to rest.")
NOT_BEGUN: Final = said("Nothing is known of that order yet. Let go, look, and begin anew.")
ASKED_FIRST: Final = said(
    "Somebody has to agree first, so this cannot be driven live. Give it as an order."
)
LATE: Final = said("Samples come too late, so they steer nothing.")
CLAMPED: Final = said("That is the most that is allowed to you.")


class Jog(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="jog", tag_field="op"):
    """Steer a robot by a skill that streams.

    Attributes:
        values: By parameter, in the units of the profile; what is left out is zero.
        sent_ms: When it was sent, by the sender's wall clock.
        n: Of its sender: each higher than the one before.
        release: The controls were let go: the robot comes to rest.
    """

    robot: Name
    skill: Name
    values: dict[str, float] = {}
    sent_ms: float = 0.0
    n: int = 0
    release: bool = False


class JogEvent(msgspec.Struct, frozen=True, tag="jog", tag_field="event"):
    """How live control of a robot stands.

    Attributes:
        first: Number of the sample that began it.
        over: Nothing is steered any more; let go, then begin anew.
        ending: How the order ended; empty while it goes on, or where none was begun.
    """

    robot: str
    over: bool
    text: str
    first: int = 0
    ending: str = ""
    code: str = ""


class JogSession:
    """One robot in the hand of one connection, from the first sample until the controls are let go.

    Attributes:
        over: Its order has ended, or none was begun: it waits for being let go.
    """

    def __init__(
        self,
        context: ApiContext,
        orders: LiveOrders,
        caller: ApiCaller,
        first: Jog,
        tell: Callable[[JogEvent], None],
    ) -> None:
        self.over = False
        self._context, self._orders = context, orders
        self._caller, self._tell = caller, tell
        self._robot, self._skill, self._first = first.robot, first.skill, first.n
        self._input: LiveInput | None = None
        self._released = False
        self._last: SampleVerdict | None = SampleVerdict.TAKEN
        self._clamped: tuple[str, ...] = ()

    async def run(self) -> None:
        """Begin the order, and wait for its end."""
        try:
            ended = await self._drive()
        except RosicError as why:
            ended = JogEvent(self._robot, over=True, text=why.sentence, code=why.code)
        self.over = True
        self._say(ended)

    def put(self, sample: Jog) -> None:
        """Take a sample; one that comes before the controls are open, or after, steers nothing."""
        if self.over or self._input is None or sample.skill != self._skill:
            return
        sent_ns = int(sample.sent_ms) * MILLISECOND_NS if _is_number(sample.sent_ms) else 0
        result = self._input.put(sample.values, sent_ns, sample.n)
        if result.verdict is SampleVerdict.OVER:
            return
        if result.verdict is not self._last or result.clamped != self._clamped:
            self._last, self._clamped = result.verdict, result.clamped
            driving = CLAMPED if result.clamped else DRIVING
            text = driving if result.taken else result.sentence or LATE
            self._say(JogEvent(self._robot, over=False, text=text, code=result.verdict.value))

    def release(self) -> None:
        """Let go: the robot comes to rest, whatever else is under way."""
        self._released = True
        if self._input is not None:
            self._input.release()

    async def _drive(self) -> JogEvent:
        self._context.profile(self._caller, self._robot)
        opened = await self._orders.open(
            self._caller, self._robot, self._skill, within_s=CLAIMED_WITHIN_S
        )
        if opened is None:
            return JogEvent(self._robot, over=True, text=NOT_BEGUN)
        if isinstance(opened, LiveInput):
            return await self._steer(opened)
        if opened.state is AnswerState.NOT_DONE:
            return JogEvent(self._robot, over=True, text=opened.text, code=opened.code)
        return JogEvent(self._robot, over=True, text=ASKED_FIRST)

    async def _steer(self, controls: LiveInput) -> JogEvent:
        self._input = controls
        try:
            if self._released:
                controls.release()
            else:
                self._say(JogEvent(self._robot, over=False, text=DRIVING))
            outcome = await controls.ended()
        finally:
            controls.release()
            controls.close()
        ending = outcome.ending.value
        return JogEvent(self._robot, over=True, text=outcome.note, ending=ending, code=outcome.code)

    def _say(self, event: JogEvent) -> None:
        text = self._context.callers.read_by(event.text, self._caller)
        self._tell(msgspec.structs.replace(event, text=text, first=self._first))


class JogSessions:
    """What one connection steers."""

    def __init__(
        self,
        context: ApiContext,
        orders: LiveOrders,
        caller: ApiCaller,
        tell: Callable[[JogEvent], None],
        group: asyncio.TaskGroup,
    ) -> None:
        self._context, self._orders = context, orders
        self._caller, self._tell, self._group = caller, tell, group
        self._sessions: dict[str, JogSession] = {}
        self._running: set[asyncio.Task[None]] = set()

    def close(self) -> None:
        """Whoever steered is gone: everything is let go."""
        for task in self._running:
            task.cancel()

    def take(self, sample: Jog) -> None:
        """Take a sample, or that the controls were let go."""
        session = self._sessions.get(sample.robot)
        if sample.release:
            if session is not None:
                session.release()
                del self._sessions[sample.robot]
        elif self._context.messenger(self._caller).waited_ns() > LATE_S * SECOND_NS:
            return  # this process stood still: nobody knows how old it is
        elif session is not None:
            session.put(sample)
        elif len(self._sessions) < ROBOTS_AT_MOST:
            session = JogSession(self._context, self._orders, self._caller, sample, self._tell)
            self._sessions[sample.robot] = session
            running = self._group.create_task(session.run())
            self._running.add(running)
            running.add_done_callback(self._running.discard)


def _is_number(value: float) -> bool:
    return 0.0 <= value <= NUMBER_MOST
