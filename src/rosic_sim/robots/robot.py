"""A simulated robot in this process: the same machine that also runs as a ROS 2 node."""

from __future__ import annotations

import asyncio
from math import inf, isfinite
from typing import TYPE_CHECKING

import msgspec
from msgspec.structs import replace

from rosic.contracts.live_control import live_outcome, never_steered
from rosic.core.deadman import INTERRUPTED, STOOD_STILL, DeadMan
from rosic.core.i18n import joined, said
from rosic.core.order import (
    Order,
    OrderEnding,
    OrderProgress,
    OrderStage,
    Outcome,
    RestReport,
    StageReport,
    Stop,
)
from rosic.core.robot.profile import Presence, Profile
from rosic.core.robot.view import Pose, View, ViewKind
from rosic.core.sample_gate import LiveEnd
from rosic.core.synchronised_start import begins_ns
from rosic.core.traffic import TrafficCount, TrafficCounter
from rosic.errors import (
    ConfigurationError,
    NothingToSee,
    RobotOffline,
    RobotUnreachable,
    StillMoves,
)
from rosic.robots.ros2.profile import Ros2Link
from rosic.robots.ros2.profile_rules import STAND_IN
from rosic_sim.robots.goals import described, goal_of, machine_arguments, topic_of, velocity_of
from rosic_sim.robots.machines.activity import Activity, ActivityRefused, ActivityState
from rosic_sim.robots.machines.crazyflie import Crazyflie
from rosic_sim.robots.machines.mecanum import SPEED_LIMIT_M_S
from rosic_sim.robots.machines.omni import Omni
from rosic_sim.robots.scenery.places import plan_of, pose_of
from rosic_sim.robots.scenery.scene import robot_scene
from rosic_sim.robots.simulation_loop import simulation_of

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator

    from rosic.contracts.clock import Clock
    from rosic.contracts.live_control import LiveControls
    from rosic.contracts.robot import Say, Speak, Tell
    from rosic.core.deadman import MotionBreak
    from rosic.core.order_gate import OrderGate
    from rosic.core.robot.view import Content
    from rosic_sim.robots.machines.machine import Machine
    from rosic_sim.robots.machines.mecanum import Velocity


# ---- peer ----

# What a simulated robot's own node would say to ROSIC: it takes on strategies and says so.

CAREFUL = "careful"
SPEED = "speed"


class _Heard(msgspec.Struct, frozen=True):
    """What matters here of what a robot is told."""

    kind: str
    id: str = ""
    name: str = ""
    values: dict[str, float | str] = {}


_read = msgspec.json.Decoder(_Heard).decode
_write = msgspec.json.Encoder().encode


def answer(machine: Machine, words: bytes) -> bytes | None:
    """Do what a robot is told among robots; return what it answers, or None.

    A mobile base takes on ``careful``: no faster than ``speed``, in m/s. An empty name undoes it.
    """
    try:
        heard = _read(words)
    except msgspec.MsgspecError:
        return None
    if heard.kind != "strategy":
        return None
    why = _take_on(machine, heard)
    return _write({"kind": "ack", "id": heard.id, "ok": not why, "why": why})


def _take_on(machine: Machine, heard: _Heard) -> str:
    """Work so from now on; return why not, or nothing."""
    if not isinstance(machine, Omni) or heard.name not in {"", CAREFUL}:
        return "it knows no such strategy"
    speed = heard.values.get(SPEED, SPEED_LIMIT_M_S)
    if not isinstance(speed, float) or not isfinite(speed) or speed <= 0:
        return "the speed is no speed"
    machine.cap_speed(speed if heard.name else SPEED_LIMIT_M_S)
    return ""


# ---- robot ----

REST_EVERY_S = 0.02
WAITING = "waiting"  # what a machine says until its first step; news only for a common start
SETPOINT_EVERY_S = 0.1
LOOK_EVERY_S = 0.05
ENDING = {
    ActivityState.DONE: OrderEnding.DONE,
    ActivityState.FAILED: OrderEnding.FAILED,
    ActivityState.CANCELLED: OrderEnding.CANCELLED,
}


