"""A world whose people and programs speak by every way in at once: chat, REST, page and rosbridge.

The API is asked in process, behind all of its checks, so that a whole history needs no socket and
goes by the world's clock. Who has said something is known by whoever sent it, not by what the
gateway makes of it.
"""

from __future__ import annotations

import asyncio
import json
from collections import deque
from contextvars import ContextVar
from functools import partial
from typing import TYPE_CHECKING, Any

import httpx

from rosic.api.page_messenger import PageMessenger
from rosic.api.server import ApiServer
from rosic.api.settings import ApiSettings, HostPort
from rosic.authoriser.invitations import InvitedRights
from rosic.config.profiles import load_profile, shipped_profiles
from rosic.core.identity import OPERATOR
from rosic.core.message import MessageValidity
from rosic.core.order import OrderStage
from rosic.core.sample_gate import LATE_S
from rosic.gateway.programs import ProgramService
from rosic.gateway.requests import line_id
from rosic.messengers.program.messenger import ProgramMessenger
from tests.gateway.events import (
    Acted,
    Event,
    Latched,
    Revoked,
    Said,
    Sampled,
    Started,
    Steered,
    StopSent,
    Unlatched,
)
from tests.gateway.histories import FLEET, LINES_AT_MOST, World
from tests.gateway.judging import MOVERS, WATCHERS
from tests.gateway.watched import Recorder

if TYPE_CHECKING:
    from collections.abc import Coroutine, Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.live_control import LiveControls
    from rosic.contracts.messenger import Messenger, Receive
    from rosic.contracts.robot import Tell
    from rosic.core.message import Inbound
    from rosic.core.order import Order, Outcome, StageReport
    from rosic.core.robot.skill import Argument

HOST = "127.0.0.1:8765"
ORIGIN = f"http://{HOST}"
OMNI = load_profile(shipped_profiles()["omni"])
OLD_KEY = "old key"
SPEAKER: ContextVar[str] = ContextVar("SPEAKER")
# What the first sample took to come counts as no time: here it may take one step of the clock.
REST_WITHIN_S = LATE_S + 0.15


class Wheels(deque["dict[str, Argument]"]):
    """What a robot was driven with; each change of it is written down."""

    def __init__(self, robot: LiveRecorder) -> None:
        super().__init__(maxlen=1_000)
        self._robot = robot

    def append(self, values: dict[str, Argument], /) -> None:
        super().append(values)
        moving = any(values.values())
        robot = self._robot
        at_ns = robot.world.clock.monotonic_ns()
        robot.world.log.append(Steered(robot.profile.id, robot.driven, moving, at_ns))


class LiveRecorder(Recorder):
    """Writes down how it is steered, too."""

    driven = b""

    def __init__(self, *parts: Any) -> None:  # noqa: ANN401 - as its base takes them
        super().__init__(*parts)
        self.steered = Wheels(self)

    async def execute_live(self, order: Order, tell: Tell, controls: LiveControls) -> Outcome:
        """Write down that it acts, when it does."""

        def told(report: StageReport) -> None:
            if report.stage is OrderStage.SENT:
                self.driven = order.cid
                self._act(order)
            tell(report)

        return await super().execute_live(order, told, controls)


class _Heard:
    """Writes down what reaches the gateway by a messenger, as said by whoever sent it."""

    def __init__(self, world: WaysWorld) -> None:
        self._world = world

    async def pass_on(self, receive: Receive, inbound: Inbound) -> None:
        base = tuple(line_id(inbound, line) for line in range(LINES_AT_MOST))
        who, text = SPEAKER.get(), inbound.text
        now_ns = self._world.clock.wall_ns()
        self._world.log.append(Said(who, text, base, now_ns, MessageValidity.FRESH, "", True))
        await receive(inbound)


class HeardPrograms(ProgramMessenger):
    def __init__(self, name: str, clock: Clock, heard: _Heard) -> None:
        super().__init__(name, clock)
        self._heard = heard

    async def run(self, receive: Receive) -> None:
        await super().run(partial(self._heard.pass_on, receive))


