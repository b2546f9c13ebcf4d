from __future__ import annotations

import asyncio
import json
import shutil
from typing import TYPE_CHECKING

import pytest

from rosic.core.message import ChatKind
from rosic.core.policy.roles import Grant
from rosic.errors import RecordUnavailable, Refusal, StoreFault
from rosic.features.personal_data import operator_view
from rosic.features.personal_data.commands import SURE
from rosic.stores.database import DatabaseStore
from rosic.testing.clock import ManualClock
from tests.features.personal_data.data_gateway import a_ward, used
from tests.gateway.place import ADA, BO, VI

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from rosic.core.records import Fact

OPERATOR = "operator"


async def test_my_data_says_what_there_is_and_only_of_me(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        bo = await used(ward)
        reply = await ward.ask("mydata", account=BO)
        lines = reply.text.splitlines()
        assert lines[0] == "What is kept about you:"
        assert "  your name and your addresses: 1 (" in reply.text
        assert "  your messages in chats that are kept: 1 (" in reply.text
        assert "  data you keep: 1 (" in reply.text
        assert "  your settings: 1 (" in reply.text
        assert lines[-2] == "It is sealed with a key of your own. /forget me erases that key."
        assert [b.command for row in reply.buttons for b in row] == ["/mydata export", "/forget me"]
        text = await ward.file("mydata", "export", account=BO)
        things = [json.loads(line) for line in text.splitlines()]
        assert {"card", "command", "shelf", "archived", "preference"} <= {t["kind"] for t in things}
        assert "hello from the left" in text
        assert "hello from the right" not in text
        lines = (await ward.file("mydata", "export text", account=BO)).splitlines()
        assert all(line.startswith("Kind: ") for line in lines)
        sheet = (await ward.ask("mydata", "export xlsx", account=BO)).attachment
        assert sheet is not None
        assert sheet.name == "my-data.xlsx"
        assert bo not in await ward.file("mydata", "export", account=VI)
        private = "Ask me that in a private chat with me, please."
        assert await ward.said("mydata", account=BO, kind=ChatKind.GROUP) == private
        assert await ward.said("forget", "me", account=BO, kind=ChatKind.GROUP) == private
        assert (await ward.said("mydata", "of Ada", account=BO)).startswith("To have everything")


async def test_it_asks_once_and_says_what_goes_and_what_stays() -> None:
    async with a_ward() as ward:
        reply = await ward.ask("forget", "Me", account=BO)
        assert reply.text.startswith("Shall I forget you? Your access ends at once")
        assert "backups made earlier stay readable" in reply.text.lower()
        commands = [b.command for row in reply.buttons for b in row]
        assert commands == ["/forget me", "leave it"]
        for typed in ("me", "me confirmed"):
            await ward.said("forget", typed, account=BO)
            assert ward.id_of(BO), "no word that is typed forgets anybody"
        assert (await ward.said("forget", "Ada", account=BO)).startswith("You can have only your")
        assert (await ward.said("forget", account=BO)).startswith("To have everything about you")
        assert ward.id_of(BO)


async def test_the_last_admin_stays() -> None:
    async with a_ward() as ward:
        for act in (b"", SURE):
            assert await ward.said("forget", "me", act=act) == (
                "You are the only admin here, so nobody could let anybody in any more. Nothing was "
                "erased. Make somebody else admin first: "
                "/grant NAME admin."
            )
        with pytest.raises(Refusal) as refused:
            await operator_view.erase_container(
                ward.data_context, ward.erasing, ward.id_of(ADA), OPERATOR
            )
        assert str(refused.value) == (
            "Ada is the only admin here. Nothing was erased. Make somebody else admin first: "
            "/grant NAME admin."
        )
        assert ward.id_of(ADA)


async def test_whoever_is_admin_by_a_grant_counts_as_one() -> None:
    async with a_ward() as ward:
        grant = Grant(id="g", role="admin", expires_ns=None)
        async with ward.gateway.access.changes.turn() as turn:
            await turn.write(
                ward.gateway.authority.grants_book.give(ward.id_of(BO), (grant,), OPERATOR)
            )
        assert (await ward.said("forget", "me", act=SURE)).startswith("You are forgotten")
        assert (await ward.said("forget", "me", act=SURE, account=BO)).startswith(
            "You are the only admin here"
        )


async def test_whoever_is_forgotten_is_a_stranger_and_nothing_of_theirs_can_be_read(
    tmp_path: Path,
) -> None:
    clock = ManualClock()
    async with a_ward(tmp_path, clock=clock) as ward:
        bo = await used(ward)
        before = await ward.kept.container_facts(bo)
        assert sum(fact.letter is not None for fact in before) >= 8
        assert await ward.sure("forget", "me", account=BO) == ("You are forgotten here. Farewell.")
        assert ward.id_of(BO) == ""
        assert "I do not know you" in await ward.say("omni wave", account=BO, chat=BO)
        assert ward.acted() == 1
        assert ward.book.of(bo).language == ""
        assert ward.shelf.names(ward.id_of(ADA), "omni") == ()
        assert ward.gateway.rooms.organiser.calendar.of(bo) == ()
        acts = [(d.act, d.by, d.about) for d in await ward.kept.decisions(50)]
        assert ("erase", bo, bo) in acts
        text = await ward.file("archive", "export", kind=ChatKind.GROUP)
        assert "hello from the left" not in text
        assert "hello from the right" in text
        assert "Message: (erased)" in text
        assert await ward.said("forget", "me", account="77") == (
            "There is nobody of that id, or they were erased before."
        )
    async with a_ward(tmp_path, clock=clock) as again:
        assert again.id_of(BO) == ""
        assert all(fact.letter is None for fact in await again.kept.container_facts(bo))
        assert again.erasing.is_erased(bo)
        assert "I do not know you" in await again.say("omni wave", account=BO, chat=BO)
        await again.say("kuka1 wave", account=ADA, chat=ADA, message="another")
        assert again.acted("kuka1") == 1


async def test_an_order_under_way_ends_before_the_key_is_shredded(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        bo = ward.id_of(BO)
        gateway, order = ward.gateway, []
        executor, shred = gateway.pipeline.executor, ward.kept.shred

        async def shredding(container: str) -> None:
            order.append(len(executor))
            await shred(container)

        ward.kept.shred = shredding  # type: ignore[method-assign]
        ward.robot("omni").work_s = 30.0
        await ward.say("omni wave", account=BO, chat=BO)
        under_way = len(executor)
        assert under_way == 1
        erasing = asyncio.create_task(ward.erasing.erase(bo, OPERATOR))
        while not erasing.done():  # the disk takes real time, while 10 s pass on the test's clock
            await ward.clock.advance(0.02)
            await asyncio.sleep(0.005)
        erased = await erasing
        assert erased.at_rest
        assert order == [0]
        assert all(fact.letter is None for fact in await ward.kept.container_facts(bo))


async def test_a_robot_that_does_not_rest_holds_nothing_up_and_it_is_done_again() -> None:
    async with a_ward() as ward:
        bo, busy = ward.id_of(BO), [True]
        ward.erasing._sides = type(ward.erasing._sides)(
            **{
                **{
                    f: getattr(ward.erasing._sides, f)
                    for f in ward.erasing._sides.__struct_fields__
                },
                "busy": lambda _: busy[0],
            }
        )
        asking = asyncio.create_task(ward.sure("forget", "me", account=BO))
        await ward.clock.advance(15)
        assert await asking == (
            "You are forgotten here. A robot of yours has not confirmed that it is at rest: please "
            "look, and use its own stop button if need be."
        )
        assert await ward.erasing.finish() == 0
        busy[0] = False
        assert await ward.erasing.finish() == 1
        assert await ward.erasing.finish() == 0
        assert ward.erasing.is_erased(bo)


async def test_a_record_that_cannot_be_cleared_is_cleared_at_the_next_start(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    clock = ManualClock()
    async with a_ward(tmp_path, clock=clock) as ward:
        bo = await used(ward)

        async def broken(container: str) -> None:
            raise StoreFault(container)

        ward.kept.shred = broken  # type: ignore[method-assign]
        assert (await ward.sure("forget", "me", account=BO)).startswith(
            "Your access has ended, but the record could not be cleared now."
        )
        assert "it is tried again" in caplog.text
        assert "ended" in await ward.say("omni wave", account=BO, chat=BO) or not ward.id_of(BO)
        assert ward.acted() == 1
    async with a_ward(tmp_path, clock=clock) as again:
        assert all(fact.letter is None for fact in await again.kept.container_facts(bo))
        assert again.id_of(BO) == ""


async def test_what_cannot_be_written_erases_nothing() -> None:
    async with a_ward() as ward:

        async def full(*_: object) -> None:
            raise StoreFault("full")

        write = ward.kept.write
        ward.kept.write = full  # type: ignore[method-assign]
        with pytest.raises(RecordUnavailable):
            await ward.erasing.erase(ward.id_of(BO), OPERATOR)
        ward.kept.write = write  # type: ignore[method-assign]
        assert ward.id_of(BO)
        assert not ward.erasing.is_erased(ward.id_of(BO))
        await ward.say("omni wave", account=BO, chat=BO)
        assert ward.acted() == 1

        async def unreadable(container: str) -> tuple[Fact, ...]:
            raise StoreFault(container)

        ward.kept.container_facts = unreadable  # type: ignore[method-assign]
        assert (await ward.said("mydata", account=BO)).startswith("I cannot read what is kept now")


async def test_a_copy_made_before_stays_readable_with_its_key_and_one_made_after_does_not(
    tmp_path: Path,
) -> None:
    """What erasing can and cannot promise, in a test, so that nobody promises more."""
    folder, clock = tmp_path / "data", ManualClock()
    async with a_ward(folder, clock=clock) as ward:
        bo = await used(ward)
    shutil.copytree(folder, tmp_path / "before")
    async with a_ward(folder, clock=clock) as ward:
        await ward.sure("forget", "me", account=BO)
    shutil.copytree(folder, tmp_path / "after")
    async for name, letters in readable(tmp_path, bo, clock):
        assert (letters > 0) is (name == "before")


async def readable(folder: Path, who: str, clock: ManualClock) -> AsyncIterator[tuple[str, int]]:
    for name in ("before", "after"):
        store = DatabaseStore(folder / name, clock=clock)
        await store.open()
        found = await store.container_facts(who)
        await store.close()
        yield name, sum(fact.letter is not None for fact in found)


async def test_all_of_it_comes_as_a_file_in_a_message_of_its_own() -> None:
    async with a_ward() as ward:
        ward.chat.say("/mydata", account=BO, chat=BO)
        await ward.quiet()
        asked = ward.chat.told[-1]
        button = next(
            b for row in asked.outbound.buttons for b in row if b.label.startswith("Show")
        )
        ward.chat.tap(button, under=asked.message, account=BO)
        await ward.quiet()
        told = ward.chat.told[-1]
        assert told.message != asked.message
        assert not told.edited
        assert told.outbound.attachment is not None
        assert told.outbound.attachment.name == "my-data.jsonl"
        assert "It is not sealed: whoever has it can read it." in told.outbound.text
        assert "Bo" not in repr(told.outbound.attachment)


async def test_somebody_else_s_order_holds_nobody_s_erasing_up() -> None:
    async with a_ward() as ward:
        ward.robot("omni").work_s = 30.0
        await ward.say("omni wave", account=ADA, chat=ADA)
        executor = ward.gateway.pipeline.executor
        assert executor.busy(ward.id_of(ADA))
        assert not executor.busy(ward.id_of(BO))
        assert await ward.sure("forget", "me", account=BO) == ("You are forgotten here. Farewell.")
        assert len(executor) == 1
        await ward.say("stop", account=ADA, chat=ADA)
        await ward.quiet()
        assert not executor.busy(ward.id_of(ADA))
