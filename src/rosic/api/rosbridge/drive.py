"""Publishing to a topic that moves a robot: each such client drives a live order of its skill.

The first message that is not zero begins the order, through the four rooms like any other; the
messages after it are its samples, with the skill's bounds, its author's limits, and the dead man's
law: 0.3 s without one, and the robot comes to rest. Zeros for a moment let go. Whatever else ended
it, nothing moves again over a connection until that one has published zeros once: what goes on
publishing after a stop, a refusal or a break does not drive by itself (I6).
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from rosic.api.live_orders import LiveOrders
from rosic.core.i18n import said
from rosic.core.policy.query import Deny
from rosic.core.policy.roles import StepRequired
from rosic.core.sample_gate import LATE_S, SampleVerdict
from rosic.core.time_units import SECOND_NS
from rosic.errors import Expired, FirstNeeded, OrderVoid, RobotStopped, RosicError
from rosic.gateway.live_control import LiveInput

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.core.sample_gate import SampleResult
    from rosic.errors import Refusal
    from rosic.gateway.live_topics import LiveTopic

    Tell = Callable[[str, str], None]
    Refuse = Callable[[RosicError, str], None]

RELEASE_S: Final = 0.2
"""After nothing but zeros for so long the controls are let go, before they fall silent."""
ACCEPTED_WITHIN_S: Final = 5.0
LOOK_S: Final = 0.004
HELD_AT_MOST: Final = 10_000

STOOD_STILL: Final = said("This gateway stood still, so that message may be old. Nothing was sent.")
LATE: Final = said("Nothing was answered in time. Nothing was sent.")


class LiveTopics:
    """What stands between clients and robots that they drive.

    Attributes:
        orders: Places orders that are steered.
    """

    def __init__(self, context: ApiContext) -> None:
        self.context, self.orders = context, LiveOrders(context)
        self._count = self._forgotten = 0
        self._holds: dict[tuple[str, str], int] = {}

    def hold(self, principal: str, topic: str) -> None:
        """Let somebody drive by a topic only after zeros, over whichever connection."""
        self._count += 1
        self._holds.pop((principal, topic), None)
        self._holds[principal, topic] = self._count
        if len(self._holds) > HELD_AT_MOST:
            self._forgotten = self._holds.pop(next(iter(self._holds)))

    def held(self, principal: str, topic: str) -> int:
        """Return the number of the hold that zeros have to follow; 0: there is none.

        Of holds that are forgotten, as there are too many, everybody's zeros have to be newer.
        """
        return self._holds.get((principal, topic), self._forgotten)


class _Newest(NamedTuple):
    """The newest message: its values, when it was sent as it says, and when it came."""

    values: dict[str, float]
    sent_ns: int
    came_ns: int


class TopicDriver:
    """Drives one robot by the messages that one client publishes to one topic.

    Args:
        driven: What stands between.
        caller: Who publishes.
        live: Which skill the topic belongs to.
        tell: Tells the client: a level, and a sentence.
        refuse: Tells the client of a refusal, at a level, and has it written down.
    """

    def __init__(
        self, driven: LiveTopics, caller: ApiCaller, live: LiveTopic, tell: Tell, refuse: Refuse
    ) -> None:
        self._driven, self._context = driven, driven.context
        self._caller, self._live, self._tell, self._refuse = caller, live, tell, refuse
        self._clock = self._context.kernel.machine_clock
        self._shown = self._context.kernel.rooms.profiles[live.robot].shown
        self._key = (caller.principal, live.topic)
        self._input: LiveInput | None = None
        self._driving: asyncio.Task[None] | None = None
        self._newest = _Newest({}, 0, 0)
        self._rested = 0
        self._sequence = 0
        self._releasing: asyncio.TimerHandle | None = None
        self._complained: dict[str, int] = {}

    # ---- what the client publishes ----

    def put(self, message: Mapping[str, Any]) -> None:
        """Take a message in. It never waits.

        Raises:
            NotUnderstood: It asks for what the skill does not do. Nothing was sent.
        """
        values = self._live.values(message)
        neutral = not any(values.values())
        ignored = self._live.ignored(message)
        if ignored:
            fields = ", ".join(ignored)
            told = said(
                "{robot} moves in a plane, so {fields} is not followed; the rest is.",
                robot=self._shown,
                fields=fields,
            )
            self._complain("warning", told)
        waited_ns = self._context.messenger(self._caller).waited_ns()
        came_ns = self._clock.monotonic_ns() - waited_ns
        self._newest = _Newest(values, self._sent_ns(message), came_ns)
        if neutral and not ignored:  # zeros, and nothing else
            self._rested = self._driven.held(*self._key)
        elif not neutral and waited_ns > LATE_S * SECOND_NS:
            self._refuse(Expired(STOOD_STILL), "warning")
            return
        self._mind_release(neutral=neutral)
        steered = self._input
        if steered is not None and steered.end is None:
            self._sample(steered)
        elif self._driving is None and not neutral:
            self._begin()

    def _sent_ns(self, message: Mapping[str, Any]) -> int:
        """Return when a message was sent, by its header where it has one; else it is new."""
        header = message.get("header")
        stamp = header.get("stamp") if isinstance(header, dict) else None
        if isinstance(stamp, dict):
            sec, nanosec = stamp.get("sec", 0), stamp.get("nanosec", 0)
            if isinstance(sec, int) and isinstance(nanosec, int) and (sec or nanosec):
                return sec * SECOND_NS + nanosec
        return self._clock.wall_ns()

    def _sample(self, steered: LiveInput) -> SampleResult:
        newest = self._newest
        self._sequence += 1
        result = steered.put_si(newest.values, newest.sent_ns, self._sequence)
        if result.clamped:
            names = ", ".join(result.clamped)
            self._complain("warning", said("Brought within what is allowed: {names}.", names=names))
        elif result.verdict not in _QUIET:
            why = result.sentence or result.verdict.value
            self._complain("warning", said("That message was not followed: {why}.", why=why))
        return result

    def _mind_release(self, *, neutral: bool) -> None:
        if self._releasing is not None:
            if neutral:
                return
            self._releasing.cancel()
            self._releasing = None
        if neutral and self._driving is not None:
            loop = asyncio.get_running_loop()
            self._releasing = loop.call_later(RELEASE_S, self._release)

    def _release(self) -> None:
        self._releasing = None
        if self._input is not None:
            self._input.release()

    # ---- the order ----

    def _begin(self) -> None:
        if self._driven.held(*self._key) > self._rested:
            self._refuse(self._why_held(), "error")
            return
        self._driving = asyncio.create_task(self._drive())

    def _why_held(self) -> Refusal:
        robot, topic = self._live.robot, self._live.topic
        if self._context.kernel.rooms.stops[robot].latched:
            return RobotStopped(
                said(
                    "{shown} is stopped. Nothing was sent. Whoever may lets it go on by: "
                    "resume {robot}. Then publish zeros to {topic} once.",
                    shown=self._shown,
                    robot=robot,
                    topic=topic,
                )
            )
        return OrderVoid(
            said(
                "Publish zeros to {topic} once; then it may be driven again. Nothing was sent.",
                topic=topic,
            )
        )

    async def _drive(self) -> None:
        """Begin a live order, and follow it to its end."""
        live, good = self._live, False
        try:
            steered = await self._opened()
            if steered is None:
                return
            self._tell(
                "info",
                said("{robot} is driven by {topic} now.", robot=self._shown, topic=live.topic),
            )
            self._input = steered
            await self._first_sample(steered)
            outcome = await steered.ended()
            good = not outcome.code and outcome.ending.value in {"done", "sent"}
            level = "info" if good else "error"  # which clients see unless they want less
            why = outcome.note or outcome.ending.value
            self._tell(
                level, said("{robot} is driven no further: {why}.", robot=self._shown, why=why)
            )
        except RosicError as why:
            self._refuse(why, "error")
        finally:
            if self._input is not None:
                self._input.close()
            self._input = self._driving = None
            if not good:
                self._driven.hold(*self._key)

    async def _opened(self) -> LiveInput | None:
        """Have the order's line carried out; return its controls, or None: it was refused."""
        live = self._live
        if self._agreed_first():
            asked = said(
                "Somebody has to agree to {skill} first, so {topic} does not drive {robot}. "
                "Give it as an order (POST /v1/robots/{id}/orders), or in a chat. "
                "Nothing was sent.",
                skill=live.skill,
                topic=live.topic,
                robot=self._shown,
                id=live.robot,
            )
            need = StepRequired.CONFIRMATION.value
            self._refuse(FirstNeeded(asked, need=need, robot=live.robot, text=live.skill), "error")
            return None
        opened = await self._driven.orders.open(
            self._caller, live.robot, live.skill, within_s=ACCEPTED_WITHIN_S
        )
        if isinstance(opened, LiveInput):
            return opened
        self._tell("error", LATE if opened is None else opened.text)
        return None

    def _agreed_first(self) -> bool:
        """Whether anybody has to agree before; who publishes cannot wait for it."""
        rooms, live = self._context.kernel.rooms, self._live
        known = rooms.authoriser.stand_for(self._caller.principal)
        decision = rooms.organiser.decision(known, live.robot, live.skill)
        return not isinstance(decision, Deny) and bool(decision.needs)

    async def _first_sample(self, steered: LiveInput) -> None:
        """Let the newest message count as soon as the robot's turn has come.

        One that has waited for longer than a sample may does not count: the next one begins.
        """
        steered.measure(self._newest.sent_ns, self._newest.came_ns)
        while steered.end is None:
            waited_ns = self._clock.monotonic_ns() - self._newest.came_ns
            if waited_ns > LATE_S * SECOND_NS:
                return
            if self._sample(steered).verdict is not SampleVerdict.WAITING:
                return
            await asyncio.sleep(LOOK_S)

    # ---- the client ----

    def _complain(self, level: str, sentence: str) -> None:
        """Tell the client the same at most once a second: messages come by the hundred."""
        now_ns = self._clock.monotonic_ns()
        if now_ns - self._complained.get(sentence, -SECOND_NS) >= SECOND_NS:
            if len(self._complained) > _SENTENCES:
                self._complained.clear()
            self._complained[sentence] = now_ns
            self._tell(level, sentence)

    def close(self) -> None:
        """The client is gone: without samples its order ends by itself."""
        if self._releasing is not None:
            self._releasing.cancel()
        if self._input is not None:
            self._input.close()
        if self._driving is not None:
            self._driven.hold(*self._key)
            self._driving.cancel()


_SENTENCES: Final = 32
_QUIET: Final = frozenset({SampleVerdict.TAKEN, SampleVerdict.WAITING, SampleVerdict.OVER})
