"""Invitations, who asks for a right, roles, queues, tasks and missions: as in the chat."""

from __future__ import annotations

import asyncio
from base64 import b64decode
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING

import pytest

from rosic.client import NotKnown, RosicClient
from rosic.core.fleet.mission import Mission, MissionPart
from tests.api.served import ServedGateway, problem, served
from tests.gateway.test_hung import HangingStore
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    import httpx


@pytest.fixture
async def place() -> AsyncIterator[ServedGateway]:
    async with served() as place:
        yield place


async def test_an_invitation_is_made_shown_without_its_code_and_taken_back(
    place: ServedGateway,
) -> None:
    ada, bo = await place.person("Ada"), await place.person("Bo")
    made = await ada.post("/v1/invitations", json={"rights": "viewer for 2 hours", "name": "Cy"})
    assert made.status_code == 201, made.text
    new = made.json()
    assert new["code"] in new["text"]
    assert new["typed"] == f"join {new['code']}"
    assert b64decode(new["qr"].removeprefix("data:image/png;base64,")).startswith(b"\x89PNG")
    listed = await ada.get("/v1/invitations")
    assert listed.json() == [new["invitation"]]
    assert new["invitation"]["own"]
    assert new["code"] not in listed.text
    assert problem(await bo.get("/v1/invitations"))[:2] == (403, "not-permitted")
    may_not = await bo.post("/v1/invitations", json={"rights": "viewer"})
    assert problem(may_not)[:2] == (403, "not-permitted")
    path = f"/v1/invitations/{new['invitation']['id']}"
    assert problem(await bo.delete(path))[:2] == (403, "not-permitted")
    assert (await ada.delete(path)).status_code == 200
    assert (await ada.get("/v1/invitations")).json() == []
    assert problem(await ada.delete(path))[:2] == (404, "not-found")


async def test_what_the_record_does_not_answer_in_time_is_said_to_be_open_and_may_be_done() -> None:
    store = HangingStore()
    async with served(store=store) as place:
        ada, key = await place.person("Ada"), await place.key("operator")
        start = (datetime.now(UTC) + timedelta(days=1)).strftime("%Y-%m-%dT%H:%M:00Z")
        wanted = {
            "/v1/bookings": {"robot": "kuka1", "start": start, "minutes": 60},
            "/v1/invitations": {"rights": "viewer for 2 hours"},
        }
        mine = {"robot": "yumi", "start": start, "minutes": 60}
        booked = (await ada.post("/v1/bookings", json=mine)).json()
        shorter = {"start": start, "minutes": 30}
        store.goes_on.clear()
        async with RosicClient(place.url, key) as hal, asyncio.TaskGroup() as group:
            asked = [group.create_task(ada.post(path, json=wanted[path])) for path in wanted]
            moved = ada.patch(f"/v1/bookings/{booked['id']}", json=shorter)
            asked.append(group.create_task(moved))
            with pytest.raises(NotKnown, match="It may be done all the same"):
                await hal.book("omni", start, 30)
        late = [problem(answer.result()) for answer in asked]
        assert [found[:2] for found in late] == [(504, "late")] * 3
        assert all("It may be done all the same" in found[2] for found in late)
        store.goes_on.set()

        async def all_done() -> bool:
            found = (await ada.get("/v1/bookings")).json()
            ends = {one["robot"]: one["end"] for one in found}
            invited = (await ada.get("/v1/invitations")).json()
            return bool(invited) and ends.get("yumi", booked["end"]) < ends.get("kuka1", "")

        async with asyncio.timeout(60 * pace()):
            while not await all_done():  # noqa: ASYNC110 - nobody is told
                await asyncio.sleep(0.05)


