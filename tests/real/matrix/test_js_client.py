"""Two people at matrix-js-sdk in its strict mode, on a real homeserver."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.real.matrix.database import found_in
from tests.real.matrix.js_client import JsClient, JsError
from tests.real.matrix.person import Person

if TYPE_CHECKING:
    from pathlib import Path

    from tests.real.matrix.synapse import Synapse


async def test_two_people_talk_in_strict_mode(synapse: Synapse, tmp_path: Path) -> None:
    async with (
        JsClient(synapse.create_account("Ada"), tmp_path / "ada.log") as ada,
        JsClient(synapse.create_account("Bo"), tmp_path / "bo.log") as bo,
    ):
        room = await ada.create_room(bo.user, direct=True)
        await bo.join(room)
        said = await ada.say(room, "drive 1 2")
        heard = await bo.hears(room, "drive 1 2")
        assert (heard.encrypted, heard.unreadable, heard.shield) == (True, "", "NONE")
        await ada.edit(room, said, "drive 3 4")
        await bo.react(room, said, "👍")
        await bo.say(room, "very well", reply_to=said)
        report = await bo.send_file(room, "report.txt", b"all is well " * 1000)

        answered = await ada.hears(room, "very well")
        assert answered.reply_to == said
        await ada.hears(room, "report.txt")
        assert await ada.file(room, report) == b"all is well " * 1000
        edited = await bo.hears(room, "drive 3 4")
        assert (edited.id, edited.edits, edited.reactions) == (said, 1, {"👍": {bo.user}})

    for text in ("drive 1 2", "drive 3 4", "very well", "report.txt", "all is well"):
        assert found_in(synapse, text) == []


async def test_they_verify_each_other_by_emoji(synapse: Synapse, tmp_path: Path) -> None:
    async with (
        JsClient(synapse.create_account("Ada"), tmp_path / "ada.log") as ada,
        JsClient(synapse.create_account("Bo"), tmp_path / "bo.log") as bo,
    ):
        room = await ada.create_room(bo.user, direct=True)
        await bo.join(room)
        assert await ada.trust(bo.user, bo.device) == {
            "user_verified": False,
            "needs_approval": False,
            "signed_by_owner": True,
            "device_verified": False,
        }
        transaction = await ada.request_verification(bo.user, room=room)
        await bo.accept_verification((await bo.verification(ada.user, "requested"))["transaction"])
        await ada.verification(bo.user, "ready")
        await ada.compare_emoji(transaction)
        shown = await ada.verification(bo.user, "emoji")
        assert (await bo.verification(ada.user, "emoji"))["emoji"] == shown["emoji"]
        await ada.confirm(transaction)
        await bo.confirm(transaction)
        for one, other in ((ada, bo), (bo, ada)):
            await one.verification(other.user, "done")
            await one.verified(other.user)
            assert (await one.trust(other.user, other.device))["device_verified"]


@pytest.mark.parametrize("strict", [True, False])
async def test_strict_mode_shares_no_key_with_a_device_that_nobody_signed(
    synapse: Synapse, tmp_path: Path, *, strict: bool
) -> None:
    async with (
        JsClient(synapse.create_account("Ada"), tmp_path / "ada.log", strict=strict) as ada,
        Person(synapse.create_account("Bo"), tmp_path / "bo") as bo,
    ):
        room = await ada.create_room(bo.user)
        await bo.join(room)
        said = await ada.say(room, "for signed devices")
        await bo.say(room, "from one that nobody signed")

        if strict:
            await bo.until(lambda: said in bo.timeline(room).unreadable)
            await ada.until(room, lambda seen: any(one.unreadable for one in seen))
            assert [one.unreadable for one in await ada.sees(room, bo.user)] == [
                "UNSIGNED_SENDER_DEVICE"
            ]
        else:
            await bo.hears(room, "for signed devices")
            heard = await ada.hears(room, "from one that nobody signed")
            assert heard.shield == "RED"


async def test_what_it_cannot_do_it_says(synapse: Synapse, tmp_path: Path) -> None:
    async with JsClient(synapse.create_account("Ada"), tmp_path / "ada.log") as ada:
        with pytest.raises(JsError, match="there is no room"):
            await ada.sees("!nowhere:rosic.test")
        with pytest.raises(JsError, match="nothing is called"):
            await ada.ask("fly")
