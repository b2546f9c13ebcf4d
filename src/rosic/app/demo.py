"""The demonstration: six simulated robots, one person, this terminal. Nothing is kept."""

from __future__ import annotations

import asyncio
import logging
import socket
import sys
from typing import TYPE_CHECKING, Any

from rosic.api.settings import LISTEN, ApiSettings, HostPort, parse_listen
from rosic.app.admin.dispatch import AdminDispatcher
from rosic.app.api import GatewayApi
from rosic.app.closing import close_in_time, console_of, mind_console, on_signals, read_at
from rosic.app.features import command_table
from rosic.app.gateway import Gateway, GatewayParts, GatewaySettings
from rosic.app.people import ConfiguredPerson
from rosic.app.runtime import PIPED, face_of, until_done, until_quiet
from rosic.config.plugins import of_locale, robot_factory
from rosic.config.profiles import known_units, read_profile, shipped_profiles
from rosic.core.i18n import filled, in_language, joined, said, titled
from rosic.core.identity import Address
from rosic.core.rate_limit import RateLimit
from rosic.foxglove.recorder import recorder
from rosic.messengers.terminal import TerminalMessenger
from rosic.messengers.terminal.messenger import is_terminal, own_locale
from rosic.rendering.renderer import renderer
from rosic.stores.memory import MemoryStore
from rosic.stores.stop_latch import MemoryLatch

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock, Entropy
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import Profile

FLEET = ("kuka1", "omni", "yumi", "cf1", "cf2", "cf3")
# Longer than any single skill of the six takes within its bounds; a script never waits longer.
LINE_WITHIN_S = 180.0
CLOSE_WITHIN_S = 15.0  # three Crazyflies may have to land

GREETING = said(
    "Six simulated robots, ready in {took_s:.1f} s: {fleet}.\n"
    "Try, for example:\n"
    "  omni move 50 cm left\n"
    "  kuka1 grasp force=20\n"
    "  crazyflies takeoff 1 m\n"
    "  stop\n"
    "Also: status, help, help omni. Deutsch: /language de.\n"
    "[1] before a word is a button: type 1 to tap it.\n"
    "Tab completes; Ctrl-C brings all to rest; Ctrl-D leaves."
)

PAGE = said("The page is at {url}\nThe code in it is good for 5 minutes, once.")
LATE = said("Still under way after {seconds:.0f} s; going on.")
AT_THE_END = said("At the end:")
LEFT = said("Left. Nothing was kept. For real robots: rosic init, then rosic run")
LEFT_FILES = said(
    "Left. What you were sent lies in {folder}; nothing else was kept. For real robots: "
    "rosic init, then rosic run"
)
# Somebody's name, not a word of a sentence: in German that would need its case.
YOU = titled("you", {"de": "Gast"})
# Where there is a page, programs may read it too, who are somebody else.
GUEST = titled("Guest", {"de": "Gast"})
POLL_S = 0.02


class DemoScript:
    """Waits for what the lines of a script ask for.

    Attributes:
        late: Whether something did not end in time.
    """

    def __init__(self, gateway: Gateway, messenger: TerminalMessenger, clock: Clock) -> None:
        self.late = False
        self._gateway = gateway
        self._messenger = messenger
        self._clock = clock

    async def line(self) -> None:
        """Wait for the orders of a line."""
        self._note(await until_quiet(self._gateway, self._clock, seconds=LINE_WITHIN_S))

    async def end(self, left: asyncio.Event) -> None:
        """Wait for the tasks of all of them, unless somebody leaves."""
        self._note(await until_done(self._gateway, self._clock, seconds=LINE_WITHIN_S, unless=left))

    def _note(self, in_time: bool) -> None:
        if not in_time:
            self.late = True
            late = filled(LATE, seconds=LINE_WITHIN_S)
            self._messenger.show(read_at(self._messenger, self._gateway, late))


async def demonstrate(
    clock: Clock, entropy: Entropy, *, plain: bool, begun_ns: int, console: bool = False
) -> int:
    """Run the demonstration until input ends or somebody leaves. Return the exit status.

    With a script instead of a person, each line's orders end before the next line is read, and
    tasks that go on by themselves before it leaves; 1 is returned if one did not end in time.
    """
    profiles = fleet()
    messenger = TerminalMessenger(clock=clock, plain=plain, locale=own_locale())
    messenger.know(profiles, command_table())
    api = GatewayApi(ApiSettings(listen=_free_listen()), clock) if console else None
    gateway = gateway_of(profiles, messenger, clock, entropy, api)
    await gateway.open()
    script = None if is_terminal(sys.stdin) else DemoScript(gateway, messenger, clock)
    if script is not None:
        messenger.pace_by(script.line)
    # Whoever closes the pipe knows that nothing reaches them any more.
    delivery_log = logging.getLogger("rosic.delivery")
    unread = lambda _record: not messenger.gone  # noqa: E731 - removed by its identity
    delivery_log.addFilter(unread)
    try:
        took_s = (clock.monotonic_ns() - begun_ns) / 1e9
        greeting = filled(GREETING, took_s=took_s, fleet=", ".join(FLEET))
        messenger.show(in_language(greeting, of_locale(messenger.locale)))
        serving = None if api is None else await _serve(api, gateway, messenger, clock)
        await _until_over(gateway, messenger, script, serving)
        await _take_leave(gateway, messenger, script=script is not None)
    finally:
        await close_in_time(gateway, CLOSE_WITHIN_S)
        delivery_log.removeFilter(unread)
    return 1 if script is not None and script.late else 0


