"""Every route that could change something, asked by whoever must not: refused, whatever it is."""

from __future__ import annotations

import asyncio
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import pytest
from litestar.routes import HTTPRoute, WebSocketRoute
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from rosic.api.access_checks import SAFE
from rosic.api.settings import ApiSettings, ServingLimits
from rosic.core.identity import OPERATOR
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from rosic.core.rate_limit import RateLimit
from rosic.core.records import Fact
from rosic.stores.memory import MemoryStore
from tests.api.served import ANYWHERE, ServedGateway, problem, served

if TYPE_CHECKING:
    from collections.abc import Iterator

    import httpx

    from rosic.core.records import Record

NAMES = {
    "robot": "omni",
    "order": "00",
    "person": "x",
    "file": "x",
    "request": "x",
    "task": "1",
    "act": "cancel",
}
SIGNS_IN = frozenset(
    {
        ("POST", "/v1/sessions"),
        ("POST", "/v1/sessions/passkey"),
        ("POST", "/v1/sessions/passkey/options"),
    }
)
"""Whoever signs in shows a code or a passkey instead of a key."""
SPEAKS = frozenset(
    {("POST", "/v1/chat"), ("POST", "/v1/tickets"), ("DELETE", "/v1/sessions/current")}
)
"""Whatever is said passes the rooms, which refuse it in an answer; a ticket is worth what its owner
is; everybody may sign out."""
ORDERS = "/v1/robots/omni/orders"
NOT_READ = "Das lässt sich nicht lesen oder passt hier nicht."
STOPS = frozenset({("POST", "/v1/stop"), ("POST", "/v1/robots/{robot:str}/stop")})
"""Whoever sees a robot may stop it; what they do not see stays as it is."""


def routes(place: ServedGateway) -> Iterator[tuple[str, str]]:
    """Yield method and path of everything that the application serves."""
    for route in place.server.app.routes:
        if isinstance(route, HTTPRoute):
            yield from ((method, route.path) for method in sorted(route.methods))
        elif isinstance(route, WebSocketRoute):
            yield "WS", route.path


def unsafe(place: ServedGateway) -> list[tuple[str, str]]:
    found = [(method, path) for method, path in routes(place) if method not in SAFE | {"WS"}]
    assert len(found) >= 8
    return found


def filled(path: str) -> str:
    """Return a path with a name of the demo in place of each parameter."""
    parts = (part.strip("{}").partition(":")[0] for part in path.split("/"))
    return "/".join(NAMES.get(part, part) for part in parts)


def session(browser: httpx.AsyncClient) -> dict[str, str]:
    return {"Cookie": "; ".join(f"{k}={v}" for k, v in browser.cookies.items())}


async def test_a_page_of_another_site_changes_nothing_with_the_session_of_its_visitor() -> None:
    store = CountingStore()
    async with served(store=store) as place:
        ada = await place.person("Ada")
        own = session(ada)
        foreign: dict[str, tuple[dict[str, str], int, str]] = {
            "no origin": (own, 403, "wrong-origin"),
            "foreign origin": (own | {"Origin": "http://evil.example"}, 403, "wrong-origin"),
            "no page at all": (own | {"Origin": "null"}, 403, "wrong-origin"),
            "other port": (own | {"Origin": "http://127.0.0.1:1"}, 403, "wrong-origin"),
            "cross-site": (
                own | {"Origin": place.url, "Sec-Fetch-Site": "cross-site"},
                403,
                "wrong-origin",
            ),
            "same-site": (
                own | {"Origin": place.url, "Sec-Fetch-Site": "same-site"},
                403,
                "wrong-origin",
            ),
            "foreign host": (
                own | {"Origin": "http://evil.example", "Host": "evil.example"},
                421,
                "wrong-host",
            ),
            "rebound": (own | {"Host": f"evil.example:{place.server.port}"}, 421, "wrong-host"),
        }
        before = store.count
        for method, path in unsafe(place):
            for name, (headers, status, code) in foreign.items():
                answer = await place.http.request(method, filled(path), headers=headers, json={})
                assert problem(answer)[:2] == (status, code), (name, method, path)
        assert store.count == before
        assert not place.gateway.rooms.stops["omni"].latched
        assert (await ada.get("/v1/me")).status_code == 200