class HeardPage(PageMessenger):
    def __init__(self, name: str, clock: Clock, heard: _Heard) -> None:
        super().__init__(name, clock)
        self._heard = heard

    async def run(self, receive: Receive) -> None:
        await super().run(partial(self._heard.pass_on, receive))


class Socket:
    """A WebSocket of one client, in process.

    Attributes:
        told: What it was told, oldest first.
        closed: With which code the gateway has closed it; 0: it has not.
    """

    def __init__(self, app: Any, path: str, headers: Mapping[str, str], query: str = "") -> None:  # noqa: ANN401
        self.told: list[dict[str, Any]] = []
        self.closed = 0
        self._events: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self._events.put_nowait({"type": "websocket.connect"})
        shown = {"host": HOST, **headers}
        scope = {
            "type": "websocket",
            "asgi": {"version": "3.0", "spec_version": "2.3"},
            "http_version": "1.1",
            "scheme": "ws",
            "path": path,
            "raw_path": path.encode(),
            "query_string": query.encode(),
            "root_path": "",
            "headers": [(name.encode(), value.encode()) for name, value in shown.items()],
            "client": ("127.0.0.1", 50_000),
            "server": ("127.0.0.1", 8765),
            "subprotocols": [],
            "state": {},
        }
        self.task = asyncio.ensure_future(app(scope, self._events.get, self._send))

    async def _send(self, message: dict[str, Any]) -> None:
        if message["type"] == "websocket.close":
            self.closed = message.get("code", 1000)
        elif "text" in message:
            self.told.append(json.loads(message["text"]))

    def say(self, **message: Any) -> None:  # noqa: ANN401 - JSON
        self._events.put_nowait({"type": "websocket.receive", "text": json.dumps(message)})

    def leave(self) -> None:
        self._events.put_nowait({"type": "websocket.disconnect", "code": 1001})