def fleet() -> list[Profile]:
    """Return the six profiles that ship, reached in this process."""
    shipped, units = shipped_profiles(), known_units()
    profiles = []
    for name in FLEET:
        read = read_profile(shipped[name], units, link="simulated")
        if read.profile is None:
            raise read.errors[0]
        profiles.append(read.profile)
    return profiles


def _free_listen() -> HostPort:
    """Return where the page is served: where it always is, or on a free port if that is taken."""
    usual = parse_listen(LISTEN)
    for port in (usual.port, 0):
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((usual.host, port))
            except OSError:
                continue
            return HostPort(usual.host, probe.getsockname()[1])
    return usual


async def _serve(
    api: GatewayApi, gateway: Gateway, messenger: TerminalMessenger, clock: Clock
) -> asyncio.Task[None]:
    """Serve the page, and show the link to it once it is there."""
    from rosic.app.admin.api import books_of  # noqa: PLC0415 - the page alone needs all of these
    from rosic.app.admin.explain import Explainer  # noqa: PLC0415
    from rosic.app.health import GatewayHealth  # noqa: PLC0415

    gateway.kernel.shared.health.provide(GatewayHealth(gateway, None, clock))
    gateway.kernel.shared.explainer.provide(Explainer(books_of(gateway, "UTC", (messenger,))))
    server = api.server_of(gateway)
    serving = asyncio.create_task(server.run())
    while not (server.listens or serving.done()):
        await clock.sleep(POLL_S)
    if not serving.done():
        code = gateway.access.page_sessions.offer(_whoever_sits_here(gateway))
        page = filled(PAGE, url=f"{server.context.settings.reached_at}/#code={code.reveal()}")
        messenger.show(in_language(page, of_locale(messenger.locale)))
    return serving


def _whoever_sits_here(gateway: Gateway) -> PrincipalId:
    people = gateway.rooms.authoriser.directory.people()
    return next(each.id for each in people if each.name == GUEST)


def gateway_of(
    profiles: list[Profile],
    messenger: TerminalMessenger,
    clock: Clock,
    entropy: Entropy,
    api: GatewayApi | None = None,
) -> Gateway:
    """Make the gateway. Its one person may do everything, and is whoever started it."""
    address = Address(messenger.platform, messenger.account)
    name = YOU if api is None else GUEST
    you = ConfiguredPerson(name=name, addresses=(address,), roles=("admin",))
    parts = GatewayParts(
        messengers=(messenger, *(api.messengers if api is not None else ())),
        robot_factory=robot_factory,
        store=MemoryStore(),
        latch=MemoryLatch(),
        clock=clock,
        entropy=entropy,
        units=known_units(),
        face=face_of(),
        renderer=renderer(),
        recorder=recorder(),
    )
    limit = RateLimit() if is_terminal(sys.stdin) else PIPED
    return Gateway(GatewaySettings(profiles=tuple(profiles), people=(you,), limit=limit), parts)


async def _take_leave(gateway: Gateway, messenger: TerminalMessenger, *, script: bool) -> None:
    """Say how it ends; of what still moves or flies only once it was measured at rest."""
    if script:
        found = joined("\n", (AT_THE_END, *AdminDispatcher(gateway).status()))
        messenger.show(read_at(messenger, gateway, found))
        return
    moving = [profile.id for profile in gateway.not_at_rest()]
    if moving:
        async for line in AdminDispatcher(gateway).stop(moving):
            messenger.show(read_at(messenger, gateway, line))
    folder = messenger.downloads.folder
    left = LEFT if folder is None else filled(LEFT_FILES, folder=folder)
    messenger.show(read_at(messenger, gateway, left))


async def _until_over(
    gateway: Gateway,
    messenger: TerminalMessenger,
    script: DemoScript | None,
    serving: asyncio.Task[None] | None = None,
) -> None:
    """Listen until the input ends, somebody leaves, or a signal comes."""
    left = asyncio.Event()

    def leave() -> None:
        left.set()
        messenger.ended.set()

    console = console_of((messenger,))
    on_signals(leave, None if console is None else console.interrupt)
    listening = asyncio.create_task(gateway.run())
    ended = asyncio.create_task(messenger.ended.wait())
    tasks: list[asyncio.Task[Any]] = [listening, ended]
    if serving is not None:
        serving.add_done_callback(lambda _: leave())
        tasks.append(serving)
    if console is not None:
        tasks.append(asyncio.create_task(mind_console(console, gateway, leave, ())))
    await asyncio.wait((listening, ended), return_when=asyncio.FIRST_COMPLETED)
    try:
        for task in (each for each in tasks if each is not ended and each.done()):
            task.result()
        if not listening.done() and script is not None and not messenger.gone:
            await script.end(left)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
