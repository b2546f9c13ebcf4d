"""``--try ROBOT``: the robot moves a little, and its stop and its watchdog are measured."""

from __future__ import annotations

import asyncio
from math import ceil
from typing import TYPE_CHECKING, NamedTuple

from rosic.app.builder import latch_of
from rosic.app.robot_startup import stops_of
from rosic.app.setup.diagnostics_checks import DiagnosticFinding, FindingVerdict
from rosic.config.plugins import robot_factory
from rosic.config.profiles import known_units
from rosic.contracts.robot import DescribesTelemetry, SilenceTest
from rosic.core.identity import COMMAND_ID_BYTES, OPERATOR, command_id
from rosic.core.language import Vocabulary
from rosic.core.language.command import NO_COMMANDS
from rosic.core.order import Order, OrderEnding, OrderStage, Outcome, Permit, RestReport, Stop
from rosic.core.order_gate import OrderGate
from rosic.core.policy.scope import RESUME
from rosic.core.records import Claimed, Concluded, Resumed, Stopped, Told
from rosic.errors import RosicError
from rosic.robots.ros2.profile import Ros2Profile
from rosic.robots.ros2.profile_checks import enough_s
from rosic.stores.database import DatabaseStore

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from rosic.app.config import Config
    from rosic.contracts.clock import Clock, Entropy
    from rosic.contracts.robot import Robot
    from rosic.contracts.store import StopLatch, Store
    from rosic.core.robot.profile import Profile
    from rosic.core.robot.skill import Argument, Skill

THERE_WITHIN_S = 5.0
# Others who report the same are found, and are heard, within this.
DOUBTED_WITHIN_S = 3.0
# What shows rest is listened to for so long, and has to come so many times within its deadline.
LISTENED_S = 6.0
TIMES_WITHIN = 1.5
MOVING_WITHIN_S = 2.0
UP_TO_SPEED_S = 0.5
LIVES_S = 10.0
EVERY_S = 0.02
# Slow enough to be harmless in a free space, fast enough to be told from rest.
SLOW_M_S = 0.1
SLOW_RAD_S = 0.2
STREAM_S = 2.0
# Coming to rest takes a moment after the watchdog has barked, even from a slow drive.
BRAKING_S = 0.5
# What a profile may say.
WATCHDOG_AT_MOST_S = 5.0


class _Drive(NamedTuple):
    """A slow drive that was ended by a stop.

    Attributes:
        rest: What came of the stop.
        seen: It was measured to move.
        fault: Why no velocity was sent; empty if one was.
    """

    rest: RestReport
    seen: bool
    fault: str