class SimulatedRobot:
    """Carries orders to a machine and its answers back. See ``contracts.robot.Robot``.

    Attributes:
        machine: What it moves.
        begun: How many orders passed the gate.
        online: False makes it absent: it is not heard, and does not rest because of that.
        speak: Says something to other robots, as its own node would.
    """

    schema = STAND_IN
    stops_itself = True

    def __init__(self, profile: Profile, gate: OrderGate, clock: Clock) -> None:
        self.profile = profile
        self.gate = gate
        self._clock = clock
        self._simulation = simulation_of(clock)
        machine = self._simulation.world.machines.get(profile.id)
        if machine is None:
            known = ", ".join(self._simulation.world.machines)
            raise ConfigurationError(
                f"There is no simulated machine called {profile.id!r}.", hint=f"There are: {known}."
            )
        self.machine = machine
        self.online = True
        link = profile.link
        self._model = link.model if isinstance(link, Ros2Link) else ""
        self.begun = 0
        self._traffic = TrafficCounter()
        self._doing = ""
        self._controls: LiveControls | None = None
        self._say: Say = _unheard
        self.speak: Speak = _unspoken
        self._noted = machine.note

    async def open(self, say: Say) -> None:
        """Take part in the world."""
        self._say = say
        self._simulation.watch(self._listen)

    async def close(self) -> None:
        """Bring the machine to rest and leave the world."""
        if self._controls is not None:
            self._controls.close()
        if not self.machine.at_rest():
            await self._rest()
        self._simulation.forget(self._listen)

    @property
    def traffic(self) -> TrafficCount:
        """Return how often the machine was told something, and how often it has answered."""
        return self._traffic.count

    def _counted(self, tell: Tell) -> Tell:
        def counted(report: StageReport) -> None:
            if report.stage is OrderStage.SENT:
                self._traffic.went()
            else:
                self._traffic.came()
            tell(report)

        return counted

    def meet(self, speak: Speak) -> None:
        """Take what it answers by."""
        self.speak = speak

    def hear(self, words: bytes) -> bool:
        """Take on a strategy; the rest of what robots say is nothing to a machine."""
        said_back = answer(self.machine, words)
        if said_back is not None:
            self.speak(said_back, 0)
        return True

    def _listen(self) -> None:
        """Pass on what the machine did of its own accord: landed because a peer was lost."""
        if self.machine.note != self._noted:
            self._noted = self.machine.note
            if self._noted:
                self._say(self._noted)

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Carry out one order."""
        tell = self._counted(tell)
        together = topic_of(order.skill) is None  # a stream of velocities has no place for a start
        clock = self._clock
        if not self.online:
            raise RobotOffline(
                said("{shown} is not there. Nothing was sent.", shown=self.profile.shown)
            )
        self.gate.pass_order(order, clock.monotonic_ns(), clock.wall_ns(), together=together)
        tell(StageReport(OrderStage.SENT))
        self._doing = order.skill.id
        self.begun += 1
        try:
            if topic_of(order.skill) is not None:
                return await self._drive(order, tell)
            return await self._perform(order, tell)
        except ActivityRefused as cannot:
            sentence = said("{reason}. Nothing was done.", reason=cannot.reason)
            return Outcome(OrderEnding.REFUSED, sentence, code="robot-declined")
        except asyncio.CancelledError:
            await self._rest()
            raise
        finally:
            self._doing = ""

    async def _perform(self, order: Order, tell: Tell) -> Outcome:
        goal = goal_of(order.skill, order.arguments)
        start_ns = begins_ns(order, self._clock.monotonic_ns())
        start_s = None if start_ns is None else start_ns / 1e9
        activity = self.machine.begin(
            order.skill.id,
            machine_arguments(self._model, order.skill.id, goal),
            self._simulation.now_s(),
            start_s,
        )
        tell(StageReport(OrderStage.RECEIVED))
        self._simulation.wake()
        looked_ns, late, progress = self._clock.monotonic_ns(), False, OrderProgress()
        lost_ns = self._simulation.link_lost_s * 1e9
        while activity.running:
            if start_s is not None or activity.stage != WAITING:
                told = progress.reported(activity.fraction)
                tell(StageReport(OrderStage.RUNNING, told, activity.stage))
            await self._clock.sleep(REST_EVERY_S)
            await self._heard()
            now_ns = self._clock.monotonic_ns()
            late, looked_ns = late or now_ns - looked_ns > lost_ns, now_ns
        moves = activity.state is ActivityState.DONE and not await self._rested(order)
        return self._outcome(order, activity, late=late, moves=moves)

    async def _heard(self) -> None:
        """Bring it to rest if it is not heard any more.

        Raises:
            RobotUnreachable: It is not.
        """
        if not self.online:
            await self._rest()
            raise RobotUnreachable(
                said("{shown} cannot be reached any more.", shown=self.profile.shown)
            )

    async def _rested(self, order: Order) -> bool:
        """Wait until what is done rests, or keeps its place; return whether it does."""
        machine, begun_ns = self.machine, self._clock.monotonic_ns()
        while not machine.at_rest() and not machine.holding and self.gate.still_allows(order):
            if self._clock.monotonic_ns() - begun_ns > self.profile.rest_timeout_s * 1e9:
                return False
            await self._clock.sleep(REST_EVERY_S)
            await self._heard()
        return True

    def _outcome(self, order: Order, activity: Activity, *, late: bool, moves: bool) -> Outcome:
        code = StillMoves.code if moves else ""
        if activity.state is ActivityState.CANCELLED and self.gate.still_allows(order):
            code = STOOD_STILL if late else INTERRUPTED  # by itself: nobody here ended it
        return Outcome(ENDING[activity.state], activity.detail, dict(activity.facts), code)

    async def _drive(self, order: Order, tell: Tell) -> Outcome:
        """Send a bounded stream of velocities that ends in zero."""
        machine = self.machine
        if not isinstance(machine, Omni):
            raise ActivityRefused(self.profile.id, said("cannot be driven by a velocity"))
        velocity = velocity_of(self.profile.id, order.skill, order.arguments)
        machine.set_velocity(*velocity, self._simulation.now_s())
        tell(StageReport(OrderStage.RECEIVED))
        self._simulation.wake()
        try:
            return await self._stream(order, tell, machine, velocity)
        except ActivityRefused as cannot:
            await self._rest()
            return Outcome(OrderEnding.FAILED, cannot.reason)

    async def _stream(self, order: Order, tell: Tell, machine: Omni, velocity: Velocity) -> Outcome:
        """Go on with a drive that has begun."""
        duration_s = float(order.arguments.get("duration", 0.0))
        watchdog_s = self.profile.watchdog_s or machine.watchdog_s
        begun_ns = self._clock.monotonic_ns()
        dead_man, moved = DeadMan(begun_ns, watchdog_s=watchdog_s, heard_within_s=inf), False
        while self.gate.still_allows(order):
            now_ns = self._clock.monotonic_ns()
            broken, past_s = dead_man.look(now_ns, 0.0), (now_ns - begun_ns) / 1e9
            if broken is not None:
                return await self._broken_off(broken, (dead_man.last_ns - begun_ns) / 1e9)
            moved = moved or not machine.at_rest()
            if past_s >= duration_s:
                await self._rest()
                if not moved:
                    return Outcome(OrderEnding.SENT)  # as over ROS: of no motion nothing is said
                return Outcome(
                    OrderEnding.DONE, said("drove for {duration_s:g} s", duration_s=duration_s)
                )
            machine.set_velocity(*velocity, now_ns / 1e9)
            self._traffic.went()
            tell(StageReport(OrderStage.RUNNING, past_s / duration_s))
            await self._clock.sleep(min(SETPOINT_EVERY_S, duration_s - past_s))
            await self._heard()
        return Outcome(OrderEnding.CANCELLED)

    async def execute_live(self, order: Order, tell: Tell, controls: LiveControls) -> Outcome:
        """Carry out one live order."""
        machine, clock, tell = self.machine, self._clock, self._counted(tell)
        self._controls = controls
        try:
            if not self.online:
                raise RobotOffline(
                    said("{shown} is not there. Nothing was sent.", shown=self.profile.shown)
                )
            if not isinstance(machine, Omni):
                sentence = said("{robot} is driven by no velocity.", robot=self.profile.shown)
                return Outcome(OrderEnding.REFUSED, sentence, code="robot-declined")
            end = await controls.begin(self.profile.watchdog_s or machine.watchdog_s)
            if end is not None:
                return never_steered(end)
            self.gate.pass_order(order, clock.monotonic_ns(), clock.wall_ns())
            tell(StageReport(OrderStage.SENT))
            self._doing = order.skill.id
            self.begun += 1
            tell(StageReport(OrderStage.RECEIVED))
            return await self._follow(order, machine, controls)
        except ActivityRefused as cannot:
            await self._rest()
            return Outcome(OrderEnding.FAILED, cannot.reason)
        except asyncio.CancelledError:
            if self._doing:
                await self._rest()
            raise
        finally:
            self._doing, self._controls = "", None
            controls.leave()

    async def _follow(self, order: Order, machine: Omni, controls: LiveControls) -> Outcome:
        """Send the newest values until the controls say that it is over; then zero."""
        watchdog_s = self.profile.watchdog_s or machine.watchdog_s
        begun_ns = self._clock.monotonic_ns()
        dead_man, moved = DeadMan(begun_ns, watchdog_s=watchdog_s, heard_within_s=inf), False
        while self.gate.still_allows(order):
            now_ns = self._clock.monotonic_ns()
            broken, seconds = dead_man.look(now_ns, 0.0), (now_ns - begun_ns) / 1e9
            if broken is not None:
                return await self._broken_off(broken, (dead_man.last_ns - begun_ns) / 1e9)
            moved = moved or not machine.at_rest()
            if (end := controls.look()) is not None:
                _, confirmed = await self._rest()
                if not confirmed:
                    raise StillMoves(still_moves(self.profile.shown))
                if end is LiveEnd.RELEASED and not moved:
                    return Outcome(OrderEnding.SENT)  # as over ROS: of no motion nothing is said
                return live_outcome(end, seconds, controls.gate.most_s)
            self._set(machine, order, controls)
            self._traffic.went()
            self._simulation.wake()
            await controls.changed(min(SETPOINT_EVERY_S, controls.left_s()))
            await self._heard()
        return Outcome(OrderEnding.CANCELLED)

    def _set(self, machine: Omni, order: Order, controls: LiveControls) -> None:
        """Give it the newest values; coming to rest after a zero, it takes them a little later.

        Raises:
            ActivityRefused: It takes none, and does not move either.
        """
        velocity = velocity_of(self.profile.id, order.skill, controls.values)
        try:
            machine.set_velocity(*velocity, self._simulation.now_s())
        except ActivityRefused:
            if machine.at_rest():
                raise

    async def _broken_off(self, broken: MotionBreak, driven_s: float) -> Outcome:
        """Bring it to rest, and say so: nobody begins it again."""
        await self._rest()
        what = (
            said("drove for {seconds:.1f} s", seconds=driven_s),
            said(
                "broken off because ROSIC itself stood still for {seconds:.1f} s",
                seconds=broken.seconds,
            ),
        )
        return Outcome(
            OrderEnding.FAILED, joined("; ", what), {"driven_s": driven_s}, code=broken.code
        )

    async def stop(self, stop: Stop) -> RestReport:
        """Latch, halt, and wait until rest is measured."""
        self.gate.apply_stop(stop)
        self._traffic.went()
        if self._controls is not None:
            self._controls.close()
        seconds, confirmed = await self._rest()
        self._traffic.came()
        landed = said("on the ground") if self._model == "crazyflie" else ""
        return RestReport(stop.robot, confirmed, seconds, landed)

    async def _rest(self) -> tuple[float, bool]:
        """Halt until rest is measured or the time is over; return the seconds and whether."""
        begun_ns = self._clock.monotonic_ns()
        limit_ns = int(self.profile.rest_timeout_s * 1e9)
        while True:
            self.machine.halt(self._simulation.now_s())
            past_ns = self._clock.monotonic_ns() - begun_ns
            if self.machine.at_rest() or past_ns > limit_ns:
                return past_ns / 1e9, self.machine.at_rest()
            self._simulation.wake()
            await self._clock.sleep(REST_EVERY_S)

    async def resume(self, generation: int) -> None:
        """Undo the latch."""
        self.gate.resume(generation)

    def presence(self) -> Presence:
        """Return the machine's measurements, in the profile's units where it names one."""
        machine = self.machine
        if not machine.moving:
            machine.step(self._simulation.now_s())
        return Presence(
            online=self.online,
            age_s=0.0,
            doing=self._doing,
            at_rest=machine.at_rest() if self.online else None,
            holds=machine.holding,
            values=described(machine.telemetry(), self.profile),
            pose=self._pose() if self.profile.pose is not None else None,
        )

    def _pose(self) -> Pose | None:
        """Return where a machine is that goes somewhere."""
        machine = self.machine
        if isinstance(machine, Omni):
            return pose_of(machine)
        if isinstance(machine, Crazyflie):
            flight = machine.flight
            return Pose(flight.x_m, flight.y_m, flight.height.position, frame="map")
        return None

    async def look(self, sight: ViewKind) -> AsyncGenerator[View, None]:
        """Show the machine as it stands, or the room it drives in."""
        while True:
            if not self.machine.moving:
                self.machine.step(self._simulation.now_s())
            content = self._shown(sight) if self.profile.offers(sight) else None
            if content is None:
                raise NothingToSee(said("{robot} shows no such thing.", robot=self.profile.shown))
            yield View(content, self._clock.monotonic_ns())
            await self._clock.sleep(LOOK_EVERY_S)

    def _shown(self, sight: ViewKind) -> Content | None:
        if sight is ViewKind.PICTURE:
            return robot_scene(self._simulation.world, self.profile.id)
        if not isinstance(self.machine, Omni):
            return None
        return replace(plan_of(self.machine), pose_ns=self._clock.monotonic_ns())


def _unspoken(_words: bytes, _dropped: int) -> None:
    """Nobody was met."""


def _unheard(_text: str) -> None:
    """Nobody listens before ``open``."""


def still_moves(shown: str) -> str:
    """Return that a robot which was told to come to rest has not."""
    return said("{shown} was sent zero and told to stop, and still moves.", shown=shown)
