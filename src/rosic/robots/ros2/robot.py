"""A robot on a ROS 2 graph, as its profile describes it."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final, TypeAlias

from rosic.contracts.robot import UTTERANCE_BYTES
from rosic.core.i18n import joined, said
from rosic.core.order import Order, OrderEnding, Outcome, RestReport, Stop
from rosic.core.robot.profile import Presence, Profile
from rosic.core.time_units import SECOND_NS
from rosic.core.traffic import TrafficCount, TrafficCounter
from rosic.errors import ConfigurationError, RobotOffline, RobotUnreachable, RosicError
from rosic.robots.ros2.abandoned_goals import AbandonedGoals
from rosic.robots.ros2.bindings.action import ActionSkill
from rosic.robots.ros2.bindings.binding_call import Binding, BindingCall, RobotSide
from rosic.robots.ros2.bindings.dialogue import DialogueBinding
from rosic.robots.ros2.bindings.file import FileBinding
from rosic.robots.ros2.bindings.parameters import ParameterSkill
from rosic.robots.ros2.bindings.service import ServiceSkill
from rosic.robots.ros2.bindings.topic import TopicSkill
from rosic.robots.ros2.bindings.trajectory import TrajectoryGoal
from rosic.robots.ros2.camera_map import CameraAndMap
from rosic.robots.ros2.client.node import Heartbeat, others_under, station_of
from rosic.robots.ros2.client.qos_mismatch import QosMismatch
from rosic.robots.ros2.client.topics import WAITING_AT_MOST, RateLimitedTopic, TopicQos
from rosic.robots.ros2.errors import BadValue
from rosic.robots.ros2.messages.names import check_graph_name
from rosic.robots.ros2.open_topics import OpenTopics
from rosic.robots.ros2.profile import ros2_profile
from rosic.robots.ros2.profile_rules import SCHEMA
from rosic.robots.ros2.settling import RestInterlock
from rosic.robots.ros2.stopping import RestResult, StopController, to_the_end
from rosic.robots.ros2.telemetry import Measurements

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Callable, Iterator

    from rosic.contracts.clock import Clock
    from rosic.contracts.live_control import LiveControls
    from rosic.contracts.robot import Say, Speak, Tell
    from rosic.core.order_gate import OrderGate
    from rosic.core.robot.file_transfer import FileForRobot, Receipt
    from rosic.core.robot.view import View, ViewKind
    from rosic.robots.ros2.client.graph import GraphSnapshot
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.client.topics import Publisher
    from rosic.robots.ros2.profile import Ros2Skill

_log = logging.getLogger(__name__)

SAY: Final = "among/say"
HEAR: Final = "among/hear"
TYPE: Final = "std_msgs/msg/String"
DEPTH: Final = 50


class PeerLink:
    """``<namespace>/among/say`` and ``<namespace>/among/hear``, JSON in a ``std_msgs/msg/String``.

    Who speaks is the robot whose namespace it is; nothing in the words can say otherwise.
    """

    def __init__(self, namespace: str) -> None:
        self._namespace = namespace
        self._speak: Speak | None = None
        self._publisher: Publisher | None = None
        self._words: RateLimitedTopic | None = None

    def types(self) -> set[str]:
        """Return the type of both topics."""
        return {TYPE}

    def meet(self, speak: Speak) -> None:
        """Say who takes what the nodes say."""
        self._speak = speak

    async def open(self, runtime: RosRuntime) -> None:
        """Begin to listen; what is said before anybody was met is not taken."""
        if self._speak is not None:
            self._publisher = await runtime.publisher(
                f"{self._namespace}/{HEAR}", TYPE, TopicQos(depth=DEPTH)
            )
            self._words = await runtime.paced_words(
                f"{self._namespace}/{SAY}",
                self._speak,
                UTTERANCE_BYTES,
                TopicQos(depth=WAITING_AT_MOST),
            )

    async def close(self) -> None:
        """Leave both topics."""
        publisher, self._publisher = self._publisher, None
        words, self._words = self._words, None
        if publisher is not None:
            await publisher.close()
        if words is not None:
            await words.close()

    def hear(self, words: bytes) -> bool:
        """Publish to the robot's nodes. Return whether somebody listens."""
        if self._publisher is None or not self._publisher.listeners:
            return False
        try:
            self._publisher.publish({"data": words.decode()})
        except RosicError as fault:
            _log.warning("the nodes under %s were not told: %s", self._namespace, fault)
            return False
        return True


if TYPE_CHECKING:
    Part: TypeAlias = (
        Measurements | StopController | Heartbeat | Binding | CameraAndMap | FileBinding | PeerLink
    )

