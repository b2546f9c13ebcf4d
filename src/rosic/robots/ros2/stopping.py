"""Bringing a robot to rest: everything that could help, together, until rest is measured."""

from __future__ import annotations

import asyncio
import logging
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

from rosic.core.i18n import said
from rosic.core.time_units import SECOND_NS
from rosic.errors import RobotUnreachable, RosicError
from rosic.robots.ros2.bindings.answers import BindingAnswer, check_fields
from rosic.robots.ros2.client.topics import TopicQos
from rosic.robots.ros2.errors import BadName, NotSent

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from rosic.contracts.clock import Clock
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.client.services import ServiceLink
    from rosic.robots.ros2.client.topics import Publisher
    from rosic.robots.ros2.messages.encode import Values
    from rosic.robots.ros2.profile import Ros2Profile, StopBinding
    from rosic.robots.ros2.telemetry import Measurements

_log = logging.getLogger(__name__)

AGAIN_EVERY_S = 0.2
LOOK_EVERY_S = 0.05
# What has not answered by then does not keep a measured rest from being believed.
ANSWER_WITHIN_S = 1.0
RELEASE_WITHIN_S = 2.0
CANCEL_GOALS = "action_msgs/srv/CancelGoal"


class RestResult(NamedTuple):
    """How it went: whether rest was measured, and after how many seconds, or giving up.

    Attributes:
        moves: It was measured to move at the end; False when nothing was measured, too.
        declined: What its own stop answered, if that was no success.
        unanswered: It has a stop of its own, which has not answered, or is not there.
    """

    confirmed: bool
    seconds: float
    moves: bool = False
    declined: str = ""
    unanswered: bool = False


