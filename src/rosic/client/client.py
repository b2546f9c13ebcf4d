"""The client: robots, orders, stops and the chat of a gateway, from anywhere that reaches it."""

from __future__ import annotations

import asyncio
import random
from contextlib import aclosing, suppress
from secrets import token_urlsafe
from typing import TYPE_CHECKING, Final, Self

from rosic.api.event_schemas import OrderEvent
from rosic.api.resource_schemas import FileOut
from rosic.api.schemas import (
    AnswerOut,
    ChatIn,
    CheckOut,
    IdentityOut,
    OrderIn,
    OrderOut,
    RobotOut,
    SkillOut,
    StopIn,
    StopOut,
)
from rosic.client.connection import ANSWER_S, PROBLEM, ApiCall, GatewayAddress, ask, fetch
from rosic.client.content import ContentCalls
from rosic.client.errors import (
    ClientError,
    GatewayFault,
    GatewayUnreachable,
    NotAGateway,
    NotAnswered,
    NotKnown,
    NotTrusted,
    TooManyCalls,
)
from rosic.client.events import Connected, EventConnection
from rosic.client.resources import part

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Awaitable, Callable, Mapping
    from pathlib import Path
    from typing import TypeVar

    import httpx

    from rosic.client.connection import MediaContent
    from rosic.client.events import Happening
    from rosic.core.secret import Secret

    T = TypeVar("T")

ORDER_WITHIN_S: Final = 4.0
"""So long an order is given again that was not answered: motion that was asked for any longer ago
is not wanted any more."""
READ_WITHIN_S: Final = 10.0
FIRST_PAUSE_S: Final = 0.2
LONGEST_PAUSE_S: Final = 3.0
WAIT_AT_ONCE_S: Final = 30.0
STOP_WAIT_S: Final = 15.0
ASKED: Final = "asked"
ASK_EVERY_S: Final = 1.0
MOST_LISTED: Final = 200


