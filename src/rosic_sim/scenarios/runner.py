"""Plays a play: raises the curtain, follows the script, and says at the end what happened."""

from __future__ import annotations

import asyncio
import os
import shutil
import sys
from contextlib import asynccontextmanager
from functools import partial
from math import dist
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.app.admin.dispatch import AdminDispatcher
from rosic.app.closing import close_in_time, mind_console, on_signals, read_at
from rosic.app.gateway import Gateway, GatewayParts, GatewaySettings
from rosic.app.people import ConfiguredPerson
from rosic.app.runtime import PIPED, face_of, until_done, until_quiet
from rosic.config.plugins import robot_factory
from rosic.config.profiles import known_units
from rosic.core.identity import ROBOT, Address
from rosic.core.message import Attachment
from rosic.core.rate_limit import RateLimit
from rosic.core.robot.view import PathsView, PathView, Pose
from rosic.errors import how_to_install
from rosic.messengers.terminal import TerminalMessenger
from rosic.messengers.terminal.downloads import DownloadFolder
from rosic.messengers.terminal.messenger import is_terminal, own_locale
from rosic.rendering.renderer import renderer
from rosic.stores.stop_latch import MemoryLatch
from rosic_sim.robots.scenery.scene import robot_scene
from rosic_sim.robots.simulation_loop import simulation_of
from rosic_sim.scenarios.recording_store import RecordingStore
from rosic_sim.scenarios.robots import SpeakingRobot
from rosic_sim.scenarios.scenario import ScenarioChats, ScenarioMismatch, ScenarioRunner
from rosic_sim.scenarios.terminal_view import TerminalView

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from rosic.contracts.adapter import RobotFactory
    from rosic.contracts.clock import Clock, Entropy
    from rosic.contracts.messenger import Receive
    from rosic.contracts.renderer import Renderer
    from rosic.core.message import Outbound
    from rosic.core.robot.view import Subject
    from rosic_sim.robots.simulation_loop import SimulationLoop
    from rosic_sim.scenarios.scenario import Scenario


# ---- a faster clock ----


class FastClock:
    """Another clock, so many times as fast. Everything on it keeps its proportions.

    Args:
        clock: The real one.
        factor: At least 1.

    Attributes:
        factor: The same.
    """

    def __init__(self, clock: Clock, factor: float) -> None:
        self._clock = clock
        self.factor = factor
        self._wall_ns = clock.wall_ns()
        self._began_ns = clock.monotonic_ns()

    def wall_ns(self) -> int:
        """Return the wall clock, as if more time had passed since this was made."""
        return self._wall_ns + self._past_ns()

    def monotonic_ns(self) -> int:
        """Return the monotonic clock, likewise."""
        return self._began_ns + self._past_ns()

    async def sleep(self, seconds: float) -> None:
        """Wait for so long on this clock."""
        await self._clock.sleep(seconds / self.factor)

    def _past_ns(self) -> int:
        return int((self._clock.monotonic_ns() - self._began_ns) * self.factor)


# ---- the newcomer's seat ----


class UserTerminal(TerminalMessenger):
    """A terminal that neither asks nor shows anything before somebody sits down.

    Attributes:
        taken: Set it, and they may type. What they are told before is shown to the play's person.
    """

    def __init__(self, *, clock: Clock, plain: bool) -> None:
        super().__init__("seat", clock=clock, plain=plain, locale=own_locale())
        self.taken = asyncio.Event()
        self._unseen = 0

    def join(self, gateway: Gateway) -> None:
        """Complete what is said there; what is piped in goes on when a line of it has ended."""
        self.know(gateway.rooms.profiles.values(), gateway.rooms.vocabulary.commands)
        if not is_terminal(sys.stdin):
            self.pace_by(partial(_line_over, gateway, self._clock))

    async def run(self, receive: Receive) -> None:
        """Listen from then on."""
        await self.taken.wait()
        await super().run(receive)

    async def send(self, outbound: Outbound) -> str:
        """Show it, once there is somebody to see it."""
        if self.taken.is_set():
            return await super().send(outbound)
        self._unseen += 1
        return f"unseen-{self._unseen}"


