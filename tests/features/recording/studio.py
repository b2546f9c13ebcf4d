"""A gateway in which robots are recorded, and a reader of what comes of it that is not ours."""

from __future__ import annotations

import asyncio
import io
import json
from collections import defaultdict
from typing import TYPE_CHECKING, Any

from jsonschema import Draft202012Validator
from mcap.reader import make_reader

from rosic.core.robot.profile import Link, Profile, Telemetry
from rosic.features.recording import RecordingFeature
from rosic.foxglove.recorder import recorder
from tests.gateway.place import ADA, FLEET, LOOK, MOVE, WAVE, Place, edited
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.store import Store
    from rosic.core.message import Attachment
    from rosic.messengers.memory import MemoryMessenger
    from rosic.testing.clock import ManualClock

SEEN = Profile(
    id="omni",
    title="Omni",
    link=Link(kind="memory"),
    skills={skill.id: skill for skill in (MOVE, WAVE, LOOK)},
    telemetry={"battery": Telemetry(unit="%", alert_below=20.0), "speed": Telemetry(unit="m/s")},
    camera={"topic": "camera"},
    map={"topic": "map"},
    pose={"topic": "odom"},
)


class Studio(Place):
    """Robots that show what they do."""

    recorder = recorder()

    def __init__(
        self,
        store: Store | None = None,
        *,
        clock: ManualClock | None = None,
        chat: Callable[[ManualClock], MemoryMessenger] = edited,
    ) -> None:
        super().__init__(store, clock=clock, fleet=(SEEN, *FLEET[1:]), chat=chat)

    async def past(self, seconds: float) -> None:
        """Let time pass, and everything that a thread does meanwhile be done."""
        for _ in range(max(1, round(seconds / 0.5))):
            await self.clock.advance(min(0.5, seconds))
            await self.written()

    async def written(self) -> None:
        """Wait for threads: they take real time, and the clock here stands still."""
        for _ in range(20):
            await self.quiet()
            await asyncio.sleep(0.001)

    async def file(self, account: str = ADA) -> Attachment:
        """Return the newest file that somebody was sent."""
        async with asyncio.timeout(60 * pace()):
            while True:
                await self.clock.advance(0.1)
                await self.written()
                for told in reversed(self.chat.told):
                    found = told.outbound.attachment
                    if found is not None and told.outbound.chat.id == account:
                        return found

    @property
    def recordings(self) -> int:
        """How many are under way."""
        return len(self.gateway.features.get(RecordingFeature).service)


def read(content: bytes) -> dict[str, list[dict[str, Any]]]:
    """Return the messages of a file by topic, each checked against the schema that goes with it."""
    found: dict[str, list[dict[str, Any]]] = defaultdict(list)
    known: dict[int, Draft202012Validator] = {}
    for schema, channel, message in make_reader(io.BytesIO(content)).iter_messages():
        assert schema is not None
        assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
        if schema.id not in known:
            definition = json.loads(schema.data)
            Draft202012Validator.check_schema(definition)
            known[schema.id] = Draft202012Validator(definition)
        value = json.loads(message.data)
        known[schema.id].validate(value)
        stamp = value["timestamp"]
        assert stamp["sec"] * 10**9 + stamp["nsec"] == message.log_time == message.publish_time
        found[channel.topic].append(value | {"schema": schema.name})
    return dict(found)
