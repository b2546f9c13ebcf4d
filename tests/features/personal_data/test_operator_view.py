"""What the operator sees of containers, limits and erases."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest

from rosic.errors import Refusal, RobotBusy
from rosic.features.personal_data import operator_view
from rosic.features.personal_data.commands import tidy
from tests.features.personal_data.data_gateway import Ward, a_ward, used
from tests.gateway.place import ADA, BO, VI

if TYPE_CHECKING:
    from pathlib import Path


OPERATOR = "operator"


async def test_the_operator_lists_shows_exports_and_limits(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        bo = await used(ward)
        data_context = ward.data_context
        listed = await operator_view.list_containers(data_context)
        assert listed[0] == operator_view.ListedContainer("robot", "cf1", "cf1")
        assert operator_view.ListedContainer("person", bo, "Bo") in listed
        (chat,) = [one.container for one in listed if one.kind == "chat"]
        assert listed[-1].name == "memory group g"
        lines = operator_view.table(listed).splitlines()
        assert lines[0] == "robot   cf1"
        assert (
            len({line.index(one.container) for line, one in zip(lines, listed, strict=True)}) == 1
        )
        shown = operator_view.shown(
            await operator_view.show_container(data_context, bo)
        ).splitlines()
        assert shown[0] == f"person Bo ({bo})"
        assert shown[-1] == "  shared data: 1 of 64 names, 12 bytes of 64 KiB"
        assert "bay four" in await content(ward, bo)
        assert '"text":"hello' in await content(ward, chat)
        told = operator_view.shown(await operator_view.show_container(data_context, chat))
        assert re.search(r"\n  archived +\d+  ", told)
        limited = await operator_view.limit_container(
            data_context, bo, OPERATOR, names=1, most_bytes=2048
        )
        assert limited == "Bo may keep 1 name and 2.0 KiB from now on."
        assert "at most 1 name." in await ward.said("data", "two = 2", account=BO)
        assert await ward.said("data", "two = 2", account=VI) == "Data stored."
        limited = await operator_view.limit_container(data_context, bo, OPERATOR, names=2)
        assert limited == "Bo may keep 2 names and 2.0 KiB from now on."


async def test_the_operator_is_told_what_cannot_be(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        bo = await used(ward)
        data_context, (key,) = ward.data_context, ward.archive.all()
        for name in ("nobody", "chat-nothing"):
            with pytest.raises(Refusal, match="There is no such container"):
                await operator_view.show_container(data_context, name)
        with pytest.raises(Refusal, match="There is no such container"):
            await operator_view.export_container(data_context, "chat-nothing")
        with pytest.raises(Refusal, match="A chat keeps messages alone"):
            await operator_view.limit_container(data_context, f"chat-{key}", OPERATOR, names=1)
        with pytest.raises(Refusal, match="cannot be less than nothing"):
            await operator_view.limit_container(data_context, bo, OPERATOR, names=-1)


async def content(ward: Ward, container: str) -> str:
    return "\n".join(await operator_view.export_container(ward.data_context, container))


async def test_the_operator_erases_a_robot_s_a_chat_s_and_a_person_s(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        bo = await used(ward)
        data_context, (key,) = ward.data_context, ward.archive.all()
        chat = f"chat-{key}"
        await ward.clock.advance(120)
        done = await operator_view.erase_container(data_context, ward.erasing, "omni", OPERATOR)
        assert done.startswith("What omni kept is erased.")
        assert ward.shelf.names(bo, "omni") == ()
        await operator_view.erase_container(data_context, ward.erasing, chat, OPERATOR)
        assert not ward.archive.all()
        done = await operator_view.erase_container(data_context, ward.erasing, bo, OPERATOR)
        assert done == (
            "Bo is erased. Copies of the record made before stay readable with their key."
        )
        with pytest.raises(Refusal):
            await operator_view.erase_container(
                data_context, ward.erasing, "chat-nothing", OPERATOR
            )


async def test_once_a_day_what_is_too_old_goes(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        await ward.said("archive", "on 1 day")
        ward.chat.say("old", account=ADA, chat=ADA)
        await ward.quiet()
        ward.clock.jump_wall(2 * 86_400)
        assert await tidy(ward.data_context, ward.erasing) >= 1
        assert await ward.said("archive", "export") == "No message of this chat is kept."


async def test_a_container_in_use_is_erased_when_the_work_is_over(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        await used(ward)
        with pytest.raises(RobotBusy, match=r"omni is in use now, by Bo\. Nothing was erased\."):
            await operator_view.erase_container(ward.data_context, ward.erasing, "omni", OPERATOR)
        assert ward.shelf.names(ward.id_of(ADA), "omni")
        await ward.clock.advance(120)
        await operator_view.erase_container(ward.data_context, ward.erasing, "omni", OPERATOR)
        assert not ward.shelf.names(ward.id_of(ADA), "omni")
