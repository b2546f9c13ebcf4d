"""The server: one port of HTTP and WebSockets, in the gateway's own event loop."""

from __future__ import annotations

import logging
import socket
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

import uvicorn
from litestar import Litestar, Router
from litestar.di import Provide
from litestar.exceptions import HTTPException, ValidationException
from litestar.openapi import OpenAPIConfig
from litestar.openapi.plugins import JsonRenderPlugin

from rosic import __version__
from rosic.api.access_checks import TOO_LARGE, AccessChecks, BodyLimitExceeded
from rosic.api.callers import ApiCaller, CallerDirectory
from rosic.api.context import ApiContext
from rosic.api.events import EventStream
from rosic.api.order_feed import OrderFeed
from rosic.api.ordering import CallerRequests, RefusedOrder
from rosic.api.problems import answer, problem, problem_of
from rosic.api.routes import ROUTES, events
from rosic.errors import ConfigurationError, RosicError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from litestar import Request, Response
    from litestar.connection import ASGIConnection
    from litestar.handlers import HTTPRouteHandler

    from rosic.api.page_messenger import PageMessenger
    from rosic.api.settings import ApiSettings
    from rosic.gateway.delivery.translation import ChatLanguages
    from rosic.gateway.feature import Kernel
    from rosic.gateway.programs import ProgramService
    from rosic.messengers.program.messenger import ProgramMessenger

CONNECTIONS_AT_MOST: Final = 1_000
CLOSE_WITHIN_S: Final = 1
KEEP_ALIVE_S: Final = 20
CALLER: Final = "rosic-caller"
FAILED: Final = "Something went wrong here. It is not known what was done; please look."
NOT_HERE: Final = "There is nothing at this address."
WRONG_METHOD: Final = "That cannot be done at this address."

log = logging.getLogger("rosic.api")