async def test_whoever_shows_no_good_key_changes_nothing() -> None:
    often = ServingLimits(reads=RateLimit(burst=10_000.0, per_s=20.0))
    async with served(ApiSettings(listen=ANYWHERE, limits=often)) as place:
        over = await place.key("senior", name="Over")
        await revoke(place, over)
        shown: dict[str, dict[str, str]] = {
            "no key": {},
            "an ended key": {"Authorization": f"Bearer {over}"},
            "a wrong key": {"Authorization": f"Bearer {over}x"},
            "no kind of key": {"Authorization": over},
            "a broken key": {"Authorization": "Bearer rosic_"},
            "an empty session": {"Cookie": "rosic-session=", "Origin": place.url},
            "a wrong session": {"Cookie": "rosic-session=x", "Origin": place.url},
        }
        for method, path in unsafe(place):
            if (method, path) in SIGNS_IN:
                continue
            for name, headers in shown.items():
                for body in (b"{}", b"{"):
                    answer = await place.http.request(
                        method, filled(path), headers=headers, content=body
                    )
                    assert problem(answer)[:2] == (401, "unrecognised"), (name, method, path)
        assert not place.gateway.rooms.stops["omni"].latched


async def test_whoever_asks_is_recognised_on_the_loop_and_in_no_thread_beside_it() -> None:
    """Keys, limits and what is to be written down belong to the loop alone."""

    class NoThreads(ThreadPoolExecutor):
        def submit(self, *_args: object, **_how: object) -> Future[Any]:
            raise AssertionError("something was given to a thread")

    async with served() as place:
        hal = await place.program("operator")
        asyncio.get_running_loop().set_default_executor(NoThreads())
        assert (await hal.get("/v1/me")).status_code == 200
        hal.headers["Authorization"] = "Bearer nobody's"
        assert problem(await hal.get("/v1/me"))[:2] == (401, "unrecognised")


async def test_a_key_for_another_robot_changes_nothing_of_this_one() -> None:
    roles = {**DEFAULT_ROLES, "homer": Role(scopes=("kuka1:read", "kuka1:home"))}
    async with served(rules=RoleRules(roles=roles)) as place:
        secret = await place.key("homer", name="Kay")
        kay = place.client({"Authorization": f"Bearer {secret}"})
        bodies: dict[str, Any] = {
            "orders": {"skill": "move", "arguments": {"distance": 0.1}},
            "check": {"skill": "move", "arguments": {"distance": 0.1}},
        }
        for method, path in unsafe(place):
            body = bodies.get(path.rpartition("/")[2], {})
            answer = await kay.request(method, filled(path), json=body)
            if (method, path) in STOPS | SPEAKS | SIGNS_IN:
                continue
            assert 400 <= answer.status_code < 500, (method, path, answer.text)
        assert not place.gateway.rooms.stops["omni"].latched
        assert place.gateway.rooms.organiser.holder("omni") is None
        assert not list(place.server.context.feed.newest())
        said = await kay.post("/v1/chat", json={"text": "omni move 0.1 m"})
        assert said.json()["state"] == "not-done"


async def test_no_get_changes_anything() -> None:
    store = CountingStore()
    async with served(store=store) as place:
        ada = await place.person("Ada")
        before = store.count
        seen = 0
        for method, path in routes(place):
            if method == "GET":
                answer = await ada.get(filled(path))
                assert answer.status_code < 500, (path, answer.text)
                seen += 1
        assert seen >= 8
        assert store.count == before


async def test_a_websocket_is_opened_for_nobody_who_must_not() -> None:
    async with served() as place:
        ada = await place.person("Ada")
        own = session(ada)["Cookie"]
        over = await place.key("senior", name="Over")
        await revoke(place, over)
        wrong: dict[str, tuple[dict[str, str], str | None]] = {
            "no key": ({}, None),
            "an ended key": ({"Authorization": f"Bearer {over}"}, None),
            "no origin": ({"Cookie": own}, None),
            "foreign origin": ({"Cookie": own}, "http://evil.example"),
            "cross-site": ({"Cookie": own, "Sec-Fetch-Site": "cross-site"}, place.url),
            "foreign host": ({"Cookie": own, "Host": "evil.example"}, "http://evil.example"),
        }
        found = [path for method, path in routes(place) if method == "WS"]
        assert found
        for path in found:
            for name, (headers, origin) in wrong.items():
                url = place.url.replace("http", "ws", 1) + filled(path)
                with pytest.raises((InvalidStatus, ConnectionClosed)):
                    async with connect(url, additional_headers=headers, origin=origin) as opened:  # type: ignore[arg-type]
                        assert not await opened.recv(), (name, path)