LEAST_M: Final = 0.02
"""Shorter steps are not kept: a way of a minute has some hundred points then."""
WENT_M: Final = 0.05
"""Who stayed within so much of their beginning went nowhere."""


class RobotPaths:
    """Follows the robots of a play while the world is stepped.

    Args:
        gateway: Whose robots they are.
        simulation: Of the world that they move in.
    """

    def __init__(self, gateway: Gateway, simulation: SimulationLoop) -> None:
        self._gateway = gateway
        self._simulation = simulation
        self._points: dict[str, list[Pose]] = {}
        simulation.watch(self._look)

    def close(self) -> None:
        """Follow them no more."""
        self._simulation.forget(self._look)

    def _look(self) -> None:
        for robot, profile in self._gateway.rooms.profiles.items():
            if profile.pose is None:
                continue
            pose = self._gateway.rooms.linker.presence(robot).pose
            points = self._points.setdefault(robot, [])
            if pose is not None and (not points or _apart_m(points[-1], pose) >= LEAST_M):
                points.append(pose)

    def subject(self, title: str) -> Subject:
        """Return what there is to draw: the ways, or the first robot where none went anywhere."""
        profiles = self._gateway.rooms.profiles
        ways = tuple(
            PathView(profiles[robot].shown, tuple(points))
            for robot, points in self._points.items()
            if max((_apart_m(points[0], pose) for pose in points), default=0.0) > WENT_M
        )
        return (
            PathsView(title, ways)
            if ways
            else robot_scene(self._simulation.world, next(iter(profiles)))
        )

    def picture(self, title: str, name: str, draw: Renderer) -> Attachment:
        """Return the picture as a file.

        Args:
            title: What stands over it.
            name: Of the file, without its ending.
            draw: Who draws it.
        """
        drawing = draw(self.subject(title))
        ending = drawing.media_type.rpartition("/")[2].replace("jpeg", "jpg")
        return Attachment(f"{name}.{ending}", drawing.media_type, drawing.content)


def _apart_m(one: Pose, other: Pose) -> float:
    return dist((one.x_m, one.y_m, one.z_m), (other.x_m, other.y_m, other.z_m))


# ---- playing a scenario ----

FAST: Final = 4.0
INTERRUPTED: Final = 130
NUMBERED: Final = "[1] before a word is a button: type 1 to tap it."
CLOSE_WITHIN_S: Final = 15.0
LINE_WITHIN_S: Final = 180.0


class ScenarioOptions(msgspec.Struct, frozen=True, kw_only=True):
    """How somebody wants to see a play.

    Attributes:
        plain: No colours.
        fast: Four times as fast.
        scripted: Follow the script; False: only the newcomer acts.
        stay: They may go on when the script has ended.
        role: As whom they act; empty: as the first of the play.
    """

    plain: bool = False
    fast: bool = False
    scripted: bool = True
    stay: bool = False
    role: str = ""


async def play(told: Scenario, wish: ScenarioOptions, clock: Clock, entropy: Entropy) -> int:
    """Play it. Return 0, 1 if it did not go as written, or 130 if a signal ended it."""
    if wish.fast:
        clock = FastClock(clock, FAST)
    began_ns = clock.monotonic_ns()
    curtain = _curtain(told, wish, lambda: (clock.monotonic_ns() - began_ns) / 1e9)
    store = RecordingStore()
    chats = ScenarioChats("phones", clock=clock, edits=False)  # what was printed stays printed
    seat = UserTerminal(clock=clock, plain=wish.plain) if wish.stay or not wish.scripted else None
    gateway = gateway_of(told, wish, store, (chats, seat), clock, entropy)
    await gateway.open()
    if seat is not None:
        seat.join(gateway)
    stage = ScenarioRunner(told, gateway, chats, curtain, clock)
    trails = RobotPaths(gateway, simulation_of(clock))
    status = 0
    try:
        curtain.title(f"rosic demo {told.name}: {told.about}")
        async with _listening(gateway, seat) as ending:
            status = await _act(stage, wish, ending.over)
            if seat is not None and not ending.over.done():
                status = await _sit_down(stage, wish, seat, ending) or status
        if status != INTERRUPTED:
            await _sum_up(stage, store, trails)
        return status
    finally:
        trails.close()
        if status == INTERRUPTED:
            await _break_off(stage, curtain)
        else:
            await close_in_time(gateway, CLOSE_WITHIN_S)