class StopController:
    """Everything that stops one robot: the cancelling of goals, zero velocities, its own stop.

    All goals of its actions are cancelled, also those that another gateway, or this one before a
    crash, has sent: a robot that is told to stop stops.

    Attributes:
        holds: Its own stop was called, and holds until it is released; None: not known, as it may
            hold since an earlier run.
        zeros: Publishers of velocities, by topic as the profile names it.
        calls: Services: the robot's own stop, and the cancelling of each of its actions.
    """

    def __init__(self, profile: Ros2Profile, measurements: Measurements, clock: Clock) -> None:
        self.measured = measurements
        self.clock = clock
        self.calls: list[ServiceLink] = []
        self._requests: dict[ServiceLink, Values] = {}
        self._answers: dict[ServiceLink, BindingAnswer] = {}
        self._profile = profile
        self.holds: bool | None = None if self.releases else False
        self.zeros: dict[str, Publisher] = {}

    def types(self) -> set[str]:
        """Return the types of message that stopping takes."""
        found = set(_zeros(self._profile).values())
        stop = self._profile.stop
        if stop is not None and stop.service:
            found.add(stop.type)
        return found | ({CANCEL_GOALS} if _actions(self._profile) else set())

    async def open(self, runtime: RosRuntime) -> None:
        """Open the ways to stop the robot, before anything can move it.

        Raises:
            BadName: A name or a type is wrong.
        """
        for topic, type_name in _zeros(self._profile).items():
            # Of velocities only the newest counts: none from before a break is sent again after it.
            self.zeros[topic] = await runtime.publisher(topic, type_name, TopicQos(depth=1))
        stop = self._profile.stop
        if stop is not None and stop.service:
            cls = runtime.types.service(stop.type)
            check_stop(cls.Request, stop)
            check_fields(cls.Request, stop.release)
            link = await runtime.service(stop.service, stop.type)
            self.calls.append(link)
            self._requests[link] = stop.request
            self._answers[link] = BindingAnswer(cls.Response, stop)
        for action in _actions(self._profile):
            name = f"{action}/_action/cancel_goal"
            self.calls.append(await runtime.service(name, CANCEL_GOALS))

    async def close(self) -> None:
        """Close them."""
        ends: list[Publisher | ServiceLink] = [*self.zeros.values(), *self.calls]
        self.zeros.clear()
        self.calls.clear()
        self._requests.clear()
        self._answers.clear()
        for end in ends:
            await end.close()

    @property
    def own(self) -> ServiceLink | None:
        """The robot's own stop, if it has one."""
        return next(iter(self._requests), None)

    def request(self, link: ServiceLink) -> Values:
        """Return what one of the services is called with."""
        return self._requests.get(link, {})

    def declined(self, link: ServiceLink, response: RosObject) -> str | None:
        """Return what its own stop says against success, "" if nothing; None: it is another."""
        answer = self._answers.get(link)
        if answer is None:
            return None
        if answer.succeeded(response):
            return ""
        return answer.words(response) or said("it did not say why")

    def asked(self, link: ServiceLink) -> None:
        """Remember that its own stop holds, if that is what it does: it is being called."""
        self.holds = self.holds or (link is self.own and self.releases)

    @property
    def releases(self) -> bool:
        """Whether its own stop holds until it is released."""
        return self._profile.stop is not None and bool(self._profile.stop.release)

    async def release(self) -> None:
        """Release its own stop, where that holds; the robot does not move because of it.

        Raises:
            RobotUnreachable: It may hold still: nobody answered, or the answer is no success.
        """
        self._check_released(await self._release())

    async def release_for_order(self, stopped: Callable[[], bool], found_within_s: float) -> None:
        """Release its own stop before an order, where that holds or may hold since an earlier run.

        A stop of which it is not known whether it holds may decline: the order is tried then, and
        whoever holds still declines that.

        Args:
            stopped: Whether it is stopped by somebody: what holds then is not released.
            found_within_s: How long to look for whoever releases it.

        Raises:
            RobotUnreachable: It may hold still, as in `release`.
        """
        if self.holds is False or stopped():
            return
        try:
            declined = await self._release(stopped, found_within_s)
        except RobotUnreachable:
            if not stopped():
                raise
            return
        if self.holds:
            self._check_released(declined)
        elif declined:
            _log.info("the stop of %s releases nothing: %s", self._profile.id, declined)

    def _check_released(self, declined: str) -> None:
        if declined:
            shown = self._profile.shown
            raise RobotUnreachable(
                said("The stop of {shown} was not released: {why}.", shown=shown, why=declined)
            )

    async def _release(
        self, stopped: Callable[[], bool] = lambda: False, found_within_s: float = 0.0
    ) -> str:
        """Release its own stop, where that holds. Return what it says against it, "" if nothing."""
        link, stop, shown = self.own, self._profile.stop, self._profile.shown
        if link is None or stop is None or not stop.release:
            return ""

        def leave() -> None:
            if stopped():  # while whoever releases it was looked for
                raise NotSent(f"{self._profile.id} was stopped meanwhile; nothing was sent.")

        try:
            response = await link.call(
                stop.release,
                timeout_s=RELEASE_WITHIN_S,
                found_within_s=found_within_s,
                urgent=True,
                leave=leave,
            )
        except RosicError as fault:
            _log.warning("the stop of %s was not released: %s", self._profile.id, fault)
            raise RobotUnreachable(
                said("The stop of {shown} has not answered to its release.", shown=shown)
            ) from fault
        declined = self.declined(link, response) or ""
        if not declined:
            self.holds = False
        return declined

    def zero(self) -> None:
        """Send zero wherever velocities are sent. It waits for nobody and never raises."""
        for publisher in self.zeros.values():
            try:
                publisher.publish({})
            except RosicError as fault:
                _log.warning("zero was not sent to %s: %s", self._profile.id, fault)

    async def apply(
        self, quiet: Callable[[], bool] = lambda: True, *, limit_s: float | None = None
    ) -> RestResult:
        """Apply everything, again and again, until rest is measured or the time is over.

        Rest counts when it was measured after the robot's side has answered, or has had
        `ANSWER_WITHIN_S` to answer: before that, it may not have begun to move yet. A robot whose
        rest cannot be measured is told once that it answers, and not confirmed. Never raises.

        Args:
            quiet: Whether the order under way has come to its end; waited for likewise.
            limit_s: Instead of the profile's ``rest_timeout_s``.
        """
        limit_s = self._profile.rest_timeout_s if limit_s is None else limit_s
        attempt = _Attempt(self, quiet)
        try:
            return await attempt.run(limit_s)
        finally:
            attempt.end()

    async def measure(self, begun_ns: int, limit_s: float, *, again: bool) -> RestResult:
        """Only wait until rest is measured; seconds count from ``begun_ns``.

        Args:
            begun_ns: Rest counts that was measured after it.
            limit_s: Give up then.
            again: Send zero once more when a break is over, and count rest from there.
        """
        since_ns, break_watch = begun_ns, BreakWatch(self.measured, self.clock)
        while True:
            now_ns = self.clock.monotonic_ns()
            past_s = (now_ns - begun_ns) / SECOND_NS
            if break_watch.over() and again:
                self.zero()
                since_ns = now_ns
            if self.measured.at_rest(since_ns):
                return RestResult(confirmed=True, seconds=past_s)
            if past_s >= limit_s or not self.measured.measures_rest:
                return RestResult(confirmed=False, seconds=past_s)
            await self.measured.next_word(AGAIN_EVERY_S)


