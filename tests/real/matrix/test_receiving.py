"""What is received when something was away: us, the homeserver, or what we signed in with."""

from __future__ import annotations

from typing import TYPE_CHECKING

import httpx
import pytest

from rosic.testing.messenger_harness import listening, until, until_fresh
from tests.real.matrix.test_conformance import matrix_stage

if TYPE_CHECKING:
    from pathlib import Path

    from tests.real.matrix.synapse import Synapse

MISSED = 130
"""More than the homeserver gives of one room at once."""


async def test_what_was_missed_is_asked_for_and_is_backlog(
    synapse: Synapse, tmp_path: Path
) -> None:
    async with matrix_stage(synapse, tmp_path, encrypted=True) as stage:
        written = [f"omni move {number} cm" for number in range(1, MISSED + 1)]
        for text in written:
            await stage.write("ada", text)
        async with listening(stage) as inbox:
            await until(stage, lambda: len(inbox.done) >= MISSED, "a message was swallowed")
            assert inbox.texts(stage.chat("ada")) == written
            assert all(one.sent_ns < one.listening_since_ns for one in inbox.heard)
            await until_fresh(stage, inbox)


async def test_the_homeserver_is_restarted(synapse: Synapse, tmp_path: Path) -> None:
    async with matrix_stage(synapse, tmp_path, encrypted=True) as stage, listening(stage) as inbox:
        await until_fresh(stage, inbox)
        synapse.restart()
        await stage.write("ada", "omni move 1 m")
        await until(stage, lambda: len(inbox.done) == 1, "a message was swallowed")
        await until_fresh(stage, inbox)


@pytest.mark.parametrize("encrypted", [True, False])
async def test_a_device_that_was_signed_out_signs_in_again(
    synapse: Synapse, tmp_path: Path, *, encrypted: bool
) -> None:
    async with (
        matrix_stage(synapse, tmp_path, encrypted=encrypted) as stage,
        listening(stage) as inbox,
    ):
        await until_fresh(stage, inbox)
        library = stage._own._client.library
        device = library.device_id
        own = {"Authorization": f"Bearer {library.access_token}"}
        async with httpx.AsyncClient(headers=own) as wire:
            answer = await wire.post(f"{synapse.url}/_matrix/client/v3/logout")
            assert answer.status_code == 200
        await until(stage, lambda: library.access_token not in own["Authorization"], "it is out")
        await until(stage, lambda: library.olm.account.shared, "its keys are not there")
        await stage.write("ada", "omni move 1 m")
        await until(stage, lambda: len(inbox.done) == 1, "a message was swallowed")
        assert library.device_id == device