def _curtain(told: Scenario, wish: ScenarioOptions, now_s: Callable[[], float]) -> TerminalView:
    colour = not wish.plain and is_terminal(sys.stdout) and not os.environ.get("NO_COLOR")
    columns = shutil.get_terminal_size().columns if is_terminal(sys.stdout) else 0
    names = (person.name for person in told.people)
    return TerminalView(names, now_s, colour=colour, columns=columns)


async def _sum_up(stage: ScenarioRunner, store: RecordingStore, trails: RobotPaths) -> None:
    """Say what happened, and draw what moved into a file."""
    curtain, name = stage.curtain, stage.play.name
    curtain.title("What happened, by the record and by the robots")
    curtain.plain("\n".join(stage.summary(store, curtain.now_s())))
    draw = renderer()
    if draw is None:
        curtain.plain(f"For a picture of what moved: {how_to_install('pictures')}")
        return
    picture = await asyncio.to_thread(trails.picture, f"rosic demo {name}", f"demo-{name}", draw)
    curtain.plain(f"A picture of what moved. {await DownloadFolder().put(picture)}")


async def _break_off(stage: ScenarioRunner, curtain: TerminalView) -> None:
    """Bring everything to rest, and say in one line whether it is: the play is not over."""
    stage.muted.update(person.name for person in stage.play.people)
    gateway = stage.gateway
    await close_in_time(gateway, status=INTERRUPTED, say=lambda text: curtain.plain(f"\n{text}"))
    moving = ", ".join(stage.moving())
    rest = f"Not at rest: {moving}." if moving else "Every robot is at rest."
    curtain.plain(f"\nInterrupted. {rest} Nothing was kept.")


async def _line_over(gateway: Gateway, clock: Clock) -> None:
    """Wait until what a line of a script asked for has ended."""
    await until_quiet(gateway, clock, seconds=LINE_WITHIN_S)


async def _act(stage: ScenarioRunner, wish: ScenarioOptions, over: asyncio.Task[None]) -> int:
    """Follow the script, unless a signal comes first. Return the exit status."""
    if not wish.scripted:
        return 0
    script = asyncio.ensure_future(stage.play.script(stage))
    try:
        await asyncio.wait((script, over), return_when=asyncio.FIRST_COMPLETED)
        if not script.done():
            over.result()
            return INTERRUPTED
        script.result()
        await stage.quiet()
    except ScenarioMismatch as odd:
        stage.aside(f"This did not go as written. {odd}")
        return 1
    finally:
        script.cancel()
        await asyncio.gather(script, return_exceptions=True)
    return 0


async def _sit_down(
    stage: ScenarioRunner, wish: ScenarioOptions, seat: UserTerminal, ending: ScenarioEnd
) -> int:
    """Let the newcomer type until they leave. Return the exit status."""
    who, curtain = wish.role or stage.play.people[0].name, stage.curtain
    stage.muted.add(who)  # they read it at their seat
    curtain.title(f"You are: {who}. Try, for example:")
    curtain.plain("\n".join(f"  {hint}" for hint in stage.play.hints))
    curtain.plain(f"{NUMBERED}\nAlso: status, help. Deutsch: /language de. Ctrl-D leaves.")
    seat.taken.set()
    watching = asyncio.create_task(mind_console(seat, stage.gateway, seat.ended.set, ()))
    try:
        await ending.over
    finally:
        watching.cancel()
    alone = is_terminal(sys.stdin) or seat.gone
    if not alone:
        return await _finish(stage, ending.signalled)
    await _leave_at_rest(stage, seat)
    return 0


