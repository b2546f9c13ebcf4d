"""The paper's linker: RELAYCOMMAND of Algorithm 1, and the stop lane."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Any, Final, Protocol

from rosic.contracts.background_tasks import BackgroundTasks
from rosic.contracts.clock import done_within
from rosic.contracts.graph_topics import GraphRobot
from rosic.contracts.robot import LiveRobot, deliver_of
from rosic.core import messages
from rosic.core.i18n import said
from rosic.core.order import RestReport, Stop
from rosic.core.order_gate import too_late
from rosic.core.robot.profile import Presence
from rosic.errors import RobotOffline, RobotUnreachable, RosicError, StillMoves, StoreFault
from rosic.linker.pursuit import StopPursuit
from rosic.linker.robot_queue import QueuedOrder, RobotQueue, execute_live

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Callable, Coroutine, Iterable, Iterator, Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.graph_topics import GraphTopics
    from rosic.contracts.live_control import LiveControls
    from rosic.contracts.robot import Robot, Tell
    from rosic.contracts.store import StopLatch
    from rosic.core.identity import CommandId, PrincipalId
    from rosic.core.order import Order, Outcome
    from rosic.core.robot.file_transfer import FileForRobot, Receipt
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.core.robot.view import View, ViewKind
    from rosic.core.stop_registry import StopRegistry

log = logging.getLogger("rosic.linker")

CLEARED_WITHIN_S = 0.5
KEPT_WITHIN_S = 1.0
"""A stop file that hangs neither writes nor fails: nobody waits longer for it."""


LATCH_HANGS = said("The stop file does not answer.")
MUTE: Final = Presence(online=False)


class PolicyMoved(RosicError):
    """The policy or the time moved on since admission: the order is admitted once more (I8)."""

    code = "policy-moved"


class PolicyEpoch(Protocol):
    """The policy in force, as far as relaying asks for it: its number."""

    @property
    def epoch(self) -> int:
        """Return it; it grows with every replacement."""
        ...


class StopInProgress:
    """A stop under way: handed to every adapter already, rest not measured yet.

    Attributes:
        rests: One task per robot.
        latched: Done when the stop would survive a power cut; its result says whether.
    """

    __slots__ = ("latched", "rests")

    def __init__(
        self, rests: dict[RobotId, asyncio.Task[RestReport]], latched: asyncio.Task[bool]
    ) -> None:
        self.rests = rests
        self.latched = latched

    async def kept(self, clock: Clock) -> bool:
        """Return whether it would survive a power cut; False after `KEPT_WITHIN_S`, too."""
        return await done_within(clock, KEPT_WITHIN_S, (self.latched,)) and self.latched.result()


class Linker:
    """Hands orders and stops to the adapters of robots.

    Attributes:
        queues: Of each robot; whoever looks at one only looks.
        cancels: Empty as long as nobody has ended what they had under way.
        pursuit: Goes on with stops that were not confirmed.

    Args:
        clock: The machine's, by which orders expire.
        wall_ns: By which slots, grants and keys end. Asking it may move the policy on, when the
            machine's clock was set back.
        policy: In force; an order admitted under another one is not relayed.
    """

    def __init__(
        self,
        robots: Mapping[RobotId, Robot],
        stops: StopRegistry,
        latch: StopLatch,
        clock: Clock,
        wall_ns: Callable[[], int],
        policy: PolicyEpoch,
    ) -> None:
        self._policy = policy
        self.cancels = stops.cancels
        self._wall_ns = wall_ns
        self._robots = dict(robots)
        self.queues = {robot_id: RobotQueue(robot, clock) for robot_id, robot in robots.items()}
        self._stops = stops
        self._latch = latch
        self._clock = clock
        self._latching: BackgroundTasks[Any] = BackgroundTasks()
        self._clearing: BackgroundTasks[None] = BackgroundTasks()
        self._resting: BackgroundTasks[RestReport] = BackgroundTasks()
        self._mute: set[RobotId] = set()
        self.pursuit = StopPursuit(self._robots, self.presence, stops, clock)

    @property
    def epoch(self) -> int:
        """Return the number of the policy in force."""
        return self._policy.epoch

    def put(self, entry: QueuedOrder) -> bool:
        """Give an order to a robot's queue. Return whether it has its turn at once.

        If so, the caller serves the queue: ``dispatch``, then ``next``, until none is left.

        Raises:
            RobotBusy: Not taken in; the robot has not moved because of it.
        """
        return self.queues[entry.order.robot].put(entry)

    def next(self, robot_id: RobotId) -> QueuedOrder | None:
        """End a turn. Return whose turn it is now; None frees the robot."""
        return self.queues[robot_id].next()

    def clear(self, sentence: str) -> None:
        """Void everything that waits for any robot, with a reason."""
        for queue in self.queues.values():
            queue.void(sentence)

    def void(self, robot_id: RobotId, sentence: str) -> None:
        """Void everything that waits for one robot, with a reason."""
        self.queues[robot_id].void(sentence)

    def withdraw(self, robot_id: RobotId, cid: CommandId, sentence: str) -> None:
        """Void one order if it waits for a robot, with a reason."""
        self.queues[robot_id].withdraw(cid, sentence)

    def take_out(self, robot_id: RobotId, principal: PrincipalId) -> list[QueuedOrder]:
        """Take somebody's orders out that wait for a robot; whoever asked for it voids them."""
        return self.queues[robot_id].take_out(principal)

    def outdated(self, order: Order) -> bool:
        """Whether whoever gave an order has ended what they had under way since it was admitted."""
        permit = order.permit
        return permit.cancels < self._stops.cancelled(permit.principal, order.robot)

    def dispatch(
        self, order: Order, tell: Tell, controls: LiveControls | None = None
    ) -> Coroutine[Any, Any, Outcome]:
        """Relay an order whose turn it is; awaited, this returns what the robot really did.

        Args:
            order: Claimed, and not begun.
            tell: Takes its steps in.
            controls: What steers it, if it is live.

        Raises:
            PolicyMoved: At once. Not relayed; admit it once more, its turn is kept.
            OrderVoid: At once or awaited. The robot has not moved. A live order without controls,
                or for a robot that cannot be driven so, is void.
            RobotOffline: Awaited. The robot has not moved.
            RobotUnreachable: Awaited. It may or may not have moved.
        """
        permit, clock = order.permit, self._clock
        if clock.monotonic_ns() > order.deadline_ns or clock.wall_ns() > order.expires_ns:
            raise too_late(order)
        # Asked of every order: asking is also how a clock that was set back is noticed in time.
        if self._wall_ns() >= permit.until_ns or permit.epoch != self._policy.epoch:
            raise PolicyMoved(said("The rights have changed meanwhile."))
        robot = self._robots[order.robot]
        if self.queues[order.robot].replaces:
            return self.queues[order.robot].relay(order, tell, controls)
        if order.live:
            return execute_live(robot, order, tell, controls)
        return robot.execute(order, tell)

    def drives_live(self, robot: RobotId) -> bool:
        """Whether a robot can carry out live orders; no I/O."""
        return isinstance(self._robots[robot], LiveRobot)

    def graph_topics(self, robot: RobotId) -> GraphTopics | None:
        """Return the topics of the graph that a robot is on; None: it is on none."""
        link = self._robots[robot]
        return link.topics if isinstance(link, GraphRobot) else None

    def stop(self, robots: Iterable[RobotId], by: PrincipalId) -> StopInProgress:
        """Stop robots. On return the stop is latched in memory and handed to every adapter.

        Needs nothing but this process: no disk, no database, no queue (I10).
        """
        at_ns = self._clock.wall_ns()
        stops = [Stop(robot, self._stops.stop(robot, by, at_ns)) for robot in robots]
        rests: dict[RobotId, asyncio.Task[RestReport]] = {}
        for stop in stops:
            robot = self._robots[stop.robot]
            robot.gate.apply_stop(stop)
            rests[stop.robot] = self._brake(stop)
        latched = self._latching.begin(self._write_latch(stops))
        self._clearing.begin(self._clear(stops, latched))
        return StopInProgress(rests, latched)

    def _brake(self, stop: Stop) -> asyncio.Task[RestReport]:
        """Hand a stop to its adapter, and go on with it until it is confirmed."""
        # Whoever asked may be gone before it has come to rest.
        task = self._resting.begin(self._robots[stop.robot].stop(stop))
        self.pursuit.begin(stop, task)
        return task

    async def _clear(self, stops: Iterable[Stop], latched: asyncio.Task[bool]) -> None:
        """Tell what waited that it is void, after everything that makes it so.

        Ten thousand such answers take longer than a stop may. Meanwhile the gates refuse.
        """
        await asyncio.wait((latched,), timeout=CLEARED_WITHIN_S)
        for stop in stops:
            self.queues[stop.robot].clear(stop.generation)
            await asyncio.sleep(0)

    async def _write_latch(self, stops: Iterable[Stop]) -> bool:
        written = await asyncio.gather(
            *(self._latch.write(s.robot, s.generation, latched=True) for s in stops),
            return_exceptions=True,
        )
        return not any(isinstance(result, BaseException) for result in written)

    async def resume(self, robot_id: RobotId, generation: int) -> bool:
        """Undo a stop of a generation, if no later one has come. The robot does not move.

        Returns:
            False if a later stop has come: it stays stopped.

        Raises:
            StillMoves: It is measured to move; it stays stopped.
            RobotUnreachable: It is not there and was never seen at rest, or its side did not let go
                or did not answer; it stays stopped.
            StoreFault: The latch cannot be written, or does not answer in time; it stays stopped.
        """
        # A stop's own entry must not be written after the one that undoes it; and the entry comes
        # before the effect, so that a robot that moves again is never said to stay stopped.
        if not await done_within(self._clock, KEPT_WITHIN_S, self._latching):
            raise StoreFault(LATCH_HANGS)
        if self._stops[robot_id].generation != generation:
            return False
        if self.presence(robot_id).moves:
            raise StillMoves(messages.not_resumed_as_it_moves(self.profile(robot_id).shown))
        if self.pursuit.in_doubt(robot_id):
            raise RobotUnreachable(messages.not_resumed_in_doubt(self.profile(robot_id).shown))
        try:
            await self._let_go(robot_id, generation)
            await self._robots[robot_id].resume(generation)
        except BaseException:  # failed or cut off: on disk, too, it stays stopped
            holding = self._keep(self.hold_for_good(robot_id, generation))
            await done_within(self._clock, KEPT_WITHIN_S, (holding,))
            raise
        self._stops.resume(robot_id, generation)
        if self._stops[robot_id].latched:
            return False
        self.pursuit.end(robot_id)
        return True

    async def _let_go(self, robot_id: RobotId, generation: int) -> None:
        """Write that a robot is not stopped any more.

        Raises:
            StoreFault: Not written, or not in time; whatever becomes of it, what is written next
                says how it is.
        """
        writing = self._keep(self._latch.write(robot_id, generation, latched=False))
        if not await done_within(self._clock, KEPT_WITHIN_S, (writing,)):
            raise StoreFault(LATCH_HANGS)
        writing.result()

    def _keep(self, writing: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        """Begin to write an entry. The next resume waits for it: only the last entry counts."""
        task = self._latching.begin(writing)
        task.add_done_callback(_whatever_came_of_it)
        return task

    def hold(self, robot_id: RobotId) -> int:
        """Latch a robot for nobody: on return nothing of ours moves it any more."""
        generation = self._stops.stop(robot_id, "", self._clock.wall_ns())
        self._robots[robot_id].gate.apply_stop(Stop(robot_id, generation))
        return generation

    def halt(self, robot_id: RobotId) -> int:
        """Hold a robot, and bring it to rest: nobody knows what its last order does."""
        generation = self.hold(robot_id)
        self._brake(Stop(robot_id, generation))
        return generation

    def watch_stopped(self) -> None:
        """Bring robots to rest that were stopped before this run and are seen to move."""
        for robot_id in self._stops.latched():
            if robot_id not in self.pursuit:
                self.pursuit.begin(Stop(robot_id, self._stops[robot_id].generation), None)

    async def hold_for_good(self, robot_id: RobotId, generation: int) -> None:
        """Make a hold survive; one that cannot be written holds in memory all the same."""
        try:
            await self._latch.write(robot_id, generation, latched=True)
        except StoreFault:
            return

    def check_free(self, robot_id: RobotId) -> None:
        """See whether a robot would begin at once.

        Raises:
            RobotBusy: It is at work, and does not take more.
        """
        self.queues[robot_id].check_free()

    def current(self, robot_id: RobotId) -> Order | None:
        """Return the order whose turn it is at a robot; None while it is free."""
        entry = self.queues[robot_id].current
        return None if entry is None else entry.order

    def look(self, robot: RobotId, sight: ViewKind) -> AsyncGenerator[View, None]:
        """Yield what can be seen of a robot; see ``contracts.robot.Robot``."""
        return self._robots[robot].look(sight)

    async def deliver(self, robot: RobotId, robot_file: FileForRobot) -> Receipt:
        """Hand a file to a robot's side; see ``contracts.robot.deliver_of``.

        Raises:
            RobotOffline: Nothing was sent.
            RobotUnreachable: Its side may or may not have it.
        """
        deliver = deliver_of(self._robots[robot])
        if deliver is None:
            shown = self._robots[robot].profile.shown
            raise RobotOffline(said("{robot} cannot be handed files over its link.", robot=shown))
        return await deliver(robot_file)

    def presence(self, robot: RobotId) -> Presence:
        """Return what the robot's side last said; one whose link fails at it is not there."""
        link = self._robots[robot]
        try:
            said_last = link.presence()
        except Exception:  # of one link: whoever looks at all robots must go on
            if robot not in self._mute:
                self._mute.add(robot)
                log.exception("the link of %s cannot say how it is; it counts as not there", robot)
            return MUTE
        self._mute.discard(robot)
        return said_last

    def profile(self, robot: RobotId) -> Profile:
        """Return a robot's profile."""
        return self._robots[robot].profile

    def entries(self, robot: RobotId) -> Iterator[QueuedOrder]:
        """Go through what a robot does and what waits for it."""
        return self.queues[robot].entries()

    def waiting(self, robot: RobotId) -> int:
        """Return how many orders wait for a robot."""
        return len(self.queues[robot])

    def add_robot(self, robot: Robot) -> None:
        """Route to one more robot from now on."""
        self._robots[robot.profile.id] = robot
        self.queues[robot.profile.id] = RobotQueue(robot, self._clock)


def _whatever_came_of_it(task: asyncio.Task[None]) -> None:
    """Look at how a write ended that nobody waits for any more: it is no news then."""
    if not task.cancelled():
        task.exception()
