"""What an idempotency key stands for: one order, over limits, questions and restarts."""

from __future__ import annotations

import asyncio

import pytest

from rosic.api import order_feed, ordering
from rosic.core.policy.roles import Role, SkillPrecondition
from rosic.core.rate_limit import RateLimit
from rosic.stores.memory import MemoryStore
from tests.api.served import ServedGateway, problem, served
from tests.api.test_orders import move
from tests.gateway.test_rights import rules
from tests.pace import pace


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


async def test_a_key_of_one_caller_is_nothing_to_another() -> None:
    async with served() as place:
        hal, sal = await place.program("operator"), await place.program("operator", name="Sal")
        key = {"Idempotency-Key": "a"}
        first = await hal.post("/v1/robots/omni/orders", json=move(wait_s=30), headers=key)
        await hal.post("/v1/chat", json={"text": "/end omni"})
        second = await sal.post("/v1/robots/kuka1/orders", json={"skill": "home"}, headers=key)
        assert second.status_code == 202, second.text
        assert first.json()["id"] != second.json()["id"]


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
    monkeypatch.setattr(ordering, "recorded_answer", unknown)
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
    monkeypatch.setattr(ordering, "recorded_answer", unknown)
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


async def test_what_met_a_limit_is_tried_again_under_the_same_key_when_its_time_has_come() -> None:
    path, key = "/v1/robots/omni/orders", {"Idempotency-Key": "wednesday-1"}
    store = MemoryStore()
    async with served(limit=RateLimit(burst=1.0, per_s=0.5), store=store) as place:
        secret = await place.key("operator")
        hal = place.client({"Authorization": f"Bearer {secret}"})
        first = await hal.post(path, json=move())
        assert first.status_code == 202
        refused = await hal.post(path, json=move(), headers=key)
        assert problem(refused)[:2] == (429, "too-many-requests")
        wait_s = float(refused.headers["retry-after"])
        assert wait_s == 2
        other = await hal.post(path, json=move(arguments={"distance": 0.2}), headers=key)
        assert problem(other)[:2] == (409, "repeated")
        async with asyncio.timeout(60 * pace()):
            while refused.status_code == 429:
                await asyncio.sleep(float(refused.headers["retry-after"]))
                refused = await hal.post(path, json=move(), headers=key)
        again = await asyncio.gather(*(hal.post(path, json=move(), headers=key) for _ in range(3)))
        assert {answer.json()["id"] for answer in again} == {refused.json()["id"]}
        assert len((await hal.get("/v1/orders")).json()) == 2
    async with served(store=store) as place:  # it is found behind what met the limit
        hal = place.client({"Authorization": f"Bearer {secret}"})
        once_more = await hal.post(path, json=move(), headers=key)
        assert (once_more.status_code, once_more.json()["id"]) == (202, refused.json()["id"])
        assert (await hal.get("/v1/orders")).json() == []


async def test_an_order_that_was_refused_is_refused_in_the_next_run_too() -> None:
    path, key = "/v1/robots/omni/orders", {"Idempotency-Key": "thursday-1"}
    store = MemoryStore()
    far = move(arguments={"distance": 500.0, "direction": "left"})
    async with served(store=store) as place:
        secret = await place.key("operator")
        hal = place.client({"Authorization": f"Bearer {secret}"})
        refused = problem(await hal.post(path, json=far, headers=key))
        assert refused[:2] == (422, "out-of-bounds")
    async with served(store=store) as place:
        hal = place.client({"Authorization": f"Bearer {secret}"})
        assert problem(await hal.post(path, json=far, headers=key)) == refused


@pytest.mark.parametrize("forgotten", ["by a restart", "for newer orders"])
async def test_an_order_that_met_a_limit_again_and_again_is_done_once(
    forgotten: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where what became of it is known by the record alone."""
    path, key, store = "/v1/robots/omni/orders", {"Idempotency-Key": "friday-1"}, MemoryStore()
    if forgotten == "for newer orders":
        monkeypatch.setattr(ordering, "PLACED_KEPT", 1)
    async with served(limit=RateLimit(burst=1.0, per_s=0.5), store=store) as place:
        secret = await place.key("operator")
        hal = place.client({"Authorization": f"Bearer {secret}"})
        await hal.post(path, json=move())
        answers = [await hal.post(path, json=move(), headers=key) for _ in range(2)]
        assert [answer.status_code for answer in answers] == [429, 429]
        answer = answers[-1]
        async with asyncio.timeout(60 * pace()):
            while answer.status_code == 429:
                await asyncio.sleep(float(answer.headers["retry-after"]))
                answer = await hal.post(path, json=move(wait_s=30), headers=key)
        assert answer.json()["state"] == "done"
        if forgotten == "for newer orders":
            for name in "ab":
                await hal.post(path, json=move(), headers={"Idempotency-Key": name})
            again = await hal.post(path, json=move(wait_s=30), headers=key)
            assert again.json()["id"] == answer.json()["id"]
    async with served(store=store) as place:
        hal = place.client({"Authorization": f"Bearer {secret}"})
        again = await hal.post(path, json=move(wait_s=30), headers=key)
        assert again.json()["id"] == answer.json()["id"]
        assert (await hal.get("/v1/orders")).json() == []


async def test_a_key_stands_for_its_values_in_the_next_run_too() -> None:
    path, key, store = "/v1/robots/omni/orders", {"Idempotency-Key": "friday-2"}, MemoryStore()
    async with served(store=store) as place:
        secret = await place.key("operator")
        hal = place.client({"Authorization": f"Bearer {secret}"})
        first = (await hal.post(path, json=move(wait_s=30), headers=key)).json()
    async with served(store=store) as place:
        hal = place.client({"Authorization": f"Bearer {secret}"})
        other = move(arguments={"distance": 0.3, "direction": "right"})
        assert problem(await hal.post(path, json=other, headers=key))[:2] == (409, "repeated")
        assert (await hal.post(path, json=move(), headers=key)).json()["id"] == first["id"]


async def test_an_order_that_goes_on_behind_many_newer_ones_is_told_when_it_is_over(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(order_feed, "KEPT", 1)
    async with served(limit=RateLimit(burst=1e3, per_s=1e3)) as place:
        hal, sal = await place.program("operator"), await place.program("operator", name="Sal")
        far = move(arguments={"distance": 1.0, "direction": "left"})
        long = (await hal.post("/v1/robots/omni/orders", json=far)).json()
        for _ in range(3):
            home = {"skill": "home", "wait_s": 30}
            await sal.post("/v1/robots/kuka1/orders", json=home)
        over = (await hal.get(f"/v1/orders/{long['id']}?wait_s=60")).json()
        assert (over["state"], over["over"]) == ("done", True)