class WaysWorld(World):
    """The world of histories, and an API in it.

    Attributes:
        keys: What the program Hal has ever shown; the newest last.
        answers: With which status each request was answered.
    """

    fleet = (OMNI, *(one for one in FLEET if one.id == "kuka1"))
    kind = LiveRecorder

    def __init__(self) -> None:
        super().__init__()
        self.keys: list[str] = []
        self.answers: list[int] = []
        self._serial = 0
        self._cookies: dict[str, str] = {}
        self._sockets: dict[tuple[str, str], Socket] = {}
        self._asking: set[asyncio.Task[None]] = set()

    def besides(self) -> tuple[Messenger, ...]:
        heard = _Heard(self)
        self._program = HeardPrograms("api", self.clock, heard)
        self._page = HeardPage("page", self.clock, heard)
        return (self._program, self._page)

    async def start(self) -> None:
        await super().start()
        gateway = self.gateway
        messengers = (self._program, self._page)
        programs = ProgramService(gateway.rooms, gateway.access.programs)
        settings = ApiSettings(listen=HostPort("127.0.0.1", 8765))
        self._server = ApiServer(gateway.kernel, settings, messengers, programs, gateway.languages)
        self.app: Any = self._server._config(settings, self._server._routed(), settings.limits).app
        self._sockets.clear()
        self._opening = asyncio.Lock()
        if not self.keys:
            new = gateway.access.programs.enrol("Hal", InvitedRights(roles=("operator",)), OPERATOR)
            async with gateway.access.changes.turn() as turn:
                await turn.write(new.records)
            self._key = new.key.id
            self.keys.append(new.secret.reveal())
        # A start may hold the loop for long.
        while any(each.waited_ns() for each in messengers):  # noqa: ASYNC110 - nobody is told
            await asyncio.sleep(0.02)

    # ---- who says what, by which way ----

    def ask(self, who: str, path: str, body: dict[str, Any], key: str = "") -> None:
        """Send a request, and wait for nothing."""
        self._begin(who, self._ask(who, path, body, key))

    def _begin(self, who: str, asking: Coroutine[Any, Any, None]) -> None:
        SPEAKER.set("Hal" if who == OLD_KEY and len(self.keys) == 1 else who)
        task = asyncio.ensure_future(asking)
        self._asking.add(task)
        task.add_done_callback(self._asking.discard)

    async def _ask(self, who: str, path: str, body: dict[str, Any], key: str) -> None:
        headers = {"Idempotency-Key": key} if key else {}
        answer = await self.request(who, "POST", path, json=body, headers=headers)
        self.answers.append(answer.status_code)

    async def request(self, who: str, method: str, path: str, **how: Any) -> httpx.Response:  # noqa: ANN401 - as httpx takes it
        """Ask, and return the answer."""
        if not SPEAKER.get(""):
            SPEAKER.set(who)
        transport = httpx.ASGITransport(app=self.app, raise_app_exceptions=False)
        async with httpx.AsyncClient(transport=transport, base_url=ORIGIN) as client:
            client.headers.update(await self._shown(who, client))
            return await client.request(method, path, **how)

    async def _shown(self, who: str, client: httpx.AsyncClient) -> dict[str, str]:
        if who == "Hal":
            return {"Authorization": f"Bearer {self.keys[-1]}"}
        if who == OLD_KEY:
            return {"Authorization": f"Bearer {self.keys[0]}"}
        if who not in self._cookies:
            people = self.gateway.rooms.authoriser.directory.people()
            known = [person.id for person in people if person.name == who]
            if known:
                code = self.gateway.access.page_sessions.offer(known[0]).reveal()
                came = await client.post(
                    "/v1/sessions", json={"code": code}, headers={"Origin": ORIGIN}
                )
                cookies = [f"{name}={value}" for name, value in came.cookies.items()]
                if came.status_code == 201:
                    self._cookies[who] = "; ".join(cookies)
        client.cookies.clear()
        return {"Origin": ORIGIN, "Cookie": self._cookies.get(who, "")}

    def hold(self, who: str, path: str, robot: str, linear: float, *, ahead_s: float = 0.0) -> None:
        """Send one sample over a connection that is held open, by a clock that may be wrong."""
        self._begin(who, self._hold(who, path, robot, linear, ahead_s))

    async def _hold(self, who: str, path: str, robot: str, linear: float, ahead_s: float) -> None:
        socket = await self.socket(who, path)
        self._serial += 1
        self.log.append(Sampled(SPEAKER.get(), self.clock.monotonic_ns()))
        if path == "/rosbridge":
            twist = {"linear": {"x": linear}, "angular": {"z": 0.0}}
            socket.say(op="publish", topic=f"/{robot}/cmd_vel", msg=twist)
        else:
            sent_ms = self.clock.wall_ns() / 1e6 + ahead_s * 1e3
            values = {"linear": linear}
            how = {"robot": robot, "skill": "drive", "n": self._serial, "sent_ms": sent_ms}
            socket.say(op="jog", values=values, release=not linear, **how)

    async def socket(self, who: str, path: str) -> Socket:
        """Return the connection that somebody holds open, a new one if there is none."""
        async with self._opening:
            known = self._sockets.get((who, path))
            if known is None or known.task.done():
                transport = httpx.ASGITransport(app=self.app)
                async with httpx.AsyncClient(transport=transport, base_url=ORIGIN) as client:
                    shown = await self._shown(who, client)
                headers = {name.lower(): value for name, value in shown.items()}
                known = self._sockets[who, path] = Socket(self.app, path, headers)
            return known

    async def bridged(self, ticket: str) -> int:
        """Come to rosbridge with a ticket; return with which code it is closed, 0 if it is not."""
        socket = Socket(self.app, "/rosbridge", {}, f"ticket={ticket}")
        await self.turns(200)
        closed = socket.closed
        socket.leave()
        await socket.task
        return closed

    def leave(self, who: str, path: str) -> None:
        """Close a connection, if there is one."""
        if (socket := self._sockets.pop((who, path), None)) is not None:
            socket.leave()

    def stop(self, who: str, robots: tuple[str, ...], *, by_socket: bool) -> None:
        """Stop robots, by REST or over the connection of a page."""
        self._begin(who, self._stop(who, robots, by_socket=by_socket))

    async def _stop(self, who: str, robots: tuple[str, ...], *, by_socket: bool) -> None:
        if by_socket:
            socket = await self.socket(who, "/v1/events")
            self._note_stop(who, robots)
            socket.say(op="stop", robots=robots, id="s")
        else:
            self._note_stop(who, robots)
            await self._ask(who, "/v1/stop", {"robots": robots, "wait_s": 0}, "")

    def _note_stop(self, who: str, robots: tuple[str, ...]) -> None:
        """Whoever has not signed in yet, as the disk is broken, stops by their chat."""
        if who == "Hal" or who in self._cookies:
            self.log.append(StopSent(SPEAKER.get(), robots))

    async def rotate(self) -> None:
        """Give Hal another secret; the one of before counts no more."""
        if self.disk.broken or not self.disk.ready.is_set() or "Hal" in self.revoked:
            return
        access = self.gateway.access
        secret, fact = access.programs.secret_for(self._key)
        async with access.changes.turn() as turn:
            await turn.write((fact,))
        self.keys.append(secret.reveal())

    async def heal(self) -> None:
        await super().heal()
        for socket in self._sockets.values():
            socket.leave()
        for _ in range(50):
            await asyncio.sleep(0)
        await self.clock.advance(30.0)