async def test_what_no_route_takes_is_said_in_the_language_of_whoever_asks() -> None:
    german = "Unter dieser Adresse gibt es nichts."
    english = "There is nothing at this address."
    async with served() as place:
        ada = await place.person("Ada")
        await ada.post("/v1/chat", json={"text": "/language de"})
        for accepted, expected in {
            "de": german,
            "de-AT,en;q=0.8": german,
            "fr, en;q=0.2, de;q=0.5": german,
            "en-GB, de;q=0.9": english,
            "de;q=0, en": english,
            "": english,
            "tlh": english,
            ",;q=x,de;q=nan": english,
        }.items():
            there = {"Accept-Language": accepted}
            assert problem(await place.http.get("/v1/nothing", headers=there))[2] == expected
            known = await ada.get("/v1/nothing", headers=there)
            assert problem(known) == (404, "not-found", german)
        german_only = {"Accept-Language": "de"}
        anybody = place.client(german_only)
        assert problem(await anybody.put("/v1/stop")) == (
            *(405, "not-allowed"),
            "Das geht unter dieser Adresse nicht.",
        )
        assert problem(await anybody.get("/v1/me", headers={"Host": "evil.example"})) == (
            *(421, "wrong-host"),
            "Unter diesem Namen ist dieses Gateway nicht zu erreichen.",
        )
        foreign = await anybody.post("/v1/stop", headers={"Origin": "http://evil.example"})
        assert problem(foreign)[2].startswith("Eine Seite von anderswo darf das nicht verlangen.")
        unknown = await anybody.get("/v1/me")
        assert problem(unknown)[2].startswith("Zeige einen Schlüssel")
        odd = await ada.post("/v1/robots/omni/orders", json={"skill": 7})
        assert problem(odd)[2].startswith("Das passt hier nicht: skill")


@pytest.mark.parametrize(
    ("method", "path", "sent", "expected"),
    [
        ("POST", ORDERS, {"json": {}}, "skill fehlt"),
        ("POST", ORDERS, {"content": b""}, "der Inhalt fehlt"),
        ("POST", "/v1/files", {"content": b"x"}, "name fehlt"),
        ("POST", ORDERS, {"json": {"skill": "a", "x": 1}}, "x ist hier nicht bekannt"),
        ("POST", ORDERS, {"json": {"skill": 7}}, "skill muss Text sein"),
        ("POST", ORDERS, {"json": []}, "der Inhalt muss ein Objekt in JSON sein"),
        (
            *("POST", ORDERS, {"json": {"skill": "a", "arguments": [1]}}),
            "arguments muss ein Objekt in JSON sein",
        ),
        (
            *("POST", ORDERS, {"json": {"skill": "a", "arguments": {"b": None}}}),
            "arguments[...] muss eine Zahl oder Text sein",
        ),
        ("GET", "/v1/orders?limit=x", {}, "limit muss eine ganze Zahl sein"),
        ("GET", "/v1/orders/abc?wait_s=x", {}, "wait_s muss eine Zahl sein"),
        ("GET", "/v1/orders?limit=0", {}, "limit muss mindestens 1 sein"),
        ("POST", ORDERS, {"json": {"skill": "a", "wait_s": 61}}, "wait_s darf höchstens 60 sein"),
        ("POST", ORDERS, {"json": {"skill": ""}}, "skill muss mindestens 1 Zeichen haben"),
        (
            *("POST", ORDERS, {"json": {"skill": "a" * 65}}),
            "skill darf höchstens 64 Zeichen haben",
        ),
        ("GET", "/v1/robots/omni/views/soul", {}, "kind darf das nicht sein"),
        ("POST", ORDERS, {"content": b"{"}, NOT_READ),
    ],
)
async def test_what_is_wrong_with_a_field_is_said_in_the_language_of_whoever_asks(
    method: str, path: str, sent: dict[str, Any], expected: str
) -> None:
    async with served() as place:
        ada = await place.person("Ada")
        await ada.post("/v1/chat", json={"text": "/language de"})
        status, code, detail = problem(await ada.request(method, path, **sent))
        assert (status, code) == (400, "not-understood")
        what = expected if expected == NOT_READ else f"Das passt hier nicht: {expected}."
        assert detail == f"{what} Nichts wurde getan."


async def revoke(place: ServedGateway, secret: str) -> None:
    access = place.gateway.access
    key = secret.split("_")[1]
    await access.changes.take_away(access.keys.revoke(key, OPERATOR).records)


class CountingStore(MemoryStore):
    """Counts what is written, besides what a gateway writes on its own."""

    def __init__(self) -> None:
        super().__init__()
        self.count = 0

    async def write(self, *records: Record) -> None:
        own = (isinstance(one, Fact) and one.kind in {"tally", "high-water"} for one in records)
        self.count += len(records) - sum(own)
        await super().write(*records)