async def _leave_at_rest(stage: ScenarioRunner, seat: UserTerminal) -> None:
    """Bring to rest what still moves when somebody leaves, so that the summary is the end of it."""
    gateway = stage.gateway
    moving = [profile.id for profile in gateway.not_at_rest()]
    if not moving:
        return
    async for line in AdminDispatcher(gateway).stop(moving):
        stage.curtain.plain(read_at(seat, gateway, line))
    await stage.quiet()


async def _finish(stage: ScenarioRunner, signalled: asyncio.Event) -> int:
    """Wait for the tasks that piped lines gave. Return the exit status."""
    done = await until_done(stage.gateway, stage.clock, seconds=LINE_WITHIN_S, unless=signalled)
    if signalled.is_set():
        return INTERRUPTED
    if not done:
        stage.curtain.aside(f"Something is still under way after {LINE_WITHIN_S:.0f} s.")
    return 0 if done else 1


class ScenarioEnd(NamedTuple):
    """How it may end while it is played.

    Attributes:
        over: Ends when somebody leaves or a signal comes.
        signalled: Set by a signal.
    """

    over: asyncio.Task[None]
    signalled: asyncio.Event


@asynccontextmanager
async def _listening(gateway: Gateway, seat: UserTerminal | None) -> AsyncIterator[ScenarioEnd]:
    """Let the gateway listen while inside."""
    ended = asyncio.Event() if seat is None else seat.ended
    signalled = asyncio.Event()

    def leave() -> None:
        signalled.set()
        ended.set()

    on_signals(leave)
    listening = asyncio.create_task(gateway.run())
    over = asyncio.create_task(_first(listening, ended))
    try:
        yield ScenarioEnd(over, signalled)
    finally:
        for task in (over, listening):
            task.cancel()
        await asyncio.gather(over, listening, return_exceptions=True)


async def _first(listening: asyncio.Task[None], ended: asyncio.Event) -> None:
    ending = asyncio.create_task(ended.wait())
    await asyncio.wait((listening, ending), return_when=asyncio.FIRST_COMPLETED)
    ending.cancel()
    if listening.done():
        listening.result()


def gateway_of(
    told: Scenario,
    wish: ScenarioOptions,
    store: RecordingStore,
    ends: tuple[ScenarioChats, UserTerminal | None],
    clock: Clock,
    entropy: Entropy,
) -> Gateway:
    """Make the gateway of a play, and put its machines into the world of that clock."""
    chats, seat = ends
    simulation = simulation_of(clock)
    if isinstance(clock, FastClock):
        # For how long a busy machine has no processor for this process is no faster than it is.
        simulation.stretch_links(clock.factor)
    for machine in told.machines():
        simulation.world.add(machine)
    sitting = wish.role or told.people[0].name
    people = [
        ConfiguredPerson(
            name=person.name,
            addresses=(
                Address(chats.platform, person.name),
                *(
                    (Address(seat.platform, seat.account),)
                    if seat is not None and person.name == sitting
                    else ()
                ),
            ),
            roles=(person.role,),
        )
        for person in told.people
    ]
    people += [
        ConfiguredPerson(robot, (Address(ROBOT, robot),), ("fellow",)) for robot in told.peers
    ]
    settings = GatewaySettings(
        profiles=told.profiles(),
        people=tuple(people),
        rulebook=told.rules,
        place="play",
        limit=RateLimit() if is_terminal(sys.stdin) else PIPED,
        lease_idle_s=told.lease_idle_s,
        missions=told.missions,
    )
    parts = GatewayParts(
        messengers=(chats,) if seat is None else (chats, seat),
        robot_factory=_speaking if told.peers else robot_factory,
        store=store,
        latch=MemoryLatch(),
        clock=clock,
        entropy=entropy,
        units=known_units(),
        face=face_of(),
        renderer=renderer(),
    )
    return Gateway(settings, parts)


def _speaking(_kind: str) -> RobotFactory:
    return SpeakingRobot