class ApiServer:
    """Serves the API until cancelled.

    Args:
        kernel: Of a gateway that is open.
        settings: Where, and by which names.
        messengers: By which programs and people on the page speak; the gateway listens to them.
        programs: What a caller may see and ask for.
        languages: In which somebody is told things.

    Attributes:
        context: What the routes work with.
        port: On which it listens.
        stream: Tells what happens, as it happens.
    """

    def __init__(
        self,
        kernel: Kernel,
        settings: ApiSettings,
        messengers: tuple[ProgramMessenger, PageMessenger],
        programs: ProgramService,
        languages: ChatLanguages,
    ) -> None:
        self._settings = settings
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
        self.port = settings.listen.port
        self._uvicorn: _Uvicorn | None = None

    @property
    def listens(self) -> bool:
        """Whether it listens now."""
        return self._uvicorn is not None and self._uvicorn.started

    async def run(self) -> None:
        """Listen until cancelled.

        Raises:
            ConfigurationError: It cannot listen there.
        """
        with self._listener() as listener:
            self.port = listener.getsockname()[1]
            server = self._uvicorn = _Uvicorn(self._config())
            try:
                log.info("the API listens on %s", self._settings.listen)
                await server.serve(sockets=[listener])
            finally:
                server.force_exit = True
                await server.shutdown(sockets=[listener])
                await self.stream.close()
                await self._speech.close()

    def _config(self) -> uvicorn.Config:
        settings = self._settings
        app = AccessChecks(self._application(), settings, self.context.callers.cookie)
        return uvicorn.Config(
            app,
            log_config=None,
            access_log=False,
            interface="asgi3",
            lifespan="off",
            ws="websockets-sansio",
            ws_max_size=1 << 20,
            limit_concurrency=CONNECTIONS_AT_MOST,
            server_header=False,
            date_header=True,
            proxy_headers=bool(settings.proxies),
            forwarded_allow_ips=list(settings.proxies),
            timeout_keep_alive=KEEP_ALIVE_S,
            timeout_graceful_shutdown=CLOSE_WITHIN_S,
            ssl_certfile=settings.certificate or None,
            ssl_keyfile=settings.private_key or None,
        )

    def _listener(self) -> socket.socket:
        listen = self._settings.listen
        family = socket.AF_INET6 if ":" in listen.host else socket.AF_INET
        listener = socket.socket(family)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((listen.host, listen.port))
        except OSError as error:
            listener.close()
            raise ConfigurationError(
                f"{listen} of this machine cannot be listened on ({error.strerror}).",
                hint="Name another address and port as listen of [api].",
            ) from error
        return listener

    def _passkeys(self) -> tuple[tuple[HTTPRouteHandler, ...], dict[str, Provide]]:
        """Return the routes of passkeys, and what they work with; nothing without their library."""
        try:
            from rosic.api.passkey_routes import ROUTES as PASSKEYS  # noqa: PLC0415 - an extra
            from rosic.api.passkeys import PasskeyCeremonies  # noqa: PLC0415 - an extra
        except ImportError:
            return (), {}
        kernel = self.context.kernel
        ceremonies = PasskeyCeremonies(kernel.access, self._settings, kernel.site.name)
        return PASSKEYS, {"ceremonies": Provide(lambda: ceremonies, sync_to_thread=False)}

    def _application(self) -> Litestar:
        passkeys, ceremonies = self._passkeys()
        return Litestar(
            route_handlers=[Router("/v1", route_handlers=[*ROUTES, *passkeys, events])],
            dependencies={
                **ceremonies,
                "api": Provide(self._api, sync_to_thread=False),
                "stream": Provide(self._events, sync_to_thread=False),
                "speech": Provide(self._calls, sync_to_thread=False),
                "caller": Provide(self._caller, sync_to_thread=False),
            },
            exception_handlers={
                Exception: self._failed,
                RosicError: self._refused,
                RefusedOrder: _refused_by_rooms,
                BodyLimitExceeded: _too_large,
                ValidationException: _invalid,
                HTTPException: _http,
            },
            openapi_config=OpenAPIConfig(
                title="ROSIC",
                version=__version__,
                path="/v1/openapi",
                render_plugins=[JsonRenderPlugin(path="/openapi.json")],
            ),
            logging_config=None,
        )

    def _api(self) -> ApiContext:
        return self.context

    def _events(self) -> EventStream:
        return self.stream

    def _calls(self) -> CallerRequests:
        return self._speech

    def _caller(self, request: ASGIConnection[Any, Any, Any, Any]) -> ApiCaller:
        headers = request.headers
        caller = self.context.callers.identify(
            headers.get("authorization", ""), headers.get("cookie", "")
        )
        request.scope["state"][CALLER] = caller
        return caller

    def _refused(self, request: Request[Any, Any, Any], error: RosicError) -> Response[bytes]:
        caller: ApiCaller | None = request.scope["state"].get(CALLER)
        sentence = self.context.callers.read_by(error.sentence, caller)
        return answer(problem_of(error, sentence))

    def _failed(self, request: Request[Any, Any, Any], error: Exception) -> Response[bytes]:
        log.error("%s %s failed", request.method, request.url.path, exc_info=error)
        return answer(problem("fault", FAILED, status=500))


def _refused_by_rooms(_request: Request[Any, Any, Any], error: RefusedOrder) -> Response[bytes]:
    return answer(error.problem)


def _too_large(_request: Request[Any, Any, Any], _error: BodyLimitExceeded) -> Response[bytes]:
    return answer(problem("too-large", TOO_LARGE, status=413))


def _invalid(_request: Request[Any, Any, Any], error: ValidationException) -> Response[bytes]:
    return answer(problem("not-understood", _what_is_wrong(error), status=400))


def _what_is_wrong(error: ValidationException) -> str:
    parts = (each for each in error.extra or () if isinstance(each, dict))
    found = [f"{each.get('key', '')}: {each.get('message', '')}" for each in parts]
    return "; ".join(found)[:400] or error.detail


def _http(_request: Request[Any, Any, Any], error: HTTPException) -> Response[bytes]:
    detail = {404: NOT_HERE, 405: WRONG_METHOD}.get(error.status_code, error.detail)
    code = {404: "not-found", 405: "not-allowed"}.get(error.status_code, "not-understood")
    return answer(problem(code, detail, status=error.status_code))


class _Uvicorn(uvicorn.Server):
    """Signals are the gateway's business."""

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leave them alone."""
        yield
