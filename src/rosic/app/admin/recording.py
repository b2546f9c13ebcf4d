"""A recording for the operator of the machine, over the connection on which they asked for it.

The file is written by whoever asked, with their rights, where they say. What is sent is the file
and nothing else; whoever ends their side of the connection ends it, and is sent the rest.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.identity import OPERATOR
from rosic.errors import RecordUnavailable
from rosic.features.recording import RecordingFeature
from rosic.features.recording.service import RecordingEnd

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.app.gateway import Gateway
    from rosic.contracts.programs import ServeConnection
    from rosic.core.robot.profile import RobotId

MOST_BYTES: Final = 4_000_000_000
TAKEN_WITHIN_S: Final = 10.0
NOT_TAKEN: Final = "Nobody takes this recording any more."


class RecordParameters(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How long, and whether with what cameras show."""

    for_s: float
    pictures: bool = False


def recording_for_operator(
    gateway: Gateway, robots: Sequence[RobotId], asked: RecordParameters
) -> ServeConnection:
    """Return what records robots over a connection.

    Raises:
        NotPermitted: Recordings cannot be made here.
        TooManyRequests: Too much is recorded already.
    """
    service = gateway.features.get(RecordingFeature).service
    service.check_possible()

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        async def write(part: bytes) -> None:
            try:
                writer.write(part)
                await asyncio.wait_for(writer.drain(), TAKEN_WITHIN_S)
            except (OSError, TimeoutError) as gone:
                raise RecordUnavailable(NOT_TAKEN) from gone

        recording = service.begin(OPERATOR, robots, write, MOST_BYTES)

        async def hear_out() -> None:
            while await reader.read(1024):
                pass
            recording.end(RecordingEnd.ASKED)

        hearing = asyncio.create_task(hear_out())
        try:
            await service.run(recording, asked.for_s, pictures=asked.pictures)
        finally:
            hearing.cancel()
            await asyncio.gather(hearing, return_exceptions=True)

    return serve
