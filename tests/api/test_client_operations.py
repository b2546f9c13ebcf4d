"""The client asks for every operation of the description, as that describes it; or it says why not.

It asks a real gateway, through what writes down each request.
"""

from __future__ import annotations

import inspect
import re
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Any, Final, NamedTuple
from urllib.parse import unquote

import httpx
from aiohttp import web
from jsonschema import Draft202012Validator

from rosic.client import ApiProblem, RosicClient
from tests.api.served import served
from tests.api.test_client import answering

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Mapping

BROWSERS: Final = "a session and its passkeys are of a browser"
NO_KEY: Final = "no key is made that may do it"
NOT_BY_THE_CLIENT: Final[Mapping[str, str]] = {
    "POST /v1/sessions": BROWSERS,
    "DELETE /v1/sessions/current": BROWSERS,
    "POST /v1/sessions/passkey/options": BROWSERS,
    "POST /v1/sessions/passkey": BROWSERS,
    "GET /v1/passkeys": BROWSERS,
    "POST /v1/passkeys/options": BROWSERS,
    "POST /v1/passkeys": BROWSERS,
    "DELETE /v1/passkeys/{passkey}": BROWSERS,
    "GET /v1/chat": "a program has no conversation on the page",
    "GET /v1/chat/{message}/file": "a program has no conversation on the page",
    "POST /v1/tickets": "a ticket is for a library of rosbridge, which shows no header",
    "POST /v1/robots/{robot}/stop": "stop(robot) is the same, and is not left off",
    "GET /v1/people": NO_KEY,
    "POST /v1/people/{person}/rights": NO_KEY,
    "GET /v1/health": NO_KEY,
    "GET /v1/metrics": NO_KEY,
    "GET /v1/invitations": NO_KEY,
    "POST /v1/invitations": NO_KEY,
    "DELETE /v1/invitations/{invitation}": NO_KEY,
    "POST /v1/access-requests/{request_id}/allow": NO_KEY,
    "POST /v1/access-requests/{request_id}/deny": NO_KEY,
    "GET /v1/roles": NO_KEY,
    "PUT /v1/roles/{role}": NO_KEY,
    "DELETE /v1/roles/{role}": NO_KEY,
    "POST /v1/rights/check": NO_KEY,
}
BODIES: Final[Mapping[str, dict[str, Any]]] = {
    "POST /v1/people/{person}/rights": {"rights": "viewer"},
    "POST /v1/invitations": {"rights": "viewer"},
    "POST /v1/access-requests/{request_id}/allow": {},
    "PUT /v1/roles/{role}": {"gives": "omni:move"},
    "POST /v1/rights/check": {"person": "Bo", "line": "omni move 1 m"},
}
AT: Final = "2031-02-01T14:00:00Z"
MOVE: Final[dict[str, float | str]] = {"distance": 0.1, "direction": "left"}
CALLS: Final[Mapping[str, tuple[Callable[[RosicClient], Awaitable[object]], ...]]] = {
    "me": (lambda to: to.me(),),
    "robots": (lambda to: to.robots(),),
    "robot": (lambda to: to.robot("omni"),),
    "skills": (lambda to: to.skills("omni"),),
    "orders": (lambda to: to.orders("omni", limit=7),),
    "check": (lambda to: to.check("omni", "move", MOVE),),
    "order": (lambda to: to.order("omni", "move", MOVE, key="one"),),
    "wait": (lambda to: to.wait("00", 0.1),),
    "cancel": (lambda to: to.cancel("00"),),
    "stop": (lambda to: to.stop("omni", wait_s=0.1), lambda to: to.stop(wait_s=0.1)),
    "chat": (lambda to: to.chat("status omni"),),
    "bookings": (lambda to: to.bookings("omni", begin=AT, end="2031-02-02T14:00:00Z"),),
    "book": (lambda to: to.book("omni", AT, 30),),
    "move_booking": (lambda to: to.move_booking("none", AT, 30),),
    "give_back": (lambda to: to.give_back("none"),),
    "queue": (lambda to: to.queue("omni"),),
    "join_queue": (lambda to: to.join_queue("omni"),),
    "leave_queue": (lambda to: to.leave_queue("omni"),),
    "take_turn": (lambda to: to.take_turn("omni"),),
    "take_over": (lambda to: to.take_over("omni"),),
    "release": (lambda to: to.release("omni"),),
    "access_requests": (lambda to: to.access_requests(),),
    "ask_for": (lambda to: to.ask_for("omni", "move", 30),),
    "tasks": (lambda to: to.tasks(),),
    "give_task": (lambda to: to.give_task("omni", "wave", options="at 8:00"),),
    "act_on_task": (lambda to: to.act_on_task("1", "pause"),),
    "missions": (lambda to: to.missions(),),
    "start_mission": (lambda to: to.start_mission("none", "every mon 8:00"),),
    "act_on_mission": (lambda to: to.act_on_mission("none", "go"),),
    "telemetry": (lambda to: to.telemetry("omni", "battery", since_s=60),),
    "utilisation": (lambda to: to.utilisation(),),
    "alerts": (lambda to: to.alerts(),),
    "seen": (lambda to: to.seen("omni"),),
    "history": (lambda to: to.history("omni", text="left", since_s=60, limit=7),),
    "history_table": (lambda to: to.history_table("omni", text="left", since_s=60),),
    "picture": (lambda to: to.picture("omni", "map", low=True),),
    "files": (lambda to: to.files(),),
    "send_file": (lambda to: to.send_file("notes.txt", b"one"),),
    "file_content": (lambda to: to.file_content("none"),),
    "delete_file": (lambda to: to.delete_file("none"),),
}
"""Every method that asks over HTTP, by its name, with every argument that it has."""