class RosicClient(ContentCalls):
    """Asks a gateway. Use it as ``async with RosicClient(url, key) as gateway:``.

    What only looks is asked again while nobody answers; an order is known by a key of its own, so
    that asking again gives it once; a stop is asked for until it is answered. Nothing else is ever
    sent twice.

    Args:
        url: Where the gateway is: ``https://robots.example.org``.
        key: As ``rosic key create`` shows it.
        ca: File of the certificates that are trusted, in PEM; empty: those of this machine.
        unencrypted: Other machines may be asked without TLS: whoever listens reads the key.

    Raises:
        ConfigurationError: It is no address or no key, or the file cannot be used.
    """

    def __init__(
        self, url: str, key: Secret | str, *, ca: str | Path = "", unencrypted: bool = False
    ) -> None:
        self._address = GatewayAddress(url, key, ca=ca, unencrypted=unencrypted)
        self._http: httpx.AsyncClient = self._address.http()

    @property
    def url(self) -> str:
        """Where the gateway is."""
        return self._address.url

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def close(self) -> None:
        """Ask nothing any more."""
        await self._http.aclose()

    # ---- what there is ----
    #
    # Each raises ApiProblem where the gateway says no, and NotAnswered where it does not answer.

    async def me(self) -> IdentityOut:
        """Return who I am to the gateway."""
        return await self._look("me", IdentityOut)

    async def robots(self) -> list[RobotOut]:
        """Return the robots that I may see, as they are now."""
        return await self._look("robots", list[RobotOut])

    async def robot(self, robot: str) -> RobotOut:
        """Return one robot as it is now."""
        return await self._look(f"robots/{part(robot)}", RobotOut)

    async def skills(self, robot: str) -> list[SkillOut]:
        """Return what I may ask of a robot, with the schema of its arguments."""
        return await self._look(f"robots/{part(robot)}/skills", list[SkillOut])

    async def orders(self, robot: str = "", *, limit: int = 50) -> list[OrderOut]:
        """Return the newest orders of robots that I may see, whoever gave them; newest first."""
        params: dict[str, str | float] = {"limit": min(limit, MOST_LISTED)}
        if robot:
            params["robot"] = robot
        return await self._look("orders", list[OrderOut], params=params)

    # ---- orders ----

    async def check(
        self, robot: str, skill: str, arguments: Mapping[str, float | str] | None = None
    ) -> CheckOut:
        """Return what an order would come to. Nothing is done, counted or written.

        Its arguments are in the units that `skills` says, as they are given.

        Raises:
            ApiProblem: It would be refused, and why.
            NotAnswered: The gateway does not answer.
        """
        body = OrderIn(skill, dict(arguments or {}))
        call = ApiCall("POST", f"robots/{part(robot)}/orders/check", body)
        return await _again(lambda: ask(self._http, call, CheckOut), READ_WITHIN_S)

    async def order(
        self,
        robot: str,
        skill: str,
        arguments: Mapping[str, float | str] | None = None,
        *,
        key: str = "",
        wait_s: float = 0.0,
    ) -> OrderOut:
        """Give an order, once, and return what became of it so far.

        The arguments of what is returned are in the units in which they are given.

        Args:
            robot: Of which robot.
            skill: What.
            arguments: By name, in the units that `skills` says.
            key: By which the order is known: the same again is the same order. Left out, it is
                a new one.
            wait_s: Waits so long for its end.

        Raises:
            ApiProblem: It is refused. Nothing was done.
            NotKnown: It was sent, and not answered: it may be under way. The same again with the
                same key does nothing twice; `orders` says what is under way.
            NotAnswered: Otherwise nothing was done.
        """
        body = OrderIn(skill, dict(arguments or {}))
        headers = {"Idempotency-Key": key or token_urlsafe(24)}
        call = ApiCall("POST", f"robots/{part(robot)}/orders", body, headers)
        placed: OrderOut = await _again(lambda: ask(self._http, call, OrderOut), ORDER_WITHIN_S)
        return await self.wait(placed, wait_s) if wait_s > 0 else placed

    async def wait(self, order: OrderOut | str, wait_s: float) -> OrderOut:
        """Return an order once it is over, or after so many seconds.

        Raises:
            ApiProblem: There is none any more, as after a restart of the gateway.
            NotAnswered: The gateway does not answer any more; the order may go on.
        """
        loop = asyncio.get_running_loop()
        until = loop.time() + wait_s
        found = order if isinstance(order, OrderOut) else await self._order(order, 0.0)
        while not found.over and (left_s := until - loop.time()) > 0:
            found = await self._order(found.id, min(left_s, WAIT_AT_ONCE_S))
        return found

    async def _order(self, order: str, wait_s: float) -> OrderOut:
        return await self._look(
            f"orders/{part(order)}", OrderOut, params={"wait_s": wait_s}, more_s=wait_s
        )

    async def follow(self, order: OrderOut | str) -> AsyncGenerator[OrderOut, None]:
        """Yield an order as it is now, each time that it has come further, until it is over.

        While a person is asked about it, it is asked for each second.

        The connection is made again by itself; what happened meanwhile is seen then, the newest
        state alone.

        Raises:
            ApiProblem: There is no such order any more, or the key is not good any more.
            NotTrusted, NotAGateway: See `events`.
        """
        order_id = order if isinstance(order, str) else order.id
        shown = await self._order(order_id, 0.0)
        yield shown
        if shown.state == ASKED:
            shown = await self._agreed(order_id)
            yield shown
        if shown.over:
            return
        async with aclosing(self.events("orders")) as happening:
            async for event in happening:
                if isinstance(event, Connected):  # what was missed may be too old to be told again
                    found = await self._order(order_id, 0.0)
                elif isinstance(event, OrderEvent) and event.order.id == order_id:
                    found = event.order
                else:
                    continue
                if _progress(found) > _progress(shown):
                    shown = found
                    yield found
                if found.over:
                    return

    async def _agreed(self, order_id: str) -> OrderOut:
        """Return an order once nobody is asked about it any more, looking each second."""
        while True:
            await asyncio.sleep(ASK_EVERY_S)
            with suppress(GatewayUnreachable, GatewayFault, TooManyCalls):
                found = await self._order(order_id, 0.0)
                if found.state != ASKED:
                    return found

    async def cancel(self, order: OrderOut | str) -> AnswerOut:
        """End what I have under way with the robot of an order; nothing is latched.

        Raises:
            ApiProblem: There is no such order.
            NotAnswered: `NotKnown`: it may have been done; otherwise it was not.
        """
        order_id = order if isinstance(order, str) else order.id
        return await self._once(f"orders/{part(order_id)}/cancel", AnswerOut, None)

    # ---- stops ----

    async def stop(
        self,
        *robots: str,
        wait_s: float = STOP_WAIT_S,
        on_trouble: Callable[[ClientError], object] | None = None,
    ) -> StopOut:
        """Stop robots; all that I may see, if none is named. They stay stopped.

        It is asked for until it is answered, however long that takes: cancel it, or put it under
        `asyncio.timeout`, to leave off. A stop that is given twice is one.

        Args:
            robots: Which. A name that is none stops all of them.
            wait_s: So long the gateway waits for measured rest before it answers.
            on_trouble: Hears, each time, why nobody has answered yet.

        Returns:
            What the gateway knows: whether all of them were measured at rest.

        Raises:
            ApiProblem: The gateway says that this key stops nothing.
            NotTrusted, NotAGateway: It would never be answered. Nothing was stopped.
        """
        body, pause_s = StopIn(robots=robots, wait_s=wait_s), FIRST_PAUSE_S
        call = ApiCall("POST", "stop", body, within_s=wait_s + ANSWER_S)
        while True:
            try:
                return await ask(self._http, call, StopOut)
            except (GatewayUnreachable, NotKnown, GatewayFault, TooManyCalls) as trouble:
                if on_trouble is not None:
                    on_trouble(trouble)
                wanted = trouble.retry_after_s if isinstance(trouble, TooManyCalls) else None
                await asyncio.sleep(_pause(pause_s) if wanted is None else min(wanted, pause_s))
                pause_s = min(pause_s * 2, LONGEST_PAUSE_S)

    # ---- whatever else a chat could say ----

    async def chat(self, text: str, *, wait_s: float = 10.0) -> AnswerOut:
        """Say what could be typed in a chat, and return the first answer.

        Raises:
            ApiProblem: It is not taken.
            NotAnswered: `NotKnown`: it may have been done; otherwise it was not.
        """
        return await self._once("chat", AnswerOut, ChatIn(text=text, wait_s=wait_s), wait_s)

    # ---- what happens ----

    async def events(self, *topics: str) -> AsyncGenerator[Happening, None]:
        """Yield what happens with robots and orders, and what passes, as it happens.

        The connection is made again by itself: a `Connected` says each time that it stands, and
        what follows is how things are now; a `Disconnected` says that it does not, and why.

        Args:
            topics: ``robots``, ``orders``, ``rates``; ``chat`` is told to the page of a person.

        Raises:
            ApiProblem: The key is none, or not good any more.
            NotTrusted, NotAGateway: It cannot be known who answers there.
        """
        connection = EventConnection(self._address, self.me)
        pause_s = FIRST_PAUSE_S
        while True:
            async with aclosing(connection.once(topics)) as happening:
                async for event in happening:
                    if isinstance(event, Connected):
                        pause_s = FIRST_PAUSE_S
                    yield event
            await asyncio.sleep(_pause(pause_s))
            pause_s = min(pause_s * 2, LONGEST_PAUSE_S)

    # ---- asking ----

    async def _look(
        self,
        path: str,
        type_: type[T],
        *,
        params: Mapping[str, str | float] | None = None,
        more_s: float = 0.0,
    ) -> T:
        """Ask for what changes nothing: as often as it takes, for some seconds."""
        call = ApiCall("GET", path, params=params, within_s=ANSWER_S + more_s)
        return await _again(lambda: ask(self._http, call, type_), READ_WITHIN_S)

    async def _once(
        self, path: str, type_: type[T], body: object, more_s: float = 0.0, *, method: str = "POST"
    ) -> T:
        """Ask for what may change something: again only where nobody has heard of it."""
        call = ApiCall(method, path, body, within_s=ANSWER_S + more_s)
        return await _again(lambda: ask(self._http, call, type_), READ_WITHIN_S, unheard=True)

    async def _fetch(
        self,
        path: str,
        kind: str,
        *,
        params: Mapping[str, str | float] | None = None,
        more_s: float = 0.0,
    ) -> MediaContent:
        """Ask for what is no JSON; again as `_look` does."""
        accept = {"Accept": f"{kind}{'*' if kind.endswith('/') else ''}, {PROBLEM}"}
        call = ApiCall("GET", path, headers=accept, params=params, within_s=ANSWER_S + more_s)
        return await _again(lambda: fetch(self._http, call, kind), READ_WITHIN_S)

    async def _send(self, path: str, content: bytes, name: str, more_s: float) -> FileOut:
        """Send a content as it is; again only where nobody has heard of it."""
        call = ApiCall("POST", path, content, params={"name": name}, within_s=ANSWER_S + more_s)
        return await _again(lambda: ask(self._http, call, FileOut), READ_WITHIN_S, unheard=True)


async def _again(once: Callable[[], Awaitable[T]], within_s: float, *, unheard: bool = False) -> T:
    """Ask, and again for so long while nobody answers.

    Args:
        once: Asks.
        within_s: It is begun no later than that.
        unheard: Again only where it is certain that nobody has heard it.
    """
    loop = asyncio.get_running_loop()
    until, pause_s = loop.time() + within_s, FIRST_PAUSE_S
    while True:
        try:
            return await once()
        except (NotTrusted, NotAGateway):
            raise
        except NotAnswered as none:
            heard = not isinstance(none, GatewayUnreachable)
            if (heard and unheard) or loop.time() + pause_s >= until:
                raise
        await asyncio.sleep(_pause(pause_s))
        pause_s = min(pause_s * 2, LONGEST_PAUSE_S)


def _pause(most_s: float) -> float:
    """Return how long to wait: not all clients at the same moment."""
    return most_s * random.uniform(0.5, 1.0)  # noqa: S311 - spreads load, guards nothing


def _progress(order: OrderOut) -> tuple[bool, int, float]:
    """Return how far an order has come: what was on its way may be older than what was asked."""
    return order.over, len(order.stages), order.fraction or 0.0
