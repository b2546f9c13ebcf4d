"""Orders over REST: like any other, given once, refused in the words of the chat."""

from __future__ import annotations

import asyncio
import json
from math import radians
from time import monotonic_ns
from typing import Any

import pytest

from rosic.api import ordering
from rosic.client import RosicClient
from rosic.core.policy.roles import SkillPrecondition
from rosic.core.rate_limit import RateLimit
from rosic.core.time_units import SECOND_NS
from rosic.messengers.program import standstill
from rosic.messengers.program.standstill import AFTER_NS, STILL_NS, StandstillWatch
from tests.api.served import problem, served
from tests.gateway.test_rights import rules
from tests.pace import pace

MOVE = {"skill": "move", "arguments": {"distance": 0.1, "direction": "left"}}


def move(**besides: Any) -> dict[str, Any]:  # noqa: ANN401 - JSON
    return MOVE | besides


async def test_an_order_is_done_and_its_stages_are_the_robots_own() -> None:
    async with served() as place:
        hal = await place.program("operator")
        answer = await hal.post("/v1/robots/omni/orders", json=move(wait_s=30))
        order = answer.json()
        assert answer.status_code == 202
        assert answer.headers["location"] == f"/v1/orders/{order['id']}"
        assert (order["state"], order["who"], order["sent"]) == ("done", "Hal", "move, 0.10 m left")
        assert order["arguments"] == {"direction": "left", "distance": 0.1, "speed": 0.25}
        stages = [stage["stage"] for stage in order["stages"]]
        assert stages == ["accepted", "sent", "received", "running"]
        assert [s["at"] for s in order["stages"]] == sorted(s["at"] for s in order["stages"])
        assert (await hal.get(answer.headers["location"])).json() == order
        assert (await hal.get("/v1/orders?robot=omni")).json() == [order]
        assert (await hal.get("/v1/orders?robot=kuka1")).json() == []


async def test_what_is_not_done_is_said_in_the_language_of_whoever_asks() -> None:
    async with served() as place:
        ada = await place.person("Ada")
        await ada.post("/v1/chat", json={"text": "/language de"})
        key = {"Idempotency-Key": "one"}
        placed = await ada.post("/v1/robots/omni/orders", json=move(), headers=key)
        assert placed.status_code == 202
        other = move(arguments={"distance": 0.2, "direction": "left"})
        repeated = await ada.post("/v1/robots/omni/orders", json=other, headers=key)
        assert problem(repeated)[:2] == (409, "repeated")
        assert "steht für einen anderen Auftrag" in problem(repeated)[2]
        deep = await ada.post("/v1/chat", content='{"text":' + "[" * 100_000)
        assert problem(deep)[:2] == (400, "not-understood")
        assert "verschachtelt" in problem(deep)[2]


@pytest.mark.parametrize(
    ("robot", "body", "expected"),
    [
        (
            "omni",
            {"skill": "move", "arguments": {"distance": 50}},
            (422, "out-of-bounds", "omni: one move may be at most 5 m. Nothing was done."),
        ),
        (
            "omni",
            {"skill": "move", "arguments": {"distance": "far"}},
            (422, "not-understood", 'distance: "far" is no such number.'),
        ),
        (
            "omni",
            {"skill": "move", "arguments": {"distance": 1, "height": 1}},
            (
                422,
                "not-understood",
                'There is no parameter "height" there. There are: direction, distance, speed.',
            ),
        ),
        ("omni", {"skill": "move"}, (422, "not-understood", "distance has to be said, too.")),
        (
            "omni",
            {"skill": "fly"},
            (404, "not-found", "There is no such skill there that you may ask for."),
        ),
        (
            "nobody",
            {"skill": "move"},
            (404, "not-found", "There is no such robot here, as far as you may see."),
        ),
        (
            "omni",
            {"skill": 7},
            (
                400,
                "not-understood",
                "That does not fit here: skill has to be text. Nothing was done.",
            ),
        ),
    ],
)
async def test_what_cannot_be_done_is_refused_in_a_sentence(
    robot: str, body: dict[str, Any], expected: tuple[int, str, str]
) -> None:
    async with served() as place:
        hal = await place.program("operator")
        for path in (f"/v1/robots/{robot}/orders", f"/v1/robots/{robot}/orders/check"):
            assert problem(await hal.post(path, json=body)) == expected
        assert (await hal.get("/v1/orders")).json() == []


