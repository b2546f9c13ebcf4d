"""The server: one port of HTTP and WebSockets, in the gateway's own event loop."""

from __future__ import annotations

import asyncio
import logging
import resource
import socket
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from typing import TYPE_CHECKING, Any, Final, cast

import uvicorn
from litestar import Litestar, Router
from litestar.di import Provide
from litestar.exceptions import HTTPException, ValidationException
from litestar.openapi import OpenAPIConfig
from msgspec.structs import replace

from rosic import __version__
from rosic.api.access_checks import (
    ALLOWANCE,
    SAFE,
    TOO_LARGE,
    TOO_SLOW,
    AccessChecks,
)
from rosic.api.body_limits import BodyDeadlineExceeded, BodyLimitExceeded
from rosic.api.callers import ApiCaller, CallerDirectory
from rosic.api.connections import IdleConnections, LimitedHttp, LimitedSocket
from rosic.api.context import ApiContext
from rosic.api.description import DescribedProblems
from rosic.api.events import EventStream
from rosic.api.figure_routes import ROUTES as FIGURES
from rosic.api.file_routes import ROUTES as FILES
from rosic.api.foxglove import FoxgloveConnections, foxglove
from rosic.api.history_routes import ROUTES as HISTORY
from rosic.api.metrics.gateway_metrics import GatewayMetrics
from rosic.api.order_feed import OrderFeed
from rosic.api.ordering import CallerRequests, RefusedOrder
from rosic.api.people_routes import ROUTES as PEOPLE
from rosic.api.problems import answer, problem, problem_of
from rosic.api.read_rates import ReadRates, asking_from
from rosic.api.resource_routes import ROUTES as RESOURCES
from rosic.api.rosbridge.endpoint import RosbridgeEndpoint, RosbridgePort, RosbridgeRouter
from rosic.api.routes import OPEN, ROUTES, events
from rosic.api.settings_checks import check_served
from rosic.api.tickets import TicketBook, new_ticket
from rosic.api.work_routes import ROUTES as WORK
from rosic.api.wrong_fields import not_fitting
from rosic.core.i18n import plain, said
from rosic.errors import ConfigurationError, RosicError, Unrecognised

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from typing import TypeAlias

    from litestar import Request, Response
    from litestar.connection import ASGIConnection
    from litestar.handlers import BaseRouteHandler, HTTPRouteHandler

    from rosic.api.access_checks import App
    from rosic.api.page_messenger import PageMessenger
    from rosic.api.settings import ApiSettings, HostPort, ServingLimits
    from rosic.gateway.delivery.translation import ChatLanguages
    from rosic.gateway.feature import Kernel
    from rosic.gateway.programs import ProgramService
    from rosic.messengers.program.messenger import ProgramMessenger

    _Request: TypeAlias = ASGIConnection[Any, Any, Any, Any]

CLOSE_WITHIN_S: Final = 1
DESCRIBED_AFTER_S: Final = 3.0
CALLER: Final = "rosic-caller"
CLIENTS_AT_MOST: Final = 256
"""Connections at a time on the port of rosbridge."""
LOCALE_MOST: Final = 64
CHECKS: Final = "/check"
"""What only looks what an order would come to counts as a read."""
FAILED: Final = said("Something went wrong here. It is not known what was done; please look.")
TOO_DEEP: Final = said("That is nested too deeply. Nothing was done.")
NOT_HERE: Final = said("There is nothing at this address.")
WRONG_METHOD: Final = said("That cannot be done at this address.")
NOT_READ: Final = said("That cannot be read, or does not fit here. Nothing was done.")

_OF_FRAMEWORK: Final = {404: ("not-found", NOT_HERE), 405: ("not-allowed", WRONG_METHOD)}

log = logging.getLogger("rosic.api")


