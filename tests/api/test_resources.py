"""What there is beside orders: telemetry, times, people, alarms, files, the past."""

from __future__ import annotations

import asyncio
import csv
import re
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Any

import pytest

from rosic.api.page_messenger import FILES_KEPT
from rosic.core.message import Attachment
from rosic.robots.memory import MemoryRobot
from tests.api.served import ServedGateway, problem, served
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    import httpx

TOMORROW = (datetime.now(UTC) + timedelta(days=1)).replace(second=0, microsecond=0)


def at(hours: float) -> str:
    return (TOMORROW + timedelta(hours=hours)).isoformat().replace("+00:00", "Z")


async def test_a_value_is_shown_as_it_was_to_whoever_sees_the_robot() -> None:
    async with served() as place:
        hal = await place.program("viewer")
        path, told = "/v1/robots/omni/telemetry", dict[str, Any]()
        async with asyncio.timeout(60 * pace()):
            while not told.get("samples"):
                names = (await hal.get(path)).json()["names"]
                if names:
                    told = (await hal.get(path, params={"value": names[0]})).json()
                await asyncio.sleep(0.1)
        assert told["name"] in told["names"]
        moments = [sample["at"] for sample in told["samples"]]
        assert moments == sorted(moments)
        nothing = (await hal.get("/v1/robots/omni/telemetry?value=nonsense")).json()
        assert nothing["samples"] == []
        unknown = await hal.get("/v1/robots/nobody/telemetry?value=battery")
        assert problem(unknown)[:2] == (404, "not-found")


async def test_a_time_is_booked_seen_and_given_back_like_in_the_chat() -> None:
    async with served() as place:
        ada, bo, vi = [await place.person(name) for name in ("Ada", "Bo", "Vi")]
        booked = await bo.post(
            "/v1/bookings", json={"robot": "kuka1", "start": at(2), "minutes": 60}
        )
        assert booked.status_code == 201, booked.text
        slot = booked.json()
        assert (slot["robot"], slot["who"], slot["own"]) == ("kuka1", "Bo", True)
        assert slot["start"][:16] == at(2)[:16]
        assert slot["end"][:16] == at(3)[:16]
        span = {"from": at(0), "to": at(24)}
        seen = (await vi.get("/v1/bookings", params=span)).json()
        assert [(one["id"], one["who"], one["own"]) for one in seen] == [(slot["id"], "Bo", False)]
        assert (await vi.get("/v1/bookings", params=span | {"robot": "omni"})).json() == []
        taken = await ada.post(
            "/v1/bookings", json={"robot": "kuka1", "start": at(2.5), "minutes": 60}
        )
        status, _, sentence = problem(taken)
        assert status == 409
        assert "is taken by Bo" in sentence
        may_not = await vi.post(
            "/v1/bookings", json={"robot": "kuka1", "start": at(5), "minutes": 60}
        )
        assert problem(may_not)[:2] == (403, "not-permitted")
        not_own = await vi.delete(f"/v1/bookings/{slot['id']}")
        assert problem(not_own)[:2] == (403, "not-permitted")
        back = await bo.delete(f"/v1/bookings/{slot['id']}")
        assert back.status_code == 200, back.text
        assert (await vi.get("/v1/bookings", params=span)).json() == []
        gone = await bo.delete(f"/v1/bookings/{slot['id']}")
        assert problem(gone)[:2] == (404, "not-found")