# Nobody is missing yet for so long after the start.
APPEARS_S = 3.0
# Topics can be heard seconds before services are found: what gets lost in discovery is sent again
# every 3 s (Fast DDS). An order waits for a robot's side that has just appeared.
DISCOVERY_S = 8.0
DEADLINE_MARGIN_S = 0.1
# A gateway that ends has no more time than this for one robot.
CLOSING_REST_S = 3.0
ROOT = "/"
UNFIT = "does-not-fit"


class Ros2Robot:
    """Carries orders to a robot over ROS 2 and its answers back. See ``contracts.robot.Robot``.

    All robots of a process share one node, ``chat_interface``.
    """

    schema = SCHEMA

    def __init__(self, profile: Profile, gate: OrderGate, clock: Clock) -> None:
        """Make it; nothing is opened.

        Raises:
            ConfigurationError: The namespace is no name, a skill says nothing of how, or the
                profile is written for a link of another kind.
        """
        self.profile = profile
        self._told = told = ros2_profile(profile)
        self.gate = gate
        self._clock = clock
        self._station = station_of(clock)
        self._traffic = TrafficCounter()
        self.topics = OpenTopics(told, self._station, self._traffic)
        space = profile.link.namespace
        # What stands at the root shares it with everybody: it is told by its topics alone.
        self._namespace = "" if space in {"", ROOT} else check_graph_name(space)
        self._measured = Measurements(told, clock)
        self._stop_controller = StopController(told, self._measured, clock)
        self._heartbeat = Heartbeat(self._namespace, clock)
        self._camera_map = CameraAndMap(told, clock)
        self._meetings = QosMismatch(profile.id)
        self._delivery = FileBinding(told, gate)
        self._dialogue = self._text_link()
        self._among = self._peer_link()
        self._carriers = {name: self._carrier(name, s) for name, s in told.skills.items()}
        self._opened_ns: int | None = None
        self._appeared_ns = 0
        self._was_online = False
        self._seen: bool | None = None
        self._call: BindingCall | None = None
        self._settling = RestInterlock(profile, self._measured, clock, self._online, self._to_rest)
        self._loose = AbandonedGoals(clock, self._settling.begin)

    def _text_link(self) -> DialogueBinding | None:
        if not self.profile.link.dialogue:
            return None
        if not self._namespace:
            raise ConfigurationError(
                f"{self.profile.id}: a dialogue needs a namespace.", hint="For example /talker."
            )
        return DialogueBinding(self.profile.shown, self._namespace, self._clock)

    def _peer_link(self) -> PeerLink | None:
        if not self.profile.link.among:
            return None
        if not self._namespace:
            raise ConfigurationError(
                f"{self.profile.id}: among needs a namespace.", hint="For example /omni."
            )
        return PeerLink(self._namespace)

    def _carrier(self, name: str, skill: Ros2Skill) -> Binding:
        if skill.action is not None:
            trajectory = skill.action.trajectory
            maker = None if trajectory is None else TrajectoryGoal(trajectory, self._told.joints)
            return ActionSkill(skill.action, maker)
        if skill.service is not None:
            return ServiceSkill(skill.service)
        if skill.topic is not None:
            return TopicSkill(skill.topic)
        if skill.set_parameters is not None:
            return ParameterSkill(skill.set_parameters)
        if self._dialogue is not None:
            return self._dialogue
        raise ConfigurationError(
            f"{self.profile.id}: skill {name!r} does not say how it reaches the robot.",
            hint="Give it a topic, a service, an action or set_parameters.",
        )

    # ---- opening and closing ----

    async def open(self, say: Say) -> None:
        """Join the graph and open everything the profile names. It waits for nobody there."""
        parts = list(self._parts())
        types = set().union(*(part.types() for part in parts))
        try:
            runtime = (await self._station.enter(types, self._look, say)).counting(self._traffic)
            for part in parts:
                await part.open(runtime)
        except ConfigurationError as error:
            await self.close()
            if error.where:
                raise
            raise ConfigurationError(str(error), where=self.profile.id) from error
        except BaseException:
            await self.close()
            raise
        self._opened_ns = self._appeared_ns = self._clock.monotonic_ns()
        if self._dialogue is not None:
            self._dialogue.begin(say)

    async def close(self) -> None:
        """Bring what is under way to rest, then leave the graph."""
        if self._call is not None:
            self._call.cut_off()
            if self._call.left:
                self._halted(await self._to_rest(limit_s=CLOSING_REST_S))
        self._opened_ns = None
        self._loose.close()
        self._settling.close()
        closing = [*(part.close() for part in self._parts()), self._station.leave(self._look)]
        for step in closing:
            try:
                await step
            except Exception:  # noqa: BLE001 - a contract: it never raises
                _log.exception("%s was not closed cleanly", self.profile.id)

    def _parts(self) -> Iterator[Part]:
        """Yield everything to be opened: first what stops the robot, last what moves it."""
        yield self._measured
        yield self._stop_controller
        yield self._heartbeat
        if self._dialogue is not None:
            yield self._dialogue
        for carrier in self._carriers.values():
            if carrier is not self._dialogue:
                yield carrier
        yield self._camera_map
        yield self._delivery
        if self._among is not None:
            yield self._among

    @property
    def traffic(self) -> TrafficCount:
        """Return how many messages passed between this robot and ROSIC: topics, calls, goals."""
        return self._traffic.count

    # ---- other robots ----

    def meet(self, speak: Speak) -> None:
        """Let the robot's own nodes be heard by other robots, if its profile says ``among``."""
        if self._among is not None:
            self._among.meet(speak)

    def hear(self, words: bytes) -> bool:
        """Bring words to the robot's own nodes."""
        return self._among is not None and self._among.hear(words)

    # ---- orders ----

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Carry out one order."""
        return await self._carry(BindingCall(order, tell, self._side(), self._patience_s(order)))

    async def execute_live(self, order: Order, tell: Tell, controls: LiveControls) -> Outcome:
        """Carry out one live order."""
        call = BindingCall(order, tell, self._side(), self._patience_s(order), controls)
        try:
            return await self._carry(call)
        finally:
            controls.leave()

    async def _carry(self, call: BindingCall) -> Outcome:
        self._call, order = call, call.order
        try:
            carrier = self._carriers[order.skill.id]
            if order.skill.actuates and carrier is not self._dialogue:
                self._loose.check(self.profile.shown)
                await self._settling.check(call)
                await self._release(order)
            return await carrier.carry(call)
        except BadValue as fault:
            _log.warning("an order for %s was not sent: %s", self.profile.id, fault)
            sentence = said(
                "{shown} cannot take these values. Nothing was done.", shown=self.profile.shown
            )
            return Outcome(OrderEnding.REFUSED, sentence, code=UNFIT)
        except asyncio.CancelledError:
            if call.left:
                await to_the_end(asyncio.create_task(self._to_rest()))
            raise
        finally:
            self._call = None
            if self._opened_ns is not None:  # closing has brought it to rest, and follows nothing
                if call.loose is not None:
                    self._loose.add(call.loose)
                if call.unsettled:
                    self._settling.begin()

    async def _release(self, order: Order) -> None:
        """Release what holds it since a motion was ended without that anybody stopped it.

        Raises:
            RobotOffline: It was not released; nothing else was sent.
        """
        try:
            await self._stop_controller.release_for_order(
                lambda: self.gate.latched, self._patience_s(order)
            )
        except RobotUnreachable as fault:
            raise RobotOffline(joined(" ", (fault.sentence, said("Nothing was sent.")))) from fault

    async def fall_silent(self, order: Order, tell: Tell) -> RestReport:
        """Stream as `execute` does, then cease without a zero, and wait for measured rest.

        Returns:
            The seconds from the last message to rest, or to giving up; then it is stopped.

        Raises:
            ConfigurationError: The skill streams nothing.
            OrderVoid, RobotOffline: The robot has not moved.
        """
        carrier = self._carriers[order.skill.id]
        if not isinstance(carrier, TopicSkill):
            raise ConfigurationError(f"{order.skill.id} of {self.profile.id} streams nothing.")
        call = self._call = BindingCall(order, tell, self._side(), self._patience_s(order))
        resting = RestResult(confirmed=False, seconds=0.0)
        try:
            resting = await carrier.fall_silent(call)
        finally:
            # Called off early, its last word may be of before it began to move: that is no rest.
            since_ns = self._measured.stale_ns()
            if call.left and not (resting.confirmed and self._measured.at_rest(since_ns)):
                await to_the_end(asyncio.create_task(self._to_rest()))
            self._call = None
        return RestReport(self.profile.id, resting.confirmed, resting.seconds)

    async def rest_every_s(self, within_s: float) -> float | None:
        """Listen at most so long to what shows rest; return how many seconds apart it comes."""
        return await self._measured.every_s(within_s)

    def guessed(self) -> tuple[str, ...]:
        """Return which values are read as per cent though the profile says nothing of it."""
        return self._measured.guessed()

    async def stop(self, stop: Stop) -> RestReport:
        """Latch, then apply everything that could stop it until rest is measured."""
        self.gate.apply_stop(stop)
        if self._call is not None:
            self._call.unsteer()
        if self._dialogue is not None:
            self._dialogue.tell_stop()
        if self._opened_ns is None:
            return RestReport(stop.robot, confirmed=False, seconds=0.0)
        resting = await self._to_rest(lambda: self._call is None)
        self._halted(resting)
        return RestReport(
            stop.robot,
            resting.confirmed,
            resting.seconds,
            declined=resting.declined,
            unanswered=resting.unanswered,
        )

    async def _to_rest(
        self, quiet: Callable[[], bool] = lambda: True, limit_s: float | None = None
    ) -> RestResult:
        """Apply the brakes; whatever goes wrong with them, it ends with an answer.

        Of a robot whose rest was not seen they are applied once more when it is heard again.
        """
        begun_ns = self._clock.monotonic_ns()
        try:
            resting = await self._stop_controller.apply(quiet, limit_s=limit_s)
        except Exception:  # noqa: BLE001 - a contract: it never raises
            _log.exception("%s could not be brought to rest", self.profile.id)
            seconds = (self._clock.monotonic_ns() - begun_ns) / SECOND_NS
            return RestResult(confirmed=False, seconds=seconds)
        if self._settling.unheard and not resting.confirmed and not resting.moves:
            self._settling.begin()
        return resting

    def _halted(self, resting: RestResult) -> None:
        if self._call is not None:
            self._call.stopped(resting)

    async def resume(self, generation: int) -> None:
        """Undo the latch, which is kept here; its own stop is released first, if that holds."""
        if self._opened_ns is not None and generation == self.gate.generation:
            await self._stop_controller.release()
        self.gate.resume(generation)

    # ---- what is known of it ----

    def presence(self) -> Presence:
        """Return what was last heard."""
        call, online = self._call, self._online()
        return Presence(
            online=online,
            age_s=self._age_s(),
            doing=call.order.skill.id if call is not None else "",
            at_rest=self._measured.at_rest(self._measured.stale_ns()),
            holds=self._measured.holds(self._measured.stale_ns()),
            doubt=self._measured.doubt(),
            values=self._measured.values(),
            ages_s=self._measured.ages_s(),
            no_number=self._measured.no_number(),
            pose=self._camera_map.pose() if online is not False else None,
        )

    def look(self, sight: ViewKind) -> AsyncGenerator[View, None]:
        """Yield what can be seen."""
        return self._camera_map.look(sight)

    async def deliver(self, robot_file: FileForRobot) -> Receipt:
        """Hand a file to the robot's side."""
        return await self._delivery.deliver(robot_file)

    def _age_s(self) -> float | None:
        ages = (self._measured.age_s(), None if self._dialogue is None else self._dialogue.age_s())
        return min((age for age in ages if age is not None), default=None)

    def _online(self) -> bool | None:
        """Tell from telemetry, else from the greeting, else from the graph."""
        if self._opened_ns is None:
            return None
        if self._measured.tells_presence:
            age_s = self._measured.age_s()
            if age_s is not None:
                return age_s <= self.profile.link.heartbeat_s
            return None if self._early() else False
        if self._dialogue is not None:
            return self._dialogue.answered
        return None if self._early() and not self._seen else self._seen

    def _look(self, seen: GraphSnapshot) -> None:
        """Take in what is on the graph."""
        self._measured.look(seen)
        self._camera_map.heed(seen)
        if self._namespace:
            self._seen = others_under(seen, self._namespace)
        elif self._measured.sources:
            self._seen = not self._measured.tells_presence
        self._notice()
        self._meetings.look(seen, list(self._measured.sources.values()), self._stop_controller)
        self._meetings.doubt(self._measured.doubt())
        if self._dialogue is not None:
            self._dialogue.look()

    def _notice(self) -> None:
        """Remember when the robot came back."""
        online = self._online() is True
        if online and not self._was_online:
            self._appeared_ns = self._clock.monotonic_ns()
        self._was_online = online

    def _early(self) -> bool:
        """Tell whether it is too early to miss anybody."""
        opened_ns = self._opened_ns or 0
        return self._clock.monotonic_ns() - opened_ns < APPEARS_S * SECOND_NS

    def _patience_s(self, order: Order) -> float:
        """Return how long an order may wait for an end that discovery has not found yet."""
        self._notice()
        now_ns = self._clock.monotonic_ns()
        found_s = DISCOVERY_S - (now_ns - self._appeared_ns) / SECOND_NS
        deadline_s = (order.deadline_ns - now_ns) / SECOND_NS - DEADLINE_MARGIN_S
        return max(0.0, min(found_s, deadline_s))

    def _side(self) -> RobotSide:
        return RobotSide(
            self.profile.shown,
            self.gate,
            self._clock,
            self._stop_controller,
            self._measured,
            self._namespace,
            self.profile.rest_timeout_s,
            self.profile.watchdog_s or self.profile.link.heartbeat_s,
            self.topics.answers,
        )
