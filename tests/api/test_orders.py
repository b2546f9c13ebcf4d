"""Orders over REST: like any other, given once, refused in the words of the chat."""

from __future__ import annotations

import asyncio
import json
from math import radians
from time import monotonic_ns
from typing import Any

import pytest

from rosic.api import order_feed, ordering
from rosic.client import RosicClient
from rosic.core.policy.roles import Role, SkillPrecondition
from rosic.core.time_units import SECOND_NS
from rosic.messengers.program import standstill
from rosic.messengers.program.standstill import AFTER_NS, STILL_NS, StandstillWatch
from rosic.stores.memory import MemoryStore
from tests.api.served import ServedGateway, problem, served
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


async def test_the_same_key_is_the_same_order() -> None:
    async with served() as place:
        hal = await place.program("operator")
        key = {"Idempotency-Key": "tuesday-1"}
        answers = await asyncio.gather(
            *(hal.post("/v1/robots/omni/orders", json=move(), headers=key) for _ in range(5))
        )
        ids = {answer.json()["id"] for answer in answers}
        assert len(ids) == 1
        done = await hal.post("/v1/robots/omni/orders", json=move(wait_s=30), headers=key)
        assert done.json()["state"] == "done"
        assert done.json()["id"] in ids
        assert len((await hal.get("/v1/orders")).json()) == 1
        other = {"skill": "move", "arguments": {"distance": 0.2}}
        refused = await hal.post("/v1/robots/omni/orders", json=other, headers=key)
        assert problem(refused) == (
            409,
            "repeated",
            "That Idempotency-Key stands for another order. Nothing was done.",
        )


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


async def test_a_key_of_one_caller_is_nothing_to_another() -> None:
    async with served() as place:
        hal, sal = await place.program("operator"), await place.program("operator", name="Sal")
        key = {"Idempotency-Key": "a"}
        first = await hal.post("/v1/robots/omni/orders", json=move(wait_s=30), headers=key)
        await hal.post("/v1/chat", json={"text": "/end omni"})
        second = await sal.post("/v1/robots/kuka1/orders", json={"skill": "home"}, headers=key)
        assert second.status_code == 202, second.text
        assert first.json()["id"] != second.json()["id"]


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


async def agree(place: ServedGateway) -> None:
    """Let the person who is asked last agree."""
    await place.until(lambda: place.chat.told)
    question = place.chat.told[-1]
    button = question.outbound.buttons[0][0]
    place.chat.tap(button, under=question.message, account=question.outbound.chat.id)


@pytest.mark.parametrize("asks", [True, False])
async def test_a_key_is_the_same_order_over_a_restart_and_is_answered_with_it(asks: bool) -> None:
    care = (SkillPrecondition(scopes=("omni:*",), confirm=True),) if asks else ()
    store, path, key = MemoryStore(), "/v1/robots/omni/orders", {"Idempotency-Key": "g1"}
    book = rules(*care, elsewhere=Role(scopes=("kuka1:read",)))
    async with served(rules=book, store=store) as place:
        secret = await place.key("operator")
        hal = place.client({"Authorization": f"Bearer {secret}"})
        first = (await hal.post(path, json=move(), headers=key)).json()
        if asks:
            await agree(place)
            await place.until(lambda: list(place.server.context.feed.newest()))
        before = (await hal.get(f"/v1/orders/{first['id']}?wait_s=30")).json()
        assert (before["state"], before["n"]) == ("done", 1)
    async with served(rules=book, store=store) as place:
        hal = place.client({"Authorization": f"Bearer {secret}"})
        again = (await hal.post(path, json=move(), headers=key)).json()
        assert (await hal.get(f"/v1/orders/{first['id']}")).json() == again
        told = ("id", "robot", "skill", "state", "over", "who", "n")
        assert [again[name] for name in told] == [before[name] for name in told]
        assert again["ended"]
        assert again["sent"].endswith("move, 0.10 m left")
        other = {"skill": "turn", "arguments": {"angle": 5}}
        refused = await hal.post(path, json=other, headers=key)
        assert problem(refused)[:2] == (409, "repeated")
        assert not place.chat.told
        assert not list(place.server.context.feed.newest())
        eve = await place.program("elsewhere", name="Eve")
        assert problem(await eve.get(f"/v1/orders/{first['id']}"))[:2] == (404, "not-found")


async def test_what_is_agreed_to_anew_for_the_same_key_is_not_done_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Also where the record cannot be asked before."""

    async def unknown(*_about: object) -> None:
        return None

    care = rules(SkillPrecondition(scopes=("omni:*",), confirm=True))
    store, path, key = MemoryStore(), "/v1/robots/omni/orders", {"Idempotency-Key": "g1"}
    monkeypatch.setattr(ordering, "recorded_order", unknown)
    async with served(rules=care, store=store) as place:
        secret = await place.key("operator")
        hal = place.client({"Authorization": f"Bearer {secret}"})
        asked = (await hal.post(path, json=move(), headers=key)).json()
        await agree(place)
        await place.until(lambda: list(place.server.context.feed.newest()))
        await hal.get(f"/v1/orders/{asked['id']}?wait_s=30")
    async with served(rules=care, store=store) as place:
        hal = place.client({"Authorization": f"Bearer {secret}"})
        assert (await hal.post(path, json=move(), headers=key)).json()["state"] == "asked"
        await agree(place)
        speech = place.server._speech
        (placed,) = speech._placed.values()
        await place.until(lambda: placed.refused)
        assert placed.refused is not None
        assert placed.refused.detail == "This was already settled."
        assert not list(place.server.context.feed.newest())


async def test_what_a_person_on_the_page_agrees_to_anew_for_the_same_key_is_not_done_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Also where the record cannot be asked before."""

    async def unknown(*_about: object) -> None:
        return None

    care = rules(SkillPrecondition(scopes=("omni:*",), confirm=True))
    store, path, key = MemoryStore(), "/v1/robots/omni/orders", {"Idempotency-Key": "g1"}
    monkeypatch.setattr(ordering, "recorded_order", unknown)
    for run, (state, ended) in enumerate((("done", 1), ("refused", 0))):
        async with served(rules=care, store=store) as place:
            ada = await place.person("Ada")
            asked = (await ada.post(path, json=move(), headers=key)).json()
            assert asked["state"] == "asked", run
            shown = (await ada.get("/v1/chat")).json()[-1]
            tapped = {"message": shown["id"], "button": shown["buttons"][0][0]["nonce"]}
            await ada.post("/v1/chat", json=tapped | {"wait_s": 0})
            over = (await ada.get(f"/v1/orders/{asked['id']}?wait_s=30")).json()
            assert over["state"] == state
            assert len(list(place.server.context.feed.newest())) == ended


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


async def test_an_order_that_many_newer_ones_follow_is_still_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(order_feed, "KEPT", 2)
    async with served() as place:
        hal = await place.program("operator")
        body = {"skill": "move", "arguments": {"distance": 0.01}, "wait_s": 20}
        path, one = "/v1/robots/omni/orders", {"Idempotency-Key": "one"}
        first = await hal.post(path, json=body, headers=one)
        for _ in range(3):
            await hal.post(path, json=body)
        again = await hal.post(path, json=body, headers=one)
        assert (again.json()["id"], again.json()["state"]) == (first.json()["id"], "done")


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