class AskedRequest(NamedTuple):
    method: str
    path: str
    query: dict[str, str]
    body: bytes


@asynccontextmanager
async def noted(url: str, asked: list[AskedRequest]) -> AsyncIterator[str]:
    """Yield an address that notes what it is asked, and asks it of a gateway."""
    async with httpx.AsyncClient(base_url=url, timeout=60) as http:

        async def ask(request: web.Request) -> web.Response:
            body = await request.read()
            asked.append(AskedRequest(request.method, request.path, dict(request.query), body))
            passed = ("Authorization", "Accept", "Content-Type", "Idempotency-Key")
            headers = {name: request.headers[name] for name in passed if name in request.headers}
            found = await http.request(
                request.method, request.rel_url.raw_path_qs, content=body, headers=headers
            )
            kind = {"Content-Type": found.headers.get("content-type", "text/plain")}
            return web.Response(status=found.status_code, body=found.content, headers=kind)

        async with answering(ask) as there:
            yield there


def operations(described: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {
        f"{method.upper()} {path}": operation
        for path, methods in described["paths"].items()
        for method, operation in methods.items()
    }


def meant(asked: AskedRequest, described: dict[str, Any]) -> str:
    """Return the operation that a request is of; of two that fit, the one with fewer parameters."""

    def fits(operation: str) -> bool:
        method, _, path = operation.partition(" ")
        form = re.sub(r"\{\w+\}", "[^/]+", path)
        return method == asked.method and re.fullmatch(form, unquote(asked.path)) is not None

    found = [operation for operation in operations(described) if fits(operation)]
    assert found, f"there is no {asked.method} {asked.path}"
    return min(found, key=lambda operation: operation.count("{"))


def check_described(asked: AskedRequest, operation: str, described: dict[str, Any]) -> None:
    """See that a request is as its operation describes it."""
    found = operations(described)[operation]
    known = {one["name"] for one in found.get("parameters", ()) if one["in"] == "query"}
    assert set(asked.query) <= known, operation
    content = found.get("requestBody", {}).get("content", {})
    assert bool(content) == bool(asked.body), operation
    if "application/json" in content:
        schema = {**content["application/json"]["schema"], "components": described["components"]}
        Draft202012Validator(schema).validate(httpx.Response(200, content=asked.body).json())


def methods() -> set[str]:
    """Return the methods of the client that ask and answer once."""
    found = inspect.getmembers(RosicClient, inspect.iscoroutinefunction)
    return {name for name, _ in found if not name.startswith("_")} - {"close"}


async def test_every_operation_is_asked_for_as_it_is_described_or_it_is_said_why_not() -> None:
    assert methods() == set(CALLS)
    async with served() as place:
        described = (await place.http.get("/v1/openapi/openapi.json")).json()
        by_the_client = set[str]()
        asked = list[AskedRequest]()
        async with (
            noted(place.url, asked) as there,
            RosicClient(there, await place.key("senior")) as client,
        ):
            for calls in CALLS.values():
                for call in calls:
                    with suppress(ApiProblem):
                        await call(client)
        for one in asked:
            operation = meant(one, described)
            check_described(one, operation, described)
            by_the_client.add(operation)
        assert by_the_client | set(NOT_BY_THE_CLIENT) == set(operations(described))
        assert by_the_client.isdisjoint(NOT_BY_THE_CLIENT)


async def test_what_no_key_may_is_refused_to_the_best_key_there_is() -> None:
    async with served() as place:
        hal = await place.program("senior")
        for operation, why in NOT_BY_THE_CLIENT.items():
            if why != NO_KEY:
                continue
            method, _, path = operation.partition(" ")
            url = re.sub(r"\{\w+\}", "guest", path)
            answer = await hal.request(method, url, json=BODIES.get(operation))
            assert answer.status_code in {403, 404}, (operation, answer.text)