async def test_a_part_of_a_line_begins_no_other_line(place: ServedGateway) -> None:
    ada = await place.person("Ada")
    for rights in ("viewer\n/revoke Bo", "viewer\u2028/revoke Bo", "  "):
        answer = await ada.post("/v1/invitations", json={"rights": rights})
        assert problem(answer)[:2] == (422, "not-understood"), rights
    answer = await ada.put("/v1/roles/guest%0Astop", json={"gives": "omni:read"})
    assert problem(answer)[0] in {404, 422}
    answer = await ada.post("/v1/tasks", json={"on": "omni", "steps": ["wave\nstop"]})
    assert problem(answer)[:2] == (422, "not-understood")
    assert not place.gateway.rooms.stops["omni"].latched


async def test_a_right_is_asked_for_allowed_and_denied(place: ServedGateway) -> None:
    ada, bo, vi = [await place.person(name) for name in ("Ada", "Bo", "Vi")]
    wanted = {"robot": "omni", "right": "move", "minutes": 30}
    asked = await vi.post("/v1/access-requests", json=wanted)
    assert asked.status_code == 201, asked.text
    [own] = (await vi.get("/v1/access-requests")).json()
    assert (own["own"], own["kind"], own["who"]) == (True, "right", "Vi")
    [waiting] = (await ada.get("/v1/access-requests")).json()
    assert (waiting["id"], waiting["own"]) == (own["id"], False)
    path = f"/v1/access-requests/{own['id']}"
    assert (await bo.get("/v1/access-requests")).json() == []
    assert problem(await bo.post(f"{path}/allow", json={}))[:2] == (404, "not-found")
    assert problem(await vi.post(f"{path}/allow", json={}))[:2] == (404, "not-found")
    order = {"skill": "move", "arguments": {"distance": 0.1}}
    before = await vi.post("/v1/robots/omni/orders/check", json=order)
    assert problem(before)[0] in {403, 404}
    allowed = await ada.post(f"{path}/allow", json={"minutes": 10})
    assert allowed.status_code == 200, allowed.text
    after = await vi.post("/v1/robots/omni/orders/check", json=order)
    assert after.status_code == 200, after.text
    again = await vi.post("/v1/access-requests", json=wanted | {"right": "drive"})
    assert again.status_code == 201, again.text
    [second] = (await ada.get("/v1/access-requests")).json()
    denied = await ada.post(f"/v1/access-requests/{second['id']}/deny")
    assert denied.status_code == 200, denied.text
    assert (await ada.get("/v1/access-requests")).json() == []


async def test_roles_are_listed_made_after_a_question_and_taken_back(place: ServedGateway) -> None:
    ada, vi = await place.person("Ada"), await place.person("Vi")
    assert problem(await vi.get("/v1/roles"))[:2] == (403, "not-permitted")
    names = {one["name"] for one in (await ada.get("/v1/roles")).json()}
    assert {"viewer", "operator", "admin"} <= names
    asked = await ada.put("/v1/roles/guest", json={"gives": "omni:move with speed <= 0.2 m/s"})
    assert asked.status_code == 200, asked.text
    assert "guest" in asked.json()["text"]
    assert "guest" not in {one["name"] for one in (await ada.get("/v1/roles")).json()}
    said = (await ada.get("/v1/chat")).json()[-1]
    yes = said["buttons"][0][0]["nonce"]
    await ada.post("/v1/chat", json={"message": said["id"], "button": yes})
    [guest] = [one for one in (await ada.get("/v1/roles")).json() if one["name"] == "guest"]
    assert (guest["scopes"], guest["own"]) == (["omni:move"], True)
    of_the_file = await ada.delete("/v1/roles/viewer")
    assert problem(of_the_file)[:2] == (403, "not-permitted")
    assert (await ada.delete("/v1/roles/guest")).status_code == 200
    given = await ada.post(
        f"/v1/people/{place.principal('Vi')}/rights", json={"rights": "operator on omni for 1 h"}
    )
    assert given.status_code == 200, given.text
    nobody = await ada.post("/v1/people/nobody/rights", json={"rights": "operator"})
    assert problem(nobody)[:2] == (404, "not-found")