async def test_a_booking_is_moved_or_stays_where_it_is() -> None:
    async with served() as place:
        ada, bo, vi = [await place.person(name) for name in ("Ada", "Bo", "Vi")]
        hour = {"robot": "kuka1", "minutes": 60}
        slot = (await bo.post("/v1/bookings", json=hour | {"start": at(2)})).json()
        await ada.post("/v1/bookings", json=hour | {"start": at(4)})
        path, span = f"/v1/bookings/{slot['id']}", {"from": at(0), "to": at(24)}

        def own(found: list[dict[str, Any]]) -> list[dict[str, Any]]:
            return [one for one in found if one["who"] == "Bo"]

        clashing = await bo.patch(path, json={"start": at(3.5), "minutes": 60})
        assert problem(clashing)[0] == 409
        assert "is taken by Ada" in problem(clashing)[2]
        assert own((await vi.get("/v1/bookings", params=span)).json()) == [slot | {"own": False}]
        moved = await bo.patch(path, json={"start": at(2.5), "minutes": 90})
        assert moved.status_code == 200, moved.text
        assert moved.json() == slot | {"start": moved.json()["start"], "end": moved.json()["end"]}
        assert moved.json()["start"][:16] == at(2.5)[:16]
        assert moved.json()["end"][:16] == at(4)[:16]
        assert len(own((await vi.get("/v1/bookings", params=span)).json())) == 1
        not_own = await vi.patch(path, json={"start": at(8), "minutes": 60})
        assert problem(not_own)[:2] == (403, "not-permitted")
        by_admin = await ada.patch(path, json={"start": at(8), "minutes": 60})
        assert (by_admin.json()["who"], by_admin.json()["own"]) == ("Bo", False)
        nothing = await bo.patch("/v1/bookings/0123456789", json={"start": at(8), "minutes": 60})
        assert problem(nothing)[:2] == (404, "not-found")


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ({"robot": "nobody", "start": at(2), "minutes": 60}, (404, "not-found")),
        ({"robot": "kuka1", "start": "tomorrow at two", "minutes": 60}, (400, "not-understood")),
        (
            {"robot": "kuka1", "start": "2027-02-01T14:00:00", "minutes": 60},
            (422, "not-understood"),
        ),
        (
            {"robot": "kuka1", "start": "2027-02-01T14:00:30Z", "minutes": 60},
            (422, "not-understood"),
        ),
        (
            {"robot": "kuka1", "start": "2020-02-01T14:00:00Z", "minutes": 60},
            (422, "out-of-bounds"),
        ),
        ({"robot": "kuka1\nstop", "start": at(2), "minutes": 60}, (404, "not-found")),
        ({"robot": "kuka1", "start": at(2), "minutes": 0}, (400, "not-understood")),
    ],
)
async def test_what_is_no_booking_is_refused(
    body: dict[str, object], expected: tuple[int, str]
) -> None:
    async with served() as place:
        bo = await place.person("Bo")
        answer = await bo.post("/v1/bookings", json=body)
        assert problem(answer)[:2] == expected


async def test_people_are_shown_to_whoever_looks_after_them() -> None:
    async with served() as place:
        ada, bo = await place.person("Ada"), await place.person("Bo")
        await place.key("viewer", name="Hal")
        known = {one["name"]: one for one in (await ada.get("/v1/people")).json()}
        assert {name: one["kind"] for name, one in known.items()} == {
            "Ada": "person",
            "Bo": "person",
            "Vi": "person",
            "Hal": "program",
        }
        assert known["Bo"]["roles"] == ["operator"]
        assert not known["Bo"]["locked"]
        assert problem(await bo.get("/v1/people"))[:2] == (403, "not-permitted")


async def test_what_was_asked_is_shown_to_who_asked_and_to_who_may_read_it() -> None:
    async with served() as place:
        ada, bo, vi = [await place.person(name) for name in ("Ada", "Bo", "Vi")]
        order = {"skill": "move", "arguments": {"distance": 0.1}, "wait_s": 30}
        await bo.post("/v1/robots/omni/orders", json=order)
        own = (await bo.get("/v1/history")).json()
        assert [(one["who"], one["robot"], one["skill"], one["outcome"]) for one in own] == [
            ("Bo", "omni", "move", "done")
        ]
        assert (await vi.get("/v1/history?robot=omni")).json() == []
        assert (await vi.get("/v1/history")).json() == []
        assert [one["who"] for one in (await ada.get("/v1/history?robot=omni")).json()] == ["Bo"]
        assert (await ada.get("/v1/history?robot=kuka1")).json() == []