class BreakWatch:
    """Notices the end of a break: ROSIC stood still, or the robot's side is heard again.

    What was sent while it lasted may be lost, and what is said first may be of before it.
    """

    def __init__(self, measured: Measurements, clock: Clock) -> None:
        self._measured = measured
        self._clock = clock
        self._looked_ns = clock.monotonic_ns()
        self._silent = False

    def over(self) -> bool:
        """Tell whether a break has ended since the last look."""
        now_ns, before_ns = self._clock.monotonic_ns(), self._looked_ns
        age_s, was_silent = self._measured.judged_age_s(), self._silent
        self._looked_ns = now_ns
        self._silent = age_s is not None and age_s > self._measured.within_s
        stood_still = now_ns - before_ns > self._measured.within_s * SECOND_NS
        return stood_still or (was_silent and not self._silent)


class _Attempt:
    """One attempt to bring a robot to rest."""

    def __init__(self, stop_controller: StopController, quiet: Callable[[], bool]) -> None:
        self._stop_controller = stop_controller
        self._quiet = quiet
        self._asking: dict[ServiceLink, asyncio.Task[bool]] = {}
        self._answered: set[ServiceLink] = set()
        self._declined = ""
        self._break_watch = BreakWatch(stop_controller.measured, stop_controller.clock)
        self._begun_again = False
        self._asked_ns = stop_controller.clock.monotonic_ns()
        self._settled_ns: int | None = None
        self._round_ns: int | None = None

    async def run(self, limit_s: float) -> RestResult:
        """Go round until rest is measured, or the time is over."""
        resting = await self._run(limit_s)
        own = self._stop_controller.own
        unanswered = own is not None and own not in self._answered
        return resting._replace(declined=self._declined, unanswered=unanswered)

    async def _run(self, limit_s: float) -> RestResult:
        measured, clock = self._stop_controller.measured, self._stop_controller.clock
        begun_ns = clock.monotonic_ns()
        while True:
            now_ns = clock.monotonic_ns()
            past_s = (now_ns - begun_ns) / SECOND_NS
            if self._break_watch.over():
                self._begin_again(now_ns)
            if self._round_ns is None or now_ns - self._round_ns >= AGAIN_EVERY_S * SECOND_NS:
                self._round_ns = now_ns
                self._stop_controller.zero()
                self._ask()
            self._settle(now_ns)
            if self._settled_ns is not None:
                if measured.at_rest(self._settled_ns):
                    return RestResult(confirmed=True, seconds=past_s)
                if not measured.measures_rest:
                    return RestResult(confirmed=False, seconds=past_s)
            if past_s >= limit_s:
                moves = measured.at_rest(max(begun_ns, measured.stale_ns())) is False
                return RestResult(confirmed=False, seconds=past_s, moves=moves)
            await self._wait()

    def end(self) -> None:
        """Leave nothing running."""
        for task in self._asking.values():
            task.cancel()

    def _begin_again(self, now_ns: int) -> None:
        """Send and ask everything afresh, and believe no rest from before that.

        Later ones only send: what reports more rarely than it should is heard again each time.
        """
        self._round_ns = None
        if self._begun_again:
            return
        self._begun_again = True
        self.end()
        self._asking.clear()
        self._answered.clear()
        self._asked_ns = now_ns
        self._settled_ns = None

    def _settle(self, now_ns: int) -> None:
        """Believe rest from now on, once what was asked has answered or had its time to."""
        waited_out = now_ns - self._asked_ns >= ANSWER_WITHIN_S * SECOND_NS
        if self._settled_ns is None and (waited_out or self._heard_out()):
            self._settled_ns = now_ns

    def _heard_out(self) -> bool:
        """Tell whether everything that is there has answered, and the order has ended."""
        calls = self._stop_controller.calls
        there = {call for call in calls if call.ready()}
        somebody = bool(self._answered) or not calls
        return somebody and there <= self._answered and self._quiet()

    def _ask(self) -> None:
        """Call what is not being called already."""
        for link in self._stop_controller.calls:
            task = self._asking.get(link)
            if task is None or task.done():
                self._asking[link] = asyncio.create_task(self._call(link))

    async def _call(self, link: ServiceLink) -> bool:
        self._stop_controller.asked(link)
        try:
            response = await link.call(
                self._stop_controller.request(link), timeout_s=ANSWER_WITHIN_S, urgent=True
            )
        except NotSent:
            return False  # nobody is there: what can be done about it is done again and again
        except RosicError as fault:
            _log.warning("while stopping: %s", fault)
            return False
        self._hear(link, response)
        self._answered.add(link)
        return True

    def _hear(self, link: ServiceLink, response: RosObject) -> None:
        """Take in what a service answers; what speaks against it is logged once."""
        declined = self._stop_controller.declined(link, response)
        if declined and declined != self._declined:
            _log.warning("while stopping: %s answered that it failed: %s", link.name, declined)
        if declined is not None:
            self._declined = declined

    async def _wait(self) -> None:
        """Wait for an answer or for the next measurement, a moment at most."""
        word = asyncio.create_task(self._stop_controller.measured.next_word(LOOK_EVERY_S))
        calls = [task for task in self._asking.values() if not task.done()]
        events: list[asyncio.Task[Any]] = [word, *(calls if self._settled_ns is None else ())]
        try:
            await asyncio.wait(events, timeout=LOOK_EVERY_S, return_when=asyncio.FIRST_COMPLETED)
        finally:
            word.cancel()