async def test_a_queue_is_joined_seen_and_left(place: ServedGateway) -> None:
    ada, bo = await place.person("Ada"), await place.person("Bo")
    order = {"skill": "move", "arguments": {"distance": 0.1}, "wait_s": 20}
    await ada.post("/v1/robots/omni/orders", json=order)
    waits = await bo.post("/v1/robots/omni/queue")
    assert waits.status_code == 200, waits.text
    [one] = (await ada.get("/v1/queue")).json()
    assert (one["robot"], one["who"], one["own"], one["place"]) == ("omni", "Bo", False, 1)
    assert (await bo.get("/v1/queue?robot=kuka1")).json() == []
    assert problem(await bo.get("/v1/queue?robot=nobody"))[:2] == (404, "not-found")
    assert (await bo.delete("/v1/robots/omni/queue")).status_code == 200
    assert (await ada.get("/v1/queue")).json() == []
    not_theirs = await bo.post("/v1/robots/omni/take-over")
    assert problem(not_theirs)[:2] == (403, "not-permitted")
    back = await ada.post("/v1/robots/omni/release")
    assert back.status_code == 200, back.text
    assert place.gateway.rooms.organiser.holder("omni") is None


async def test_a_task_is_given_seen_held_and_ended(place: ServedGateway) -> None:
    ada, bo, vi = [await place.person(name) for name in ("Ada", "Bo", "Vi")]
    given = await bo.post(
        "/v1/tasks", json={"on": "omni", "steps": ["move 2 m left speed 0.2 m/s"]}
    )
    assert given.status_code == 201, given.text
    [task] = (await bo.get("/v1/tasks")).json()
    assert (task["who"], task["own"], task["robots"]) == ("Bo", True, ["omni"])
    assert "left" in task["what"]
    [seen] = (await vi.get("/v1/tasks")).json()
    assert "left" not in seen["what"]
    path = f"/v1/tasks/{task['id']}"
    assert problem(await vi.post(f"{path}/cancel"))[:2] == (403, "not-permitted")
    assert problem(await bo.post("/v1/tasks/4711/cancel"))[:2] == (404, "not-found")
    assert problem(await bo.post(f"{path}/explode"))[0] in {400, 404}
    ended = await ada.post(f"{path}/cancel")
    assert ended.status_code == 200, ended.text

    async def over() -> bool:
        return not (await bo.get("/v1/tasks")).json()

    for _ in range(2_000):
        if await over():
            break
    assert await over()


async def test_a_new_task_does_nothing_with_one_that_there_is(place: ServedGateway) -> None:
    ada = await place.person("Ada")
    given = await ada.post("/v1/tasks", json={"on": "any", "steps": ["move 0.5 m left"]})
    assert given.status_code == 201, given.text
    [task] = (await ada.get("/v1/tasks")).json()
    for on, steps in (("cancel", [task["id"]]), ("pause", [f" {task['id']} "])):
        answer = await ada.post("/v1/tasks", json={"on": on, "steps": steps})
        assert problem(answer)[:2] == (422, "not-understood")
    assert [each["id"] for each in (await ada.get("/v1/tasks")).json()] == [task["id"]]


async def test_a_mission_is_started_by_its_name() -> None:
    patrol = Mission(name="patrol", do=(MissionPart(on="omni", steps=("move 2 m left",)),))
    async with served(missions=(patrol,)) as place:
        bo, vi = await place.person("Bo"), await place.person("Vi")
        found = (await bo.get("/v1/missions")).json()
        assert found == {
            "missions": [{"name": "patrol", "title": "", "parameters": []}],
            "runs": [],
        }
        unknown = await bo.post("/v1/missions/nothing/start", json={})
        assert problem(unknown)[:2] == (404, "not-found")
        started = await bo.post("/v1/missions/patrol/start", json={})
        assert started.status_code == 200, started.text
        [run] = (await bo.get("/v1/missions")).json()["runs"]
        assert (run["tasks"], run["done"]) == (1, 0)
        path = f"/v1/missions/runs/{run['id']}"
        assert problem(await vi.post(f"{path}/cancel"))[:2] == (403, "not-permitted")
        assert (await bo.post(f"{path}/cancel")).status_code == 200
        assert problem(await bo.post("/v1/missions/runs/none/cancel"))[:2] == (404, "not-found")


