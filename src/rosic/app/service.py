"""A gateway at work: from opening it to the signal that ends it."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from rosic.api.metrics.endpoint import MetricsEndpoint
from rosic.app import runtime
from rosic.app.admin.api import books_of
from rosic.app.admin.control_socket import ControlServer, socket_path
from rosic.app.admin.dispatch import AdminApi, AdminDispatcher
from rosic.app.admin.explain import Explainer
from rosic.app.api import GatewayApi, webhooks_of
from rosic.app.builder import latch_of, parts_of, settings_of
from rosic.app.closing import CLOSE_WITHIN_S, close_in_time, console_of, mind_console, on_signals
from rosic.app.gateway import Gateway, GatewayParts
from rosic.app.health import GatewayHealth
from rosic.contracts.console import AccountProbe, Console
from rosic.contracts.store import ForgettingStore
from rosic.core.i18n import said
from rosic.core.time_units import DAY_S
from rosic.errors import MessengerFault, RosicError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from rosic.api.server import ApiServer
    from rosic.app.config import Config
    from rosic.contracts.clock import Clock, Entropy
    from rosic.contracts.messenger import Messenger


# ---- forgetting once a day what the record need not know any more ----

SOON_S = 60.0  # a gateway that is restarted every day forgets too, but not while it starts

log = logging.getLogger("rosic.gateway")


async def forget_daily(store: ForgettingStore, clock: Clock) -> None:
    """Forget soon after the start, then once a day, until cancelled. What fails is logged."""
    await clock.sleep(SOON_S)
    while True:
        try:
            count = await store.prune()
        except Exception:
            log.exception("old commands could not be forgotten; I try again in a day")
        else:
            if count:
                log.info("%d old commands were forgotten", count)
        await clock.sleep(DAY_S)


# ---- a gateway at work: from opening it to the signal that ends it ----

CHECK_WITHIN_S = 5.0
TERMINAL = "terminal"
GREETING = said(
    "Say help for what can be said here, and stop at any time; Ctrl-C stops every robot. "
    "[1] before a word is a button: type 1 to tap it."
)
CLOSE_AT_LEAST_S = 0.5


class GatewayService:
    """One gateway, from its configuration to its end.

    Args:
        config: What the gateway is seeded with, and where its data is.
        begun_ns: Monotonic clock when this process began; for saying how long the start took.
        show: Shows a sentence and a picture of a text to whoever started this, at their terminal;
            None when nobody sits there. What it shows may be secret and is never logged.

    Raises:
        ConfigurationError: An adapter is not there or does not take its settings, or the data
            folder's path is too long. Nothing was opened.
    """

    def __init__(
        self,
        config: Config,
        clock: Clock,
        entropy: Entropy,
        *,
        begun_ns: int,
        show: Callable[[str, str], None] | None = None,
    ) -> None:
        self._config = config
        self._show = show
        self._clock = clock
        self._begun_ns = begun_ns
        self._ended = asyncio.Event()
        self._ended_ns = 0
        self._is_ready = False
        socket_path(config.data)
        self._latch = latch_of(config)
        self._api = None if config.api is None else GatewayApi(config.api, clock)
        self._parts: GatewayParts = parts_of(config, self._latch, clock, entropy, self._api)
        self._gateway = Gateway(settings_of(config), self._parts)

    async def run(self) -> None:
        """Run until SIGTERM, SIGINT or SIGHUP, then bring motion to rest and tell what is untold.

        Raises:
            RosicError: It could not start, or a messenger failed for good. Whatever was opened is
                closed again, robots are at rest.
        """
        console = console_of(self._parts.messengers)
        on_signals(self._end, None if console is None else console.interrupt)
        try:
            if await self._open():
                try:
                    await self._serve()
                finally:
                    await close_in_time(self._gateway, self._left_s())
        finally:
            await self._latch.close()

    def _end(self) -> None:
        """Begin to end; a signal that is repeated gives no more time."""
        if not self._ended.is_set():
            self._ended_ns = self._clock.monotonic_ns()
            self._ended.set()

    def _left_s(self) -> float:
        """Return what is left of the time for closing since the signal, if there was one."""
        if not self._ended.is_set():
            return CLOSE_WITHIN_S
        past_s = (self._clock.monotonic_ns() - self._ended_ns) / 1e9
        return max(CLOSE_AT_LEAST_S, CLOSE_WITHIN_S - past_s)

    async def _open(self) -> bool:
        """Open the gateway, unless a signal comes first. Return whether it is open."""
        opening = asyncio.create_task(self._gateway.open())
        ending = asyncio.create_task(self._ended.wait())
        await asyncio.wait((opening, ending), return_when=asyncio.FIRST_COMPLETED)
        ending.cancel()
        if not opening.done():
            opening.cancel()
            await asyncio.wait((opening,), timeout=CLOSE_WITHIN_S)
            return False
        opening.result()
        return True

    async def _serve(self) -> None:
        config = self._config
        books = books_of(self._gateway, config.zone, self._parts.messengers)
        admin = AdminApi(books)
        control = ControlServer(config.data, AdminDispatcher(self._gateway, admin))
        await control.open()
        health = GatewayHealth(self._gateway, config.data, self._clock)
        self._gateway.kernel.shared.health.provide(health)
        self._gateway.kernel.shared.explainer.provide(Explainer(books))
        self._gateway.kernel.shared.not_ready.provide(self._not_ready)
        server = None if self._api is None else self._api.server_of(self._gateway)
        besides = self._besides(server)
        working = asyncio.create_task(self._work(admin, server))
        ending = asyncio.create_task(self._ended.wait())
        tasks = [working, ending, *besides]
        if (console := console_of(self._parts.messengers)) is not None:
            others = tuple(m.name for m in self._parts.messengers if not isinstance(m, Console))
            watching = mind_console(console, self._gateway, self._end, others)
            tasks.append(asyncio.create_task(watching))
        try:
            await asyncio.wait((working, ending), return_when=asyncio.FIRST_COMPLETED)
            for task in tasks:
                if task.done():
                    task.result()
            log.info("closing: motion is brought to rest")
        finally:
            await control.close()
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    def _besides(self, server: ApiServer | None) -> list[asyncio.Task[None]]:
        """Begin what the gateway does beside its work: tell other software, and forget."""
        tasks = []
        if server is not None:
            serving = asyncio.create_task(server.run())
            serving.add_done_callback(lambda _: self._end())
            tasks.append(serving)
        if (metrics := self._config.metrics) is not None:
            endpoint = MetricsEndpoint(self._gateway.kernel, metrics)
            tasks.append(asyncio.create_task(endpoint.run()))
        if hooks := self._config.webhooks:
            tasks.append(asyncio.create_task(webhooks_of(self._gateway, hooks).run()))
        if isinstance(store := self._parts.store, ForgettingStore):
            tasks.append(asyncio.create_task(forget_daily(store, self._clock)))
        return tasks

    def _not_ready(self) -> Iterator[str]:
        if not self._is_ready:
            yield "the gateway is starting"
        file = self._gateway.record_watch.lost_file()
        if file:
            yield f"{file} of the record is not there as it was"

    async def _work(self, admin: AdminApi, server: ApiServer | None) -> None:
        messengers = self._parts.messengers
        await check_accounts(messengers)
        if server is not None:
            await server.bound.wait()
        runtime.settle()
        took_s = (self._clock.monotonic_ns() - self._begun_ns) / 1e9
        robots = len(self._gateway.robots)
        log.info(
            "ready in %.2f s: %d %s, by %s",
            took_s,
            robots,
            "robot" if robots == 1 else "robots",
            ", ".join(messenger.name for messenger in messengers),
        )
        self._is_ready = True
        await self._welcome(admin)
        await self._gateway.run()

    async def _welcome(self, admin: AdminApi) -> None:
        """Tell whoever sits here how to begin; the first admin's code is shown nowhere else."""
        if self._show is None:
            if admin.access.nobody_is_admin():
                log.warning("nobody is admin here yet: rosic invite --role admin gives a code")
            return
        try:
            shown = await admin.access.first_admin()
        except RosicError as error:
            log.warning("there is no code for the first admin: %s", error)
            return
        if shown is not None:
            self._show(*shown)
        elif any(messenger.platform == TERMINAL for messenger in self._parts.messengers):
            self._show(GREETING, "")


async def check_accounts(messengers: Iterable[Messenger]) -> None:
    """Find a wrong token before saying that everything is ready. A platform may be away for now.

    Raises:
        ConfigurationError: An account cannot be used.
    """
    for messenger in messengers:
        if isinstance(messenger, AccountProbe):
            try:
                async with asyncio.timeout(CHECK_WITHIN_S):
                    await messenger.check()
            except (MessengerFault, TimeoutError):
                log.warning("%s does not answer; I go on trying", messenger.name)