async def test_files_are_their_owners_alone() -> None:
    async with served() as place:
        place.chat.enclose("notes.txt", b"one two three", account="bo", chat="bo")
        ada, bo = await place.person("Ada"), await place.person("Bo")
        await place.until(
            lambda: (
                place.gateway.kernel.containers is not None
                and place.gateway.kernel.containers.files.of(place.principal("Bo"))
            )
        )
        [kept] = (await bo.get("/v1/files")).json()
        assert (kept["name"], kept["size"]) == ("notes.txt", 13)
        content = await bo.get(f"/v1/files/{kept['id']}")
        assert content.content == b"one two three"
        assert content.headers["content-disposition"] == "attachment; filename*=UTF-8''notes.txt"
        assert content.headers["content-type"] == "application/octet-stream"
        assert content.headers["x-content-type-options"] == "nosniff"
        await others_get_nothing(ada, kept["id"])
        assert (await bo.delete(f"/v1/files/{kept['id']}")).status_code == 204
        assert (await bo.get("/v1/files")).json() == []


async def others_get_nothing(other: httpx.AsyncClient, file: str) -> None:
    assert (await other.get("/v1/files")).json() == []
    assert problem(await other.get(f"/v1/files/{file}"))[:2] == (404, "not-found")
    assert problem(await other.delete(f"/v1/files/{file}"))[:2] == (404, "not-found")


async def test_a_file_in_a_conversation_on_the_page_is_saved_by_whoever_it_was_sent_to() -> None:
    async with served() as place:
        ada, bo, hal = (
            await place.person("Ada"),
            await place.person("Bo"),
            await place.program("senior"),
        )
        await ada.post("/v1/chat", json={"text": "picture omni", "wait_s": 30})
        files: list[Any] = []
        async with asyncio.timeout(60 * pace()):
            while not files:
                files = [one["file"] for one in (await ada.get("/v1/chat")).json() if one["file"]]
        [file] = files
        path = f"/v1/chat/{file['id']}/file"
        picture = await ada.get(path)
        assert picture.status_code == 200
        assert picture.headers["content-type"] == file["media_type"] == "image/jpeg"
        assert len(picture.content) == file["size"]
        assert picture.headers["content-disposition"] == (
            f"attachment; filename*=UTF-8''{file['name']}"
        )
        assert picture.headers["x-content-type-options"] == "nosniff"
        assert picture.headers["cache-control"] == "no-store"
        for other in (bo, hal):
            assert problem(await other.get(path))[:2] == (404, "not-found")
        assert problem(await place.http.get(path))[:2] == (401, "unrecognised")
        there = place.server.context.page.conversation(place.principal("Ada"))
        for kind in ("image/svg+xml", "text/html", "image/png; x"):
            there.keep_file(file["id"], Attachment("a b.svg", kind, b"<svg onload='alert(1)'/>"))
            saved = await ada.get(path)
            assert saved.headers["content-type"] == "application/octet-stream"
            assert saved.headers["content-disposition"].endswith("''a%20b.svg")
        for number in range(FILES_KEPT):
            there.keep_file(f"newer {number}", Attachment("a.txt", "text/plain", b"a"))
        assert problem(await ada.get(path))[:2] == (404, "not-found")


async def test_alarms_that_are_open_are_shown_and_nobody_sees_others() -> None:
    async with served() as place:
        bo = await place.person("Bo")
        assert (await bo.get("/v1/alerts")).json() == []
        answer = await bo.post("/v1/robots/omni/alerts/seen")
        assert answer.status_code in {200, 409, 422}
        assert problem(await bo.post("/v1/robots/nobody/alerts/seen"))[:2] == (404, "not-found")


async def test_a_file_is_sent_kept_once_and_refused_as_in_the_chat() -> None:
    async with served() as place:
        ada, hal = await place.person("Ada"), await place.program("operator")
        for caller in (ada, hal):
            content = b"one two three\n" * 20_000
            sent = await caller.post("/v1/files", params={"name": "notes.txt"}, content=content)
            assert sent.status_code == 201, sent.text
            [kept] = (await caller.get("/v1/files")).json()
            assert sent.json() == kept
            assert (kept["name"], kept["size"]) == ("notes.txt", len(content))
            assert (await caller.get(f"/v1/files/{kept['id']}")).content == content

        async def pieces() -> AsyncIterator[bytes]:
            for _ in range(3):
                yield b"some words\n"

        streamed = await ada.post("/v1/files", params={"name": "more.txt"}, content=pieces())
        assert streamed.status_code == 201, streamed.text
        assert streamed.json()["size"] == 33
        empty = await ada.post("/v1/files", params={"name": "empty.txt"})
        assert problem(empty)[0] == 422
        unknown = await ada.post(
            "/v1/files", params={"name": "x.bin"}, content=b"\x00\x01\x02" * 50
        )
        assert problem(unknown)[0] == 422
        lines = await ada.post("/v1/files", params={"name": "a\nstop"}, content=b"x")
        assert problem(lines)[:2] == (422, "not-understood")
        assert len((await ada.get("/v1/files")).json()) == 2