FOR_PEOPLE = frozenset({"a role", "a right for good", "every right"})
"""Nobody can make a key that gives or takes rights."""
ASKED_FIRST = {
    "a role": ("PUT", "/v1/roles/guest", {"gives": "omni:move"}),
    "a right for good": ("POST", "/v1/people/{Bo}/rights", {"rights": "admin"}),
    "every right": ("POST", "/v1/chat", {"text": "/revoke Bo"}),
    "oneself": ("POST", "/v1/chat", {"text": "/forget me"}),
    "a later order": ("POST", "/v1/chat", {"text": "/in 20 min omni move 0.2 m left"}),
    "again": ("POST", "/v1/chat", {"text": "again"}),
}


async def refused(
    caller: httpx.AsyncClient, method: str, url: str, body: dict[str, str]
) -> tuple[str, str]:
    """Return code and sentence of what is refused: of whatever is said in a chat, in its answer."""
    answer = await caller.request(method, url, json=body)
    if answer.status_code == 200:
        assert answer.json()["state"] == "not-done"
        return answer.json()["code"], answer.json()["text"]
    _, code, sentence = problem(answer)
    return code, sentence


async def test_what_is_asked_first_says_so_and_is_done_by_a_persons_tap_alone(
    place: ServedGateway,
) -> None:
    ada, hal = await place.person("Ada"), await place.program("senior")
    bo, id_of_bo = await place.person("Bo"), place.principal("Bo")
    order = {"skill": "move", "arguments": {"distance": 0.1, "direction": "left"}, "wait_s": 30}
    for caller in (ada, hal):
        placed = (await caller.post("/v1/robots/omni/orders", json=order)).json()
        assert placed.get("state") == "done", placed
        await caller.post("/v1/robots/omni/release")
    for what, (method, path, body) in ASKED_FIRST.items():
        url, asks = path.format(Bo=id_of_bo), bo if what == "oneself" else ada
        asked = await asks.request(method, url, json=body)
        assert (asked.status_code, asked.json()["state"]) == (200, "asked"), (what, asked.text)
        shown = (await asks.get("/v1/chat")).json()[-1]
        assert (shown["state"], shown["text"]) == ("asked", asked.json()["text"]), what
        assert len([button for row in shown["buttons"] for button in row]) >= 2, what
        code, sentence = await refused(hal, method, url, body)
        if what in FOR_PEOPLE:
            assert code in {"not-permitted", "not-found"}, (what, sentence)
        else:
            assert code == "first-needed", what
            assert sentence.startswith("Only a person can confirm that"), what
        leave = shown["buttons"][-1][-1]["nonce"]
        left = await asks.post("/v1/chat", json={"message": shown["id"], "button": leave})
        assert left.json()["state"] == "final", (what, left.text)
        after = next(m for m in (await asks.get("/v1/chat")).json() if m["id"] == shown["id"])
        assert (after["state"], after["buttons"]) == ("final", []), what
    assert "guest" not in {one["name"] for one in (await ada.get("/v1/roles")).json()}
    assert place.gateway.rooms.authoriser.directory.has_good_key(id_of_bo)


async def test_signing_in_is_named_by_help_where_there_is_a_page() -> None:
    async with served() as place:
        bo = await place.person("Bo")
        shared = (await bo.post("/v1/chat", json={"text": "help share"})).json()["text"]
        assert "/signin · Sign in on the page" in shared