class ApiServer:
    """Serves the API until cancelled.

    Args:
        kernel: Of a gateway that is open.
        settings: Where, and by which names.
        messengers: By which programs and people on the page speak; the gateway listens to them.
        programs: What a caller may see and ask for.
        languages: In which somebody is told things.
        pages: Puts the files of the page before the API; None: there is no page.

    Attributes:
        context: What the routes work with.
        port: On which it listens.
        rosbridge_port: On which clients of rosbridge come in besides; 0: none.
        stream: Tells what happens, as it happens.
        app: What answers, behind the checks.
    """

    def __init__(
        self,
        kernel: Kernel,
        settings: ApiSettings,
        messengers: tuple[ProgramMessenger, PageMessenger],
        programs: ProgramService,
        languages: ChatLanguages,
        pages: Callable[[App], App] | None = None,
    ) -> None:
        self._settings, self._pages = settings, pages
        feed = OrderFeed(kernel.machine_clock)
        kernel.pipeline.executor.watching.observe(feed)
        callers = CallerDirectory(
            programs, kernel.access.page_sessions, languages, secure=settings.is_tls
        )
        program, page = messengers
        self.context = ApiContext(
            kernel, settings, program, page, programs, callers, languages, feed
        )
        self._speech = CallerRequests(self.context)
        self.stream = EventStream(self.context, self._speech)
        self._connections = FoxgloveConnections(self.context)
        self._figures = GatewayMetrics(kernel)
        check_served(settings, kernel.rooms.profiles)
        self._tickets = TicketBook(callers, kernel.machine_clock, kernel.entropy.token)
        self._rosbridge = RosbridgeEndpoint(self.context, self._speech, self._tickets)
        self.port = settings.listen.port
        self.rosbridge_port = 0 if settings.rosbridge is None else settings.rosbridge.port
        self._rates = ReadRates(kernel.machine_clock, settings.limits.reads)
        self._description = DescribedProblems("/openapi.json")
        self.app = self._application()
        self._uvicorns: tuple[_Uvicorn, ...] = ()
        self.bound = asyncio.Event()  # its ports are its own

    @property
    def listens(self) -> bool:
        """Whether it listens now."""
        return bool(self._uvicorns) and all(each.started for each in self._uvicorns)

    @property
    def connections(self) -> int:
        """How many connections there are now."""
        return sum(len(each.server_state.connections) for each in self._uvicorns)

    async def run(self) -> None:
        """Listen until cancelled.

        Raises:
            ConfigurationError: It cannot listen there.
        """
        settings = self._settings
        with ExitStack() as opened:
            listener = opened.enter_context(_listener(settings.listen, "listen"))
            self.port = listener.getsockname()[1]
            serving = {listener: self._config(settings, self._routed(), settings.limits)}
            if settings.rosbridge is not None:
                there = opened.enter_context(_listener(settings.rosbridge, "rosbridge"))
                self.rosbridge_port = there.getsockname()[1]
                limits = replace(settings.limits, connections=CLIENTS_AT_MOST)
                alone = replace(settings, listen=settings.rosbridge)
                serving[there] = self._config(alone, RosbridgePort(self._rosbridge), limits)
            self.bound.set()
            await self._serve({_Uvicorn(config): where for where, config in serving.items()})

    async def _serve(self, servers: dict[_Uvicorn, socket.socket]) -> None:
        self._uvicorns = tuple(servers)
        try:
            log.info("the API listens on %s", self._settings.listen)
            if self._settings.rosbridge is not None:
                log.info("clients of rosbridge come in on %s", self._settings.rosbridge)
            await asyncio.gather(
                self._describe_soon(),
                *(server.serve(sockets=[listener]) for server, listener in servers.items()),
            )
        finally:
            for server, listener in servers.items():
                await server.end(listener)
            await self.stream.close()
            await self._speech.close()

    async def _describe_soon(self) -> None:
        """Have the description made once the start is over."""
        await asyncio.sleep(DESCRIBED_AFTER_S)
        await asyncio.to_thread(self._describe)

    def _describe(self) -> None:
        """Make the description, on a thread: whoever asks first would hold up everybody else."""
        for plugin in self.app.plugins:
            if (schema := getattr(plugin, "provide_openapi_schema", None)) is not None:
                self._description.prepare(schema())  # it is kept there, too

    def _routed(self) -> App:
        served: App = RosbridgeRouter(self.app, self._rosbridge)
        return served if self._pages is None else self._pages(served)

    def _config(self, settings: ApiSettings, served: App, limits: ServingLimits) -> uvicorn.Config:
        callers = self.context.callers
        app = AccessChecks(
            served, settings, callers.cookie, self._rates.policy, callers.read_by_stranger
        )
        silent = IdleConnections(limits, _connections_at_most(limits.connections))
        return uvicorn.Config(
            app,
            log_config=None,
            log_level=logging.ERROR,  # it would name whole addresses, and whatever nonsense comes
            access_log=False,
            interface="asgi3",
            lifespan="off",
            http=cast("type[asyncio.Protocol]", partial(LimitedHttp, silent)),
            ws=cast("type[asyncio.Protocol]", partial(LimitedSocket, limits)),
            ws_max_size=1 << 20,
            # Deflating each small message costs more than all else that is done with it.
            ws_per_message_deflate=False,
            server_header=False,
            date_header=True,
            proxy_headers=bool(settings.proxies),
            forwarded_allow_ips=list(settings.proxies),
            timeout_keep_alive=int(limits.idle_s),
            timeout_graceful_shutdown=CLOSE_WITHIN_S,
            ssl_certfile=settings.certificate or None,
            ssl_keyfile=settings.private_key or None,
        )

    def _passkeys(self) -> tuple[tuple[HTTPRouteHandler, ...], dict[str, Provide]]:
        """Return the routes of passkeys, and what they work with; nothing without their library."""
        try:
            from rosic.api.passkey_routes import ROUTES as PASSKEYS  # noqa: PLC0415 - an extra
            from rosic.api.passkeys import PasskeyCeremonies  # noqa: PLC0415 - an extra
        except ImportError:
            return (), {}
        kernel = self.context.kernel
        ceremonies = PasskeyCeremonies(
            kernel.access, self._settings, kernel.site.name, kernel.entropy.token
        )
        return PASSKEYS, {"ceremonies": Provide(lambda: ceremonies, sync_to_thread=False)}

    def _application(self) -> Litestar:
        # A function, for a router copies what else it is given; and no plain one, for that would
        # look up keys, count and note what is to be written down in a thread beside the loop.
        async def known(request: _Request, handler: BaseRouteHandler) -> None:
            self._recognise(request, handler)

        passkeys, ceremonies = self._passkeys()
        return Litestar(
            route_handlers=[
                Router(
                    "/v1",
                    route_handlers=[
                        *ROUTES,
                        *RESOURCES,
                        *PEOPLE,
                        *WORK,
                        *FILES,
                        *HISTORY,
                        *FIGURES,
                        *passkeys,
                        new_ticket,
                        events,
                    ],
                    guards=[known],
                ),
                foxglove,
            ],
            dependencies={
                **ceremonies,
                "api": Provide(self._api, sync_to_thread=False),
                "stream": Provide(self._events, sync_to_thread=False),
                "speech": Provide(self._calls, sync_to_thread=False),
                "tickets": Provide(lambda: self._tickets, sync_to_thread=False),
                "figures": Provide(lambda: self._figures, sync_to_thread=False),
                "caller": Provide(_caller, sync_to_thread=False),
                "connections": Provide(self._foxglove, sync_to_thread=False),
            },
            exception_handlers={
                Exception: self._failed,
                RosicError: self._refused,
                RefusedOrder: _refused_by_rooms,
                BodyLimitExceeded: self._too_large,
                BodyDeadlineExceeded: self._too_slow,
                ValidationException: self._invalid,
                HTTPException: self._http,
            },
            openapi_config=OpenAPIConfig(
                title="ROSIC",
                version=__version__,
                path="/v1/openapi",
                render_plugins=[self._description],
                use_handler_docstrings=True,
            ),
            logging_config=None,
        )

    def _api(self) -> ApiContext:
        return self.context

    def _events(self) -> EventStream:
        return self.stream

    def _foxglove(self) -> FoxgloveConnections:
        return self._connections

    def _calls(self) -> CallerRequests:
        return self._speech

    def _recognise(self, request: _Request, handler: BaseRouteHandler) -> None:
        """Let nobody further who is not known, and nobody who reads too often.

        It stands before every route that does not say that it is open, before anything is read.
        """
        if handler.opt.get(OPEN):
            return
        headers = request.headers
        try:
            caller = self.context.callers.identify(
                headers.get("authorization", ""), headers.get("cookie", "")
            )
        except Unrecognised:
            host = "" if request.client is None else request.client.host
            self._count(request, asking_from(host))
            raise
        if caller.by_cookie:
            asked = headers.get("accept-language", "")[:LOCALE_MOST]
            self.context.languages.suggest(caller.principal, asked.partition(",")[0].strip())
        request.scope["state"][CALLER] = caller
        if request.scope.get("method", "GET") in SAFE or request.url.path.endswith(CHECKS):
            self._count(request, caller.principal)

    def _count(self, request: _Request, who: str) -> None:
        left, refused = self._rates.take(who)
        request.scope["state"][ALLOWANCE] = left
        if refused is not None:
            raise refused

    def _refused(self, request: Request[Any, Any, Any], error: RosicError) -> Response[bytes]:
        return answer(problem_of(error, self._read(request, error.sentence)))

    def _failed(self, request: Request[Any, Any, Any], error: Exception) -> Response[bytes]:
        if isinstance(error, RecursionError):  # of reading what was sent, before anything was done
            return answer(problem("not-understood", self._read(request, TOO_DEEP), status=400))
        log.error("%s %s failed", request.method, request.url.path, exc_info=error)
        return answer(problem("fault", self._read(request, FAILED), status=500))

    def _too_large(
        self, request: Request[Any, Any, Any], _error: BodyLimitExceeded
    ) -> Response[bytes]:
        return answer(problem("too-large", self._read(request, TOO_LARGE), status=413))

    def _too_slow(
        self, request: Request[Any, Any, Any], _error: BodyDeadlineExceeded
    ) -> Response[bytes]:
        return answer(problem("too-slow", self._read(request, TOO_SLOW), status=408))

    def _invalid(
        self, request: Request[Any, Any, Any], error: ValidationException
    ) -> Response[bytes]:
        found = not_fitting(error, request.route_handler)
        detail = plain(self._read(request, found))
        return answer(problem("not-understood", detail, status=400))

    def _http(self, request: Request[Any, Any, Any], error: HTTPException) -> Response[bytes]:
        """Answer what no route has taken, so that nobody was recognised yet."""
        state, headers, status = request.scope["state"], request.headers, error.status_code
        if CALLER not in state:
            with suppress(Unrecognised):
                state[CALLER] = self.context.callers.identify(
                    headers.get("authorization", ""), headers.get("cookie", "")
                )
        code, sentence = _OF_FRAMEWORK.get(status, ("not-understood", NOT_READ))
        return answer(problem(code, self._read(request, sentence), status=status))

    def _read(self, request: Request[Any, Any, Any], sentence: str) -> str:
        """Return a sentence in the language of whoever asks, as far as that is known by now."""
        caller: ApiCaller | None = request.scope["state"].get(CALLER)
        callers = self.context.callers
        if caller is not None:
            return callers.read_by(sentence, caller)
        return callers.read_by_stranger(sentence, request.headers.get("accept-language", ""))


def _refused_by_rooms(_request: Request[Any, Any, Any], error: RefusedOrder) -> Response[bytes]:
    return answer(error.problem)


def _listener(listen: HostPort, key: str) -> socket.socket:
    family = socket.AF_INET6 if ":" in listen.host else socket.AF_INET
    # asyncio lets an answer go at once only where the protocol is named (TCP_NODELAY).
    listener = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((listen.host, listen.port))
    except OSError as error:
        listener.close()
        raise ConfigurationError(
            f"{listen} of this machine cannot be listened on ({error.strerror}).",
            hint=f"Name another address and port as {key} of [api].",
        ) from error
    return listener


def _connections_at_most(wanted: int) -> int:
    """Return how many are let in: half of the files that may be open are for everything else."""
    files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return min(wanted, files // 2)


def _caller(request: ASGIConnection[Any, Any, Any, Any]) -> ApiCaller:
    caller: ApiCaller = request.scope["state"][CALLER]
    return caller


class _Uvicorn(uvicorn.Server):
    """Signals are the gateway's business."""

    async def end(self, listener: socket.socket) -> None:
        """Close every connection, and wait for none."""
        self.force_exit = True
        await self.shutdown(sockets=[listener])

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leave them alone."""
        yield