class StopTest:
    """One robot, opened by itself, with the record open so that no gateway can start meanwhile."""

    def __init__(
        self,
        profile: Profile,
        robot: Robot,
        store: Store,
        latch: StopLatch,
        clock: Clock,
        entropy: Entropy,
    ) -> None:
        self._profile = profile
        self._robot = robot
        self._store = store
        self._latch = latch
        self._clock = clock
        self._entropy = entropy
        self._skill = streaming_skill(profile)
        self._confirmed = False

    async def run(self) -> AsyncIterator[DiagnosticFinding]:
        """Measure, one thing after another."""
        hindered = await self._hindered()
        if hindered is not None:
            yield hindered
            return
        about = self._profile.id
        for value in self._guessed():
            text = (
                f"{value}: it reports more than 1, and ROS defines a fraction of 1: read as per "
                f"cent, which is not known again after a start; write full: 100 in its telemetry"
            )
            yield DiagnosticFinding(about, FindingVerdict.LOOK, text)
        before, good = self._robot.gate.generation, True
        try:
            for measure in (self._stop, self._watchdog):
                measured = await measure()
                yield measured
                good = good and measured.verdict is not FindingVerdict.LOOK
            if good:
                yield await self._go_on()
        except RosicError as error:
            yield DiagnosticFinding(about, FindingVerdict.LOOK, str(error))
            good = False
        if not good and self._robot.gate.generation > before:
            text = f"it stays stopped, also after a start, until somebody says: resume {about}"
            yield DiagnosticFinding(about, FindingVerdict.LOOK, text)

    async def _hindered(self) -> DiagnosticFinding | None:
        """Return why it is not moved; None where nothing speaks against it."""
        about, robot = self._profile.id, self._robot
        await self._until(lambda: robot.presence().online is True, THERE_WITHIN_S)
        if robot.presence().online is False:
            text = f"{self._profile.shown} is not there; nothing was measured"
            return DiagnosticFinding(about, FindingVerdict.LOOK, text)
        if robot.gate.latched:
            text = f"{self._profile.shown} is stopped, so it was not moved; resume it first"
            return DiagnosticFinding(about, FindingVerdict.NOT_MEASURED, text)
        if not self._profile.measures_rest:
            return None
        seldom = await self._seldom()
        if seldom:
            return DiagnosticFinding(about, FindingVerdict.LOOK, f"{seldom}; it was not moved")
        await self._until(lambda: bool(robot.presence().doubt), DOUBTED_WITHIN_S)
        doubt = robot.presence().doubt
        if doubt:
            text = f"whether it rests is not measured: {doubt}; it was not moved"
            return DiagnosticFinding(about, FindingVerdict.LOOK, text)
        return None

    async def _go_on(self) -> DiagnosticFinding:
        """Undo the stop of this trial, on disk first."""
        about = self._profile.id
        generation, at_ns = self._robot.gate.generation, self._clock.wall_ns()
        cid = command_id(OPERATOR, RESUME, about, str(generation), str(at_ns))
        await self._store.write(
            Resumed(cid=cid, robot=about, generation=generation, principal=OPERATOR, at_ns=at_ns)
        )
        await self._latch.write(about, generation, latched=False)
        return DiagnosticFinding(
            about, FindingVerdict.GOOD, "resumed: it was stopped only to be measured"
        )

    def _guessed(self) -> tuple[str, ...]:
        self._robot.presence()  # reads everything
        return self._robot.guessed() if isinstance(self._robot, DescribesTelemetry) else ()

    async def _seldom(self) -> str:
        """Say what to write where what shows rest comes more rarely than the profile allows."""
        profile, robot = self._profile, self._robot
        at_rest = profile.at_rest if isinstance(profile, Ros2Profile) else None
        if at_rest is None or not isinstance(robot, DescribesTelemetry):
            return ""
        every_s = await robot.rest_every_s(LISTENED_S)
        if every_s is None:
            return f"at_rest: {at_rest.topic} was not heard twice within {LISTENED_S:g} s"
        if every_s * TIMES_WITHIN <= at_rest.within_s:
            return ""
        text = (
            f"at_rest: heard every {every_s:.2g} s; within_s {at_rest.within_s:g} is too short: "
            f"write within_s: {enough_s(every_s):.1f}"
        )
        if every_s * TIMES_WITHIN > self._profile.link.heartbeat_s:
            text += f", and heartbeat_s: {enough_s(every_s):.1f} in link"
        return text

    async def _stop(self) -> DiagnosticFinding:
        drive = await self._move_until_stopped() if self._skill is not None else None
        rest = drive.rest if drive is not None else await self._apply_stop()
        moved = drive is not None and drive.seen
        how = "from a slow drive" if moved else "it was not moving"
        if drive is not None and not moved:
            how = drive.fault or "it was sent velocities, and not measured to move"
        what = (
            f"at rest after {rest.seconds:.2f} s"
            if rest.confirmed
            else f"not confirmed within {rest.seconds:.1f} s"
        )
        if rest.declined:
            what += f"; its own stop answered that it failed: {rest.declined}"
        elif rest.unanswered:
            what += "; its own stop did not answer"
        answered = not rest.declined and not rest.unanswered
        good = rest.confirmed and answered and (drive is None or moved)
        verdict = FindingVerdict.GOOD if good else FindingVerdict.LOOK
        return DiagnosticFinding(self._profile.id, verdict, f"stop: {what} ({how})")

    async def _move_until_stopped(self) -> _Drive:
        """Let it move slowly and stop it."""
        order, heard = await self._claim(), set[OrderStage]()
        moving = asyncio.create_task(
            self._robot.execute(order, lambda report: heard.add(report.stage))
        )
        try:
            # Whoever listens at the robot may have to be found first: that is no slow start.
            await self._until(lambda: OrderStage.SENT in heard or moving.done(), LIVES_S)
            seen = await self._until(
                lambda: self._robot.presence().at_rest is False, MOVING_WITHIN_S
            )
            if seen:
                await self._clock.sleep(UP_TO_SPEED_S)
            rest = await self._apply_stop()
        finally:
            moving.cancel()
            ended = await asyncio.gather(moving, return_exceptions=True)
        await self._conclude(order, Outcome(OrderEnding.CANCELLED))
        fault = next((str(end) for end in ended if isinstance(end, RosicError)), "")
        return _Drive(rest, seen, fault if OrderStage.SENT not in heard else "")

    async def _apply_stop(self) -> RestReport:
        generation = self._robot.gate.generation + 1
        rest = await self._robot.stop(Stop(self._profile.id, generation))
        self._confirmed = rest.confirmed
        self._store.note(
            Stopped(
                robot=self._profile.id,
                generation=generation,
                principal=OPERATOR,
                at_ns=self._clock.wall_ns(),
            )
        )
        await self._robot.resume(generation)
        return rest

    async def _watchdog(self) -> DiagnosticFinding:
        about, robot = self._profile.id, self._robot
        if self._skill is None:
            return DiagnosticFinding(
                about, FindingVerdict.NOT_MEASURED, "watchdog: no skill streams a velocity"
            )
        if not self._confirmed:
            text = "watchdog: its stop was not confirmed, so it was not moved again"
            return DiagnosticFinding(about, FindingVerdict.NOT_MEASURED, text)
        if not isinstance(robot, SilenceTest):
            text = "watchdog: this link cannot fall silent on purpose"
            return DiagnosticFinding(about, FindingVerdict.NOT_MEASURED, text)
        order, heard = await self._claim(), set[OrderStage]()
        rest = await robot.fall_silent(order, lambda report: heard.add(report.stage))
        await self._conclude(order, Outcome(OrderEnding.DONE))
        if OrderStage.RECEIVED not in heard:
            text = "watchdog: it was sent velocities, and not measured to move"
            return DiagnosticFinding(about, FindingVerdict.LOOK, text)
        return self._judged(rest)

    def _judged(self, rest: RestReport) -> DiagnosticFinding:
        """Hold what was measured against what the profile says."""
        stated_s = self._profile.watchdog_s or 0.0
        late = rest.seconds > stated_s + BRAKING_S
        what = "at rest" if rest.confirmed else "not seen at rest"
        text = (
            f"watchdog: {what} {rest.seconds:.2f} s after the last message; "
            f"the profile says {stated_s:g} s"
        )
        good = rest.confirmed and not late
        if good:
            text += f", and {BRAKING_S:g} s to come to rest is usual: good"
        else:
            text += ": too late; have its driver stop it sooner"
            wanted_s = ceil(10 * rest.seconds) / 10
            if rest.confirmed and wanted_s <= WATCHDOG_AT_MOST_S:
                text += f", or write watchdog_s: {wanted_s:.1f}"
        return DiagnosticFinding(
            self._profile.id, FindingVerdict.GOOD if good else FindingVerdict.LOOK, text
        )

    async def _claim(self) -> Order:
        """Decide a slow motion, on disk before it begins, like every other (I9)."""
        assert self._skill is not None  # noqa: S101 - callers looked
        gate, clock = self._robot.gate, self._clock
        permit = Permit(
            OPERATOR,
            "",
            self._profile.id,
            self._skill.id,
            gate.fence + 1,
            True,
            gate.generation,
            0,
        )
        now_ns, lives_ns = clock.wall_ns(), int(LIVES_S * 1e9)
        order = Order(
            self._entropy.token(COMMAND_ID_BYTES),
            self._profile.id,
            self._skill,
            slow_arguments(self._profile, self._skill),
            gate.n + 1,
            clock.monotonic_ns() + lives_ns,
            now_ns + lives_ns,
            permit,
        )
        await self._store.write(
            Claimed(
                cid=order.cid,
                principal=OPERATOR,
                key="",
                robot=order.robot,
                skill=self._skill.id,
                n=order.n,
                fence=permit.fence,
                new_fence=True,
                stop_generation=permit.stop_generation,
                epoch=0,
                digest=b"",
                accepted_ns=now_ns,
                expires_ns=order.expires_ns,
            )
        )
        return order

    async def _conclude(self, order: Order, outcome: Outcome) -> None:
        now_ns = self._clock.wall_ns()
        await self._store.write(Concluded(cid=order.cid, ending=outcome.ending.value, at_ns=now_ns))
        self._store.note(Told(cid=order.cid, at_ns=now_ns))

    async def _until(self, condition: Callable[[], bool], seconds: float) -> bool:
        deadline_ns = self._clock.monotonic_ns() + int(seconds * 1e9)
        while not condition():
            if self._clock.monotonic_ns() > deadline_ns:
                return False
            await self._clock.sleep(EVERY_S)
        return True