# ---- what must hold besides ----


def stops_are_given(log: list[Event]) -> None:
    """I10: a stop that was sent by whoever may see a robot stops it, unless the gateway ended."""
    latched: set[str] = set()
    owed: dict[str, StopSent] = {}
    revoked: set[str] = set()
    for event in log:
        match event:
            case StopSent() if event.who in (MOVERS | WATCHERS) - revoked:
                robots = event.robots or ("omni", "kuka1")
                owed.update({robot: event for robot in robots if robot not in latched})
            case Latched():
                latched.add(event.robot)
                owed.pop(event.robot, None)
            case Unlatched():
                latched.discard(event.robot)
            case Revoked():
                revoked.add(event.who)
                owed = {robot: sent for robot, sent in owed.items() if sent.who != event.who}
            case Started():
                owed.clear()
                latched = {robot for robot, (*_, holds) in event.gates.items() if holds}
    assert not owed, f"I10: never stopped: {owed}"


def judge_live(log: list[Event]) -> None:  # noqa: C901, PLR0915 - one story, told in order
    """I5, I6, I8 of what is steered: held by its author, allowed, and nothing after a stop."""
    author: dict[bytes, str] = {}
    stopped: set[bytes] = set()
    driving: dict[str, tuple[bytes, int]] = {}
    newest: dict[str, int] = {}
    under_way: dict[str, bytes] = {}
    revoked: set[str] = set()
    for event in log:
        match event:
            case Said():
                author.update(dict.fromkeys(event.base, event.who))
            case Sampled():
                newest[event.who] = event.at_ns
            case Revoked():
                revoked.add(event.who)
            case Acted():
                under_way[event.robot] = event.cid
            case Latched():
                if (cid := under_way.get(event.robot)) is not None:
                    stopped.add(cid)
            case Started():
                driving.clear()
            case Steered():
                since = driving.pop(event.robot, None)
                who = author.get(event.cid, "")
                held_ns = newest.get(who, 0)
                if since is not None:
                    still_s = (event.at_ns - max(held_ns, since[1])) / 1e9
                    assert still_s <= REST_WITHIN_S, f"I6: {still_s} s without a hand: {event}"
                if event.moving:
                    assert event.cid not in stopped, f"I5: it was stopped: {event}"
                    assert who in MOVERS - revoked, f"I8: {who} may not steer: {event}"
                    driving[event.robot] = (event.cid, event.at_ns)
    stops_are_given(log)
    assert not driving, f"I6: it is driven for ever: {driving}"
