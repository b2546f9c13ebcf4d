"""The thread that ROS runs on, and the two ways across: work goes in, answers come out.

rclpy is confined to that thread: what opens, asks or sends is carried there, and what comes back
is handed to the event loop. This is more than tidiness. In rclpy 9.1 an action client that sends
from another thread can miss the answer to its own goal (it registers the goal twice, and the
answer may come in between), and the robot moves while the caller believes that nobody replied.
Only publishing is done from the event loop, because a zero velocity must wait for nobody.
"""

from __future__ import annotations

import asyncio
import atexit
import logging
import threading
from collections import deque
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from rosic.robots.ros2.client.rclpy_import import load_ros, make_executor
from rosic.robots.ros2.errors import NoAnswer, NotSent

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.robots.ros2.client.rclpy_import import RclpyModules, RosObject


# ---- from the ROS thread to the event loop ----
# Bounded, in order, one wake-up for a burst.

_PER_TURN = 256


class LoopBridge:
    """Carries callables from any thread to the event loop.

    A wake-up of the loop costs a system call, so one is made for a whole burst. Sources keep what
    they have to say themselves and stand here at most once, so the length is bounded by their
    number; ``limit`` is the fence behind that rule.

    Attributes:
        refused: How many were turned away because the limit was reached.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, limit: int = 8192) -> None:
        self._loop = loop
        self._limit = limit
        self._waiting: deque[Callable[[], None]] = deque()
        self._awake = False
        self.refused = 0

    def offer(self, deliver: Callable[[], None]) -> bool:
        """Have ``deliver`` called on the loop; from any thread.

        Returns:
            False when it will not be called: too many are waiting, or the loop is closed.
        """
        if len(self._waiting) >= self._limit:
            self.refused += 1
            return False
        self._waiting.append(deliver)
        # Set after the append and cleared before the first take: whoever sees it still set has
        # appended early enough to be taken.
        if self._awake:
            return True
        self._awake = True
        try:
            self._loop.call_soon_threadsafe(self._drain)
        except RuntimeError:
            self._waiting.clear()
            return False
        return True

    def _drain(self) -> None:
        """Deliver what waits, at most so many at a time: the loop has other work."""
        self._awake = False
        try:
            for _ in range(min(len(self._waiting), _PER_TURN)):
                self._waiting.popleft()()
        finally:  # whatever one of them raised, the rest is delivered
            if self._waiting and not self._awake:
                self._awake = True
                self._loop.call_soon(self._drain)


# ---- the ROS thread ----


_log = logging.getLogger(__name__)

T = TypeVar("T")

_TURN_S = 0.25
_PAUSE_AFTER_FAULT_S = 0.05
_CLOSING_S = 5.0
_MAX_UNANSWERED = 256


class RosThread:
    """One ROS 2 context, node and executor, driven by a thread of their own.

    Attributes:
        ros: ROS 2 itself; there once the thread was started.
        node: rclpy's node. To be touched on the ROS thread only.
        faults: How often a turn ended in an exception; the thread goes on afterwards.
    """

    ros: RclpyModules
    node: RosObject

    def __init__(self, node_name: str, domain_id: int | None) -> None:
        self.faults = 0
        self._node_name = node_name
        self._domain_id = domain_id
        self._loop = asyncio.get_running_loop()
        self._handover = LoopBridge(self._loop)
        self._pending: set[asyncio.Future[RosObject]] = set()
        self._unanswered: deque[RosObject] = deque()
        self._stopping = threading.Event()
        self._alive = False
        self._context: RosObject = None
        self._executor: RosObject = None
        self._thread = threading.Thread(target=self._spin, name="ros2", daemon=True)

    @property
    def alive(self) -> bool:
        """Whether it runs. It ends with `close`, or when ROS shuts the context down."""
        return self._alive

    async def start(self) -> None:
        """Join the graph.

        Raises:
            RosMissing: There is no ROS 2 here.
            NotSent: ROS 2 is here and would not start.
        """
        await asyncio.to_thread(self._start)

    async def close(self) -> None:
        """Leave the graph. Whoever still waits for an answer gets `NotSent`. May be repeated."""
        await asyncio.to_thread(self._stop)
        self._release()

    async def run(self, work: Callable[[], T], *, timeout_s: float = 5.0) -> T:
        """Have ``work`` done on the ROS thread and return what it returns, or raise what it raises.

        It should take microseconds: every robot waits for it.

        Raises:
            NotSent: The link is closed, or the ROS thread did not come to it in time.
        """
        answer: asyncio.Future[T] = self._loop.create_future()

        def job() -> None:
            if answer.cancelled():
                return
            try:
                done = partial(_give, answer, work())
            except Exception as error:  # noqa: BLE001 - it belongs to whoever asked
                done = partial(_fail, answer, error)
            self.hand_over(done)

        self.post(job)
        try:
            return await self._wait(answer, timeout_s)
        except TimeoutError:
            raise NotSent("ROS 2 is too busy to take this; nothing was sent.") from None

    async def ask(
        self,
        send: Callable[[], RosObject],
        what: str,
        *,
        timeout_s: float | None,
        late: Callable[[RosObject], None] | None = None,
    ) -> RosObject:
        """Send something that will be answered, and return the answer.

        Args:
            send: Called on the ROS thread; returns rclpy's future.
            what: Who is asked, for the sentence.
            timeout_s: How long to wait; None for an answer that may take as long as a motion.
            late: Called on the loop with an answer that comes after the caller has gone.

        Raises:
            NotSent: The link is closed, or ROS would not send it.
            NoAnswer: Sent, and nothing came in time.
        """
        answer: asyncio.Future[RosObject] = self._loop.create_future()
        question: list[RosObject] = []

        def begin() -> None:
            if answer.cancelled():
                return
            try:
                question.append(send())
            except Exception as error:  # noqa: BLE001 - named for whoever asked
                self.hand_over(partial(_fail, answer, _not_taken(what, error)))
                return
            question[0].add_done_callback(
                lambda done: self.hand_over(partial(_settle, answer, done, late))
            )

        self.post(begin)
        try:
            return await self._wait(answer, timeout_s)
        except TimeoutError:
            _pass_on_late(answer, late)
            raise NoAnswer(f"{what} did not answer within {timeout_s:g} s.") from None
        except asyncio.CancelledError:
            _pass_on_late(answer, late)
            raise
        finally:
            if answer.cancelled() and self._alive:
                self.post(partial(self._give_up, question, wait_on=late is not None))

    def post(self, job: Callable[[], object]) -> None:
        """Have ``job`` called on the ROS thread, soon. It must not raise.

        Raises:
            NotSent: The link is closed.
        """
        if not self._alive:
            raise NotSent("The link to ROS 2 is closed; nothing was sent.")
        self._executor.create_task(job)

    def hand_over(self, deliver: Callable[[], None]) -> bool:
        """Have ``deliver`` called on the event loop; from any thread."""
        return self._handover.offer(deliver)

    def _give_up(self, question: list[RosObject], *, wait_on: bool) -> None:
        """Take back what nobody waits for; rclpy would keep it for ever. On the ROS thread."""
        if wait_on:  # a late answer still matters; how many are waited for is bounded
            self._unanswered.extend(question)
            question = []
            while len(self._unanswered) > _MAX_UNANSWERED:
                question.append(self._unanswered.popleft())
        for asked in question:
            asked.cancel()

    async def _wait(self, answer: asyncio.Future[T], timeout_s: float | None) -> T:
        self._pending.add(answer)
        try:
            async with asyncio.timeout(timeout_s):
                return await answer
        finally:
            self._pending.discard(answer)

    def _release(self) -> None:
        for answer in tuple(self._pending):
            _fail(answer, NoAnswer("The link to ROS 2 was closed before an answer came."))

    def _start(self) -> None:
        ros = self.ros = load_ros()
        self._context = ros.rclpy.Context()
        try:
            ros.rclpy.init(
                context=self._context,
                domain_id=self._domain_id,
                # Signals belong to the gateway: rclpy would shut the context down in the middle of
                # bringing robots to rest.
                signal_handler_options=ros.signals.SignalHandlerOptions.NO,
            )
            self.node = ros.node.Node(
                self._node_name,
                context=self._context,
                use_global_arguments=False,
                start_parameter_services=False,
            )
            self._executor = make_executor(ros, self._context)
            self._executor.add_node(self.node)
        except Exception as error:
            self._context.try_shutdown()
            raise NotSent(f"ROS 2 did not start: {error}") from error
        self._alive = True
        self._thread.start()
        # A thread inside rclpy while the interpreter goes down takes the process with it.
        atexit.register(self._stop)

    def _spin(self) -> None:
        """Turn after turn: `spin()` of the events executor delivered nothing when tried."""
        ended = self.ros.executors.ExternalShutdownException
        while not self._stopping.is_set():
            try:
                self._executor.spin_once(timeout_sec=_TURN_S)
            except ended:
                break
            except Exception:  # noqa: BLE001 - one broken message must not end every robot's link
                self.faults += 1
                if self.faults & (self.faults - 1) == 0:  # the 1st, 2nd, 4th, 8th
                    _log.exception("a turn of the ROS thread failed (%d so far)", self.faults)
                self._stopping.wait(_PAUSE_AFTER_FAULT_S)
        self._alive = False
        if not self._stopping.is_set():
            _log.error("ROS 2 has shut down under the gateway; its robots are out of reach")
            self.hand_over(self._release)

    def _stop(self) -> None:
        """Executor, thread, node, context: in any other order rclpy hangs."""
        atexit.unregister(self._stop)
        if self._stopping.is_set() or self._executor is None:
            return
        self._stopping.set()
        if self._alive:
            self._executor.create_task(_nothing)  # ends the turn that is waiting
        self._thread.join(_CLOSING_S)
        self._alive = False
        if self._thread.is_alive():
            _log.error("the ROS thread did not end within %g s; it is left behind", _CLOSING_S)
            return
        self._executor.remove_node(self.node)
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()


def _nothing() -> None:
    pass


def _give(answer: asyncio.Future[T], value: T) -> None:
    if not answer.done():
        answer.set_result(value)


def _fail(answer: asyncio.Future[T], error: Exception) -> None:
    if not answer.done():
        answer.set_exception(error)


def _settle(
    answer: asyncio.Future[RosObject], done: RosObject, late: Callable[[RosObject], None] | None
) -> None:
    """Pass on what rclpy's future holds."""
    error = done.exception()
    if error is not None:
        _fail(answer, error)
    elif done.cancelled():
        return
    elif not answer.done():
        answer.set_result(done.result())
    elif late is not None:
        late(done.result())