async def test_whoever_only_looks_orders_nothing() -> None:
    async with served() as place:
        eve = await place.program("viewer")
        for path in ("/v1/robots/omni/orders", "/v1/robots/omni/orders/check"):
            status, code, _ = problem(await eve.post(path, json=move()))
            assert (status, code) == (403, "not-permitted")


async def test_a_check_says_what_would_be_and_does_nothing() -> None:
    async with served(rules=rules(SkillPrecondition(scopes=("omni:*",), confirm=True))) as place:
        hal = await place.program("operator")
        checked = await hal.post("/v1/robots/omni/orders/check", json=move())
        assert checked.json() == {
            "allowed": False,
            "sent": "move, 0.10 m left",
            "arguments": {"direction": "left", "distance": 0.1, "speed": 0.25},
            "needs": ["confirmation"],
        }
        assert (await hal.get("/v1/orders")).json() == []
        assert place.gateway.rooms.organiser.holder("omni") is None


async def test_arguments_that_are_answered_mean_the_same_when_they_are_sent_again() -> None:
    async with served() as place:
        hal = await place.program("operator")
        turn = {"skill": "turn", "arguments": {"angle": 33.3, "direction": "right"}}
        checked = (await hal.post("/v1/robots/omni/orders/check", json=turn)).json()
        assert checked["arguments"] == turn["arguments"]
        async with place.listening(hal) as connection:
            await connection.send('{"op": "subscribe", "topics": ["orders"]}')
            first = await hal.post("/v1/robots/omni/orders", json=turn | {"wait_s": 30})
            told: dict[str, Any] = {}
            while told.get("event") != "order":
                told = json.loads(await connection.recv())
        again = {"skill": "turn", "arguments": first.json()["arguments"], "wait_s": 30}
        second = await hal.post("/v1/robots/omni/orders", json=again)
        for found in (first.json(), second.json(), told["order"]):
            assert (found["arguments"], found["sent"]) == (turn["arguments"], checked["sent"])
        listed = (await hal.get("/v1/orders")).json()
        assert [one["arguments"] for one in listed] == [turn["arguments"]] * 2
        newest = next(place.server.context.feed.newest())
        assert newest.arguments["angle"] == pytest.approx(radians(33.3))


async def test_what_a_person_must_confirm_is_begun_once_they_have() -> None:
    async with served(rules=rules(SkillPrecondition(scopes=("omni:*",), confirm=True))) as place:
        hal = await place.program("operator")
        asked = (await hal.post("/v1/robots/omni/orders", json=move())).json()
        assert asked["state"] == "asked"
        assert asked["text"].startswith("A person has to confirm that first.")
        await place.until(lambda: place.chat.told)
        question = place.chat.told[-1]
        agree = question.outbound.buttons[0][0]
        place.chat.tap(agree, under=question.message, account=question.outbound.chat.id)
        await place.until(lambda: list(place.server.context.feed.newest()))
        orders = (await hal.get("/v1/orders")).json()
        done = (await hal.get(f"/v1/orders/{asked['id']}?wait_s=30")).json()
        assert [order["id"] for order in orders] == [done["id"]]
        assert done["state"] == "done"


async def test_what_is_asked_about_is_found_under_its_id_and_says_what_came_of_it() -> None:
    async with served(rules=rules(SkillPrecondition(scopes=("omni:*",), confirm=True))) as place:
        hal, mel = await place.program("operator"), await place.program("operator", name="Mel")
        placed = await hal.post("/v1/robots/omni/orders", json=move())
        asked, path = placed.json(), placed.headers["location"]
        assert path == f"/v1/orders/{asked['id']}"
        assert (await hal.get(path)).json() == asked
        assert problem(await mel.get(path))[:2] == (404, "not-found")
        await place.until(lambda: place.chat.told)
        question = place.chat.told[-1]
        no = question.outbound.buttons[0][1]
        waiting = asyncio.create_task(hal.get(f"{path}?wait_s=30"))
        place.chat.tap(no, under=question.message, account=question.outbound.chat.id)
        over = (await waiting).json()
        assert (over["state"], over["over"], over["id"]) == ("refused", True, asked["id"])
        assert "does not agree" in over["text"]
        assert (await hal.get("/v1/orders")).json() == []