async def try_robot(
    config: Config, name: str, clock: Clock, entropy: Entropy
) -> AsyncIterator[DiagnosticFinding]:
    """Open one robot of a configuration, try it, and close it. It moves.

    Raises:
        RosicError: It could not be opened, or a gateway runs on this data.
    """
    profile = next((p for p in config.robots if p.id == name), None)
    if profile is None:
        known = ", ".join(p.id for p in config.robots)
        yield DiagnosticFinding(
            name, FindingVerdict.LOOK, f"there is no such robot; there are: {known}"
        )
        return
    latch = latch_of(config)
    store = DatabaseStore(config.data, clock=clock, kept=latch.kept)
    memory = await store.open()
    try:
        n, fence = memory.numbers.get(name, (0, 0))
        # What only the record knows holds too: a trial undoes nobody's stop but its own.
        stops = stops_of(latch.read(), memory.generations)
        generation, latched = stops.get(name, (0, False))
        gate = OrderGate(name, n=n, fence=fence, generation=generation, latched=latched)
        robot = robot_factory(profile.link.kind)(profile, gate, clock)
        await robot.open(lambda _text: None)
        try:
            async for finding in StopTest(profile, robot, store, latch, clock, entropy).run():
                yield finding
        except RosicError as error:
            yield DiagnosticFinding(name, FindingVerdict.LOOK, str(error))
        finally:
            await robot.close()
    finally:
        await latch.close()
        await store.close()


def streaming_skill(profile: Profile) -> Skill | None:
    """Return the skill that sends the robot velocities, if it has one."""
    for skill in profile.skills.values():
        if skill.streams:
            return skill
    return None


def slow_arguments(profile: Profile, skill: Skill) -> dict[str, Argument]:
    """Return SI arguments for a slow motion: the first speed a little, the others as they are."""
    vocabulary = Vocabulary.build([profile], known_units(), NO_COMMANDS)
    compiled = vocabulary.compiled_skill(profile.id, skill.id)
    arguments: dict[str, Argument] = {}
    slow: float | None = None
    for parameter in compiled.parameters if compiled else ():
        value = parameter.default
        if parameter.unit.dimension == "time":
            value = min(max(STREAM_S, parameter.low), parameter.high)
        elif slow is None and parameter.unit.dimension in {"speed", "turning speed"}:
            slow = SLOW_M_S if parameter.unit.dimension == "speed" else SLOW_RAD_S
            value = min(max(slow, parameter.low), parameter.high)
        arguments[parameter.name] = parameter.low if value is None else value
    return arguments