async def test_what_a_robot_shows_is_a_picture_for_whoever_sees_it() -> None:
    async with served() as place:
        hal = await place.program("viewer")
        shown = await hal.get("/v1/robots/omni/views/map")
        assert shown.status_code == 200, shown.text
        assert shown.headers["content-type"].startswith("image/")
        assert shown.headers["rosic-taken"].endswith("Z")
        assert shown.content[:4] in {b"\x89PNG", b"\xff\xd8\xff\xe0"}
        assert problem(await hal.get("/v1/robots/kuka1/views/map"))[:2] == (404, "nothing-to-see")
        assert problem(await hal.get("/v1/robots/nobody/views/map"))[:2] == (404, "not-found")
        assert problem(await hal.get("/v1/robots/omni/views/soul"))[0] in {400, 404}


async def test_the_past_is_searched_in_words_and_kept_as_a_table() -> None:
    async with served() as place:
        bo, vi = await place.person("Bo"), await place.person("Vi")
        order = {"skill": "move", "arguments": {"distance": 0.1}, "wait_s": 30}
        await bo.post("/v1/robots/omni/orders", json=order)
        await bo.post("/v1/chat", json={"text": "=omni fly"})
        [moved] = (await bo.get("/v1/history", params={"text": "MOVE"})).json()
        assert "0.10 m" in moved["asked"]
        assert moved["came"]
        assert (await bo.get("/v1/history", params={"text": "nonsense"})).json() == []
        assert (await vi.get("/v1/history", params={"text": "move"})).json() == []
        table = await bo.get("/v1/history/export")
        assert table.headers["content-type"].startswith("text/csv")
        rows = list(csv.DictReader(table.text.splitlines()))
        assert {row["skill"] for row in rows} >= {"move"}
        assert not any(cell.startswith("=") for row in rows for cell in row.values())


async def test_how_it_does_is_shown_to_whoever_looks_after_people(tmp_path: Path) -> None:
    async with served(data=tmp_path) as place:
        ada, bo = await place.person("Ada"), await place.person("Bo")
        assert problem(await bo.get("/v1/health"))[:2] == (403, "not-permitted")
        found = {one["about"]: one for one in (await ada.get("/v1/health")).json()}
        assert {"data", "record", "disk", "space", "memory", "page", "omni"} <= set(found)
        assert found["data"]["verdict"] == "good"
        assert "fsync" in found["disk"]["text"]
        assert {one["verdict"] for one in found.values()} <= {"good", "look", "not-measured"}


async def test_a_program_is_told_the_roles_that_its_key_was_given() -> None:
    async with served() as place:
        place.chat.say("/key create Sal operator on omni for 30 days", account="ada")
        await place.until(lambda: _secrets(place))
        sal = place.client({"Authorization": f"Bearer {_secrets(place)[0]}"})
        assert (await sal.get("/v1/me")).json()["roles"] == ["operator"]


def _secrets(place: ServedGateway) -> list[str]:
    texts = " ".join(each.outbound.text for each in place.chat.told)
    return re.findall(r"rosic_\w+_[\w-]+", texts)


async def test_a_value_that_was_heard_long_ago_says_so() -> None:
    async with served(robots_of=lambda _kind: MemoryRobot) as place:
        robot = place.gateway.rooms.linker._robots["omni"]
        assert isinstance(robot, MemoryRobot)
        robot.values, robot.age_s = {"battery": 80.0}, 300.0
        hal = await place.program("viewer")
        shown = (await hal.get("/v1/robots/omni")).json()["presence"]
        assert shown["values"] == {"battery": 80.0}
        assert shown["ages_s"] == {"battery": 300.0}