def check_stop(cls: RosObject, stop: StopBinding) -> None:
    """Make sure that everything a stop says to its service is said by the profile.

    Args:
        cls: Of the request.
        stop: As the profile has it.

    Raises:
        BadName: A field is not there, or is left to what it says by itself.
    """
    check_fields(cls, stop.request)
    fields = {field.partition(".")[0] for field in stop.request}
    for field in cls.get_fields_and_field_types():
        if field not in fields:
            raise BadName(
                f"The stop {stop.service} of the type {stop.type} asks for {field!r}, and nothing "
                "says what it is: by itself it may release a brake.",
                hint=f"Write what stops the robot: stop: {{ request: {{ {field}: ... }} }}.",
            )


def _zeros(profile: Ros2Profile) -> dict[str, str]:
    """Return the topics that take a zero velocity, and their types."""
    found: dict[str, str] = {}
    if profile.stop is not None and profile.stop.zero:
        found[profile.stop.zero] = profile.stop.zero_type
    for skill in profile.skills.values():
        if skill.topic is not None and skill.topic.stream_hz > 0:
            found[skill.topic.name] = skill.topic.type
    return found


def _actions(profile: Ros2Profile) -> list[str]:
    found = (skill.action.name for skill in profile.skills.values() if skill.action is not None)
    return list(dict.fromkeys(found))


async def to_the_end(task: asyncio.Task[RestResult]) -> RestResult:
    """Wait for a task that must not be cut short, however often the waiting is cancelled."""
    while not task.done():
        with suppress(asyncio.CancelledError):
            await asyncio.shield(task)
    return task.result()