def _pass_on_late(
    answer: asyncio.Future[RosObject], late: Callable[[RosObject], None] | None
) -> None:
    """Pass on what was answered in the very turn in which whoever asked was cut off."""
    answered = answer.done() and not answer.cancelled() and answer.exception() is None
    if answered and late is not None:
        late(answer.result())


def _not_taken(what: str, error: Exception) -> NotSent:
    fault = NotSent(f"ROS 2 did not take the message for {what}; nothing was sent.")
    fault.__cause__ = error
    return fault


# ---- both clocks at once ----

# Two readings one after the other take less than a microsecond, unless somebody else was given the
# processor in between: robots that begin together would then begin apart by so much.
CLOSE_NS = 20_000
LOOKS = 20


def ahead_ns(wall_ns: Callable[[], int], monotonic_ns: Callable[[], int]) -> int:
    """Return by how much the wall clock is ahead of the monotonic one.

    The wall clock is read between two looks at the other; of some tries the closest counts.
    """
    closest_ns = ahead = 0
    for look in range(LOOKS):
        before_ns = monotonic_ns()
        now_ns = wall_ns()
        took_ns = monotonic_ns() - before_ns
        if look == 0 or took_ns < closest_ns:
            closest_ns, ahead = took_ns, now_ns - before_ns - took_ns // 2
        if closest_ns < CLOSE_NS:
            break
    return ahead
