"""A gateway with simulated robots whose API is served on a free port of this machine."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Any

import httpx
from websockets.asyncio.client import connect

from rosic.api.settings import ApiSettings, HostPort
from rosic.app.admin.access import AccessAdmin, ProgramParameters
from rosic.app.admin.api import books_of
from rosic.app.admin.explain import Explainer
from rosic.app.api import GatewayApi
from rosic.app.demo import fleet
from rosic.app.gateway import Gateway, GatewayParts, GatewaySettings
from rosic.app.health import GatewayHealth
from rosic.app.people import ConfiguredPerson
from rosic.app.runtime import face_of
from rosic.config.plugins import robot_factory
from rosic.config.profiles import known_units
from rosic.core.identity import Address
from rosic.core.policy.limits import unit_converter
from rosic.core.policy.roles import DEFAULT_ROLES, RoleRules
from rosic.core.rate_limit import RateLimit
from rosic.foxglove.recorder import recorder
from rosic.messengers.memory import MemoryMessenger
from rosic.rendering.renderer import renderer
from rosic.stores.memory import MemoryStore
from rosic.stores.stop_latch import MemoryLatch
from rosic.system import SystemClock, SystemEntropy
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable
    from pathlib import Path

    from websockets.asyncio.client import ClientConnection

    from rosic.api.server import ApiServer
    from rosic.contracts.adapter import RobotFactory
    from rosic.contracts.store import Store
    from rosic.core.fleet.mission import Mission
    from rosic.core.robot.profile import Profile

ANYWHERE = HostPort("127.0.0.1", 0)
PEOPLE = {"Ada": "admin", "Bo": "operator", "Vi": "viewer"}


class ServedGateway:
    """A gateway whose API listens.

    Attributes:
        chat: The messenger that its people also have.
        http: Asks as nobody.
    """

    def __init__(self, gateway: Gateway, server: ApiServer, chat: MemoryMessenger) -> None:
        self.gateway, self.server, self.chat = gateway, server, chat
        self._clients: list[httpx.AsyncClient] = []
        self.http = self.client({})

    def client(self, headers: dict[str, str]) -> httpx.AsyncClient:
        """Return what asks with these headers; it is closed with the gateway."""
        made = httpx.AsyncClient(base_url=self.url, headers=headers, timeout=60 * pace())
        self._clients.append(made)
        return made

    async def close(self) -> None:
        for client in self._clients:
            await client.aclose()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server.port}"

    def principal(self, name: str) -> str:
        people = self.gateway.rooms.authoriser.directory.people()
        return next(person.id for person in people if person.name == name)

    async def key(self, *roles: str, name: str = "Hal") -> str:
        """Return the secret of a new program's key, as `rosic key create` makes and shows it."""
        admin = AccessAdmin(books_of(self.gateway, "UTC"), unit_converter(known_units()))
        shown = await admin.create_program(ProgramParameters(name=name, roles=roles))
        return shown.rpartition("\n")[2]

    async def program(self, *roles: str, name: str = "Hal") -> httpx.AsyncClient:
        """Return what asks as a new program."""
        secret = await self.key(*roles, name=name)
        return self.client({"Authorization": f"Bearer {secret}"})

    def code(self, name: str) -> str:
        """Return a code for signing in, as somebody is given it in their chat."""
        offered = self.gateway.access.page_sessions.offer(self.principal(name))
        return offered.reveal()

    async def person(self, name: str) -> httpx.AsyncClient:
        """Return what asks as the browser of a person who has signed in."""
        browser = self.client({"Origin": self.url})
        signed_in = await browser.post("/v1/sessions", json={"code": self.code(name)})
        assert signed_in.status_code == 201, signed_in.text
        return browser

    @asynccontextmanager
    async def listening(self, client: httpx.AsyncClient) -> AsyncIterator[ClientConnection]:
        """Yield a connection to the events, as somebody."""
        headers = {k: v for k, v in client.headers.items() if k in {"authorization", "origin"}}
        if client.cookies:
            headers["cookie"] = "; ".join(f"{k}={v}" for k, v in client.cookies.items())
        origin = headers.pop("origin", None)
        url = self.url.replace("http", "ws", 1) + "/v1/events"
        async with connect(url, additional_headers=headers, origin=origin) as connection:  # type: ignore[arg-type]
            yield connection

    async def until(self, holds: Callable[[], object]) -> None:
        async with asyncio.timeout(60 * pace()):
            while not holds():  # noqa: ASYNC110 - nobody is told
                await asyncio.sleep(0.01)


@asynccontextmanager
async def served(  # noqa: PLR0913, PLR0915 - a test says only what matters
    settings: ApiSettings | None = None,
    *,
    rules: RoleRules | None = None,
    profiles: tuple[Profile, ...] = (),
    store: Store | None = None,
    robots_of: Callable[[str], RobotFactory] = robot_factory,
    missions: tuple[Mission, ...] = (),
    data: Path | None = None,
    limit: RateLimit = RateLimit(),  # noqa: B008 - it is frozen
) -> AsyncIterator[ServedGateway]:
    """Yield a gateway whose API listens, until the test is over."""
    clock = SystemClock()
    chat = MemoryMessenger(clock=clock)
    api = GatewayApi(settings or ApiSettings(listen=ANYWHERE), clock)
    people = tuple(
        ConfiguredPerson(name, (Address(chat.platform, name.lower()),), (role,))
        for name, role in PEOPLE.items()
    )
    parts = GatewayParts(
        messengers=(chat, *api.messengers),
        robot_factory=robots_of,
        store=store or MemoryStore(),
        latch=MemoryLatch(),
        clock=clock,
        entropy=SystemEntropy(),
        units=known_units(),
        face=face_of(),
        renderer=renderer(),
        recorder=recorder(),
    )
    book = rules or RoleRules(roles=DEFAULT_ROLES)
    robots = profiles or tuple(fleet())
    gateway = Gateway(
        GatewaySettings(
            profiles=robots, people=people, rulebook=book, missions=missions, limit=limit
        ),
        parts,
    )
    await gateway.open()
    gateway.kernel.shared.health.provide(GatewayHealth(gateway, data, clock))
    gateway.kernel.shared.explainer.provide(Explainer(books_of(gateway, "UTC", parts.messengers)))
    server = api.server_of(gateway)
    tasks = [asyncio.create_task(gateway.run()), asyncio.create_task(server.run())]
    try:
        async with asyncio.timeout(30 * pace()):
            while not server.listens:
                for task in tasks:
                    if task.done():
                        task.result()
                await asyncio.sleep(0.01)
        place = ServedGateway(gateway, server, chat)
        try:
            yield place
        finally:
            await place.close()
    finally:
        for task in reversed(tasks):
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task
        await gateway.close()


def problem(response: httpx.Response) -> tuple[int, str, str]:
    """Return status, code and sentence of a refusal, which is one of RFC 9457."""
    assert response.headers["content-type"] == "application/problem+json", response.text
    body: dict[str, Any] = response.json()
    assert body["status"] == response.status_code
    assert body["type"] == f"/problems/{body['code']}"
    return response.status_code, body["code"], body["detail"]
