"""The same ciphertext under another event: by a member, or by whoever runs the homeserver."""

from __future__ import annotations

from typing import TYPE_CHECKING
from urllib.parse import quote
from uuid import uuid4

import httpx

from rosic.testing.messenger_harness import HarnessInbox, listening, until
from tests.real.matrix.test_conformance import MatrixStage, matrix_stage

if TYPE_CHECKING:
    from pathlib import Path

    from tests.real.matrix.person import Person
    from tests.real.matrix.synapse import Synapse

GO = "omni move 1 m"


async def test_a_replayed_message_is_none_over_a_restart_too(
    synapse: Synapse, tmp_path: Path
) -> None:
    async with matrix_stage(synapse, tmp_path, encrypted=True) as stage:
        ada, room = stage.persons["ada"]
        async with listening(stage) as inbox:
            event = await ada.say(room, GO)
            await until(stage, lambda: len(inbox.done) == 1, "it was swallowed")
            await replay(ada, room, event)
            await heard_after(stage, inbox)

        again = MatrixStage(stage.settings, stage.relay, stage.persons)
        async with listening(again) as inbox:
            await replay(ada, room, event)
            await heard_after(again, inbox)
            assert GO not in [one.text for one in inbox.heard]


async def heard_after(stage: MatrixStage, inbox: HarnessInbox) -> None:
    """Wait until what was sent last is heard; what was said before it is heard by then."""
    await stage.write("ada", "status")
    await until(stage, lambda: any(one.text == "status" for one in inbox.done), "it was swallowed")
    assert [one.text for one in inbox.heard].count(GO) <= 1


async def replay(ada: Person, room: str, event: str) -> None:
    """Send the content of an encrypted event once more, as it is."""
    base, room = f"{ada.client.homeserver}/_matrix/client/v3/rooms", quote(room)
    own = {"Authorization": f"Bearer {ada.client.access_token}"}
    async with httpx.AsyncClient(headers=own) as wire:
        sealed = (await wire.get(f"{base}/{room}/event/{quote(event)}")).json()
        assert sealed["type"] == "m.room.encrypted"
        where = f"{base}/{room}/send/m.room.encrypted/{uuid4()}"
        answer = await wire.put(where, json=sealed["content"])
        assert answer.status_code == 200