async def test_what_a_person_is_asked_on_the_page_keeps_its_id_until_it_is_done_or_left() -> None:
    async with served(rules=rules(SkillPrecondition(scopes=("omni:*",), confirm=True))) as place:
        ada = await place.person("Ada")
        for label, state in (("Leave it", "refused"), ("Do it", "done")):
            placed = await ada.post("/v1/robots/omni/orders", json=move())
            path = placed.headers["location"]
            assert (await ada.get(path)).json()["state"] == "asked"
            shown = (await ada.get("/v1/chat")).json()[-1]
            [nonce] = [b["nonce"] for row in shown["buttons"] for b in row if b["label"] == label]
            await ada.post("/v1/chat", json={"message": shown["id"], "button": nonce, "wait_s": 0})
            over = (await ada.get(f"{path}?wait_s=30")).json()
            assert (over["state"], over["id"]) == (state, placed.json()["id"])
            listed = [each["id"] for each in (await ada.get("/v1/orders")).json()]
            assert listed == ([placed.json()["id"]] if state == "done" else [])


@pytest.mark.parametrize(("answer", "end"), [(0, "done"), (1, "refused")])
async def test_an_order_is_followed_over_what_a_person_is_asked(answer: int, end: str) -> None:
    confirm = rules(SkillPrecondition(scopes=("omni:*",), confirm=True))
    async with (
        served(rules=confirm) as place,
        RosicClient(place.url, await place.key("operator")) as client,
    ):
        order = await client.order("omni", "move", {"distance": 0.1, "direction": "left"})
        following = client.follow(order)
        assert (await anext(following)).state == "asked"
        await place.until(lambda: place.chat.told)
        question = place.chat.told[-1]
        button = question.outbound.buttons[0][answer]
        place.chat.tap(button, under=question.message, account=question.outbound.chat.id)
        found = [found async for found in following]
        assert (found[-1].state, {each.id for each in found}) == (end, {order.id})
        assert (await client.wait(order, 30 * pace())).state == end


async def test_a_question_that_nobody_answers_is_over_in_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(ordering, "AGREED_WITHIN_S", 0.3)
    async with served(rules=rules(SkillPrecondition(scopes=("omni:*",), confirm=True))) as place:
        hal = await place.program("operator")
        path = (await hal.post("/v1/robots/omni/orders", json=move())).headers["location"]
        over = (await hal.get(f"{path}?wait_s=30")).json()
        assert (over["state"], over["code"]) == ("refused", "expired")
        assert over["text"] == "Nobody has agreed in time. Nothing was done."


async def test_of_an_order_whose_author_is_answered_elsewhere_nothing_is_said_to_be_known(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(ordering, "AGREED_WITHIN_S", 0.3)
    second = SkillPrecondition(scopes=("omni:*",), second_person=True)
    async with served(rules=rules(second)) as place:
        bo = await place.person("Bo")
        path = (await bo.post("/v1/robots/omni/orders", json=move())).headers["location"]
        over = (await bo.get(f"{path}?wait_s=30")).json()
        assert (over["state"], over["over"]) == ("unknown", True)
        assert "is not known here" in over["text"]


async def test_a_stop_is_given_whatever_it_names_and_stays() -> None:
    async with served() as place:
        hal = await place.program("operator")
        going = await hal.post(
            "/v1/robots/omni/orders", json={"skill": "move", "arguments": {"distance": 5}}
        )
        stopped = await hal.post("/v1/stop", json={"robots": ["omni", "nobody"]})
        assert stopped.json()["at_rest"] is True
        assert place.gateway.rooms.stops["kuka1"].latched
        order = (await hal.get(f"/v1/orders/{going.json()['id']}?wait_s=10")).json()
        assert order["state"] == "cancelled"
        assert problem(await hal.post("/v1/robots/omni/orders", json=move()))[1] == "robot-stopped"


async def test_an_order_is_cancelled_and_nothing_is_latched() -> None:
    async with served() as place:
        hal = await place.program("operator")
        going = await hal.post(
            "/v1/robots/omni/orders", json={"skill": "move", "arguments": {"distance": 5}}
        )
        order = going.json()["id"]
        await place.until(lambda: place.gateway.rooms.linker.presence("omni").doing)
        answer = await hal.post(f"/v1/orders/{order}/cancel")
        assert answer.status_code == 202
        assert (await hal.get(f"/v1/orders/{order}?wait_s=10")).json()["state"] == "cancelled"
        again = await hal.post("/v1/robots/omni/orders", json=move(wait_s=30))
        assert again.json()["state"] == "done"


async def test_what_others_asked_is_read_by_whoever_may_read_the_history() -> None:
    async with served() as place:
        hal, eve = await place.program("operator"), await place.program("viewer", name="Eve")
        await hal.post("/v1/robots/omni/orders", json=move(wait_s=30))
        [seen] = (await eve.get("/v1/orders")).json()
        assert (seen["who"], seen["state"], seen["sent"], seen["arguments"], seen["note"]) == (
            "Hal",
            "done",
            "",
            {},
            "",
        )


async def test_what_waited_while_the_gateway_stood_still_moves_nothing_and_a_stop_stops(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stood_ns = 0
    monkeypatch.setattr(standstill, "running_ns", lambda: monotonic_ns() + stood_ns)
    async with served() as place:
        hal = await place.program("operator")
        body = {"skill": "move", "arguments": {"distance": 0.3}, "wait_s": 20}
        program = place.server.context.program
        stood_ns = 9 * SECOND_NS
        await place.until(program.waited_ns)
        late = await hal.post("/v1/robots/omni/orders", json=body)
        assert problem(late)[1] == "expired", late.text
        assert (await hal.post("/v1/stop", json={})).json()["at_rest"] is True
        await hal.post("/v1/chat", json={"text": "resume omni"})
        await place.until(lambda: not program.waited_ns())
        await hal.post("/v1/chat", json={"text": "resume omni"})
        fresh = await hal.post("/v1/robots/omni/orders", json=body)
        assert fresh.json()["state"] == "done"


def test_a_loop_that_is_a_little_late_has_not_stood_still() -> None:
    now_ns = 0
    watch = StandstillWatch(lambda: now_ns)
    for passed_ns, waited_ns in ((SECOND_NS // 5, 0), (STILL_NS + 1, STILL_NS + 1)):
        now_ns += passed_ns
        watch.look()
        assert watch.waited_ns() == waited_ns
    for _ in range(10):
        now_ns += AFTER_NS // 10
        watch.look()
    assert watch.waited_ns() == STILL_NS + 1 + AFTER_NS
    now_ns += 1
    assert watch.waited_ns() == 0


@pytest.mark.parametrize("kind", ["program", "person"])
async def test_whoever_waits_is_answered_each_time_that_they_meet_a_limit(kind: str) -> None:
    """In a chat the first time alone: there nobody waits."""
    async with served(limit=RateLimit(burst=1.0, per_s=0.001)) as place:
        who = await (place.program("operator") if kind == "program" else place.person("Bo"))
        assert (await who.post("/v1/robots/omni/orders", json=move())).status_code == 202
        for ask in (
            who.post("/v1/robots/omni/orders", json=move()),
            who.post("/v1/robots/omni/orders", json=move()),
            who.post("/v1/files?name=a.txt", content=b"a"),
            who.post("/v1/files?name=a.txt", content=b"a"),
        ):
            answer = await ask
            assert problem(answer)[:2] == (429, "too-many-requests")
            assert int(answer.headers["retry-after"]) == pytest.approx(1_000, abs=20)
        said = (await who.post("/v1/chat", json={"text": "status"})).json()
        assert (said["state"], said["code"]) == ("not-done", "too-many-requests")
        assert said["retry_after_s"] == pytest.approx(1_000, abs=20)
