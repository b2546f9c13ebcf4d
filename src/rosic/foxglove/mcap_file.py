"""An MCAP file of what was seen, written part by part with the library of its authors.

Each part ends with a whole chunk, so that what was written before a crash can be read, and made a
whole file again.
"""

from __future__ import annotations

import io
import logging
import struct
from typing import TYPE_CHECKING, Any, Final

from mcap.exceptions import McapError
from mcap.records import Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import Writer

from rosic import __version__
from rosic.foxglove.messages import FoxgloveMessages

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.contracts.recording import ChannelDescription
    from rosic.core.robot.observation import Observation, RecordedRobot

LIBRARY: Final = f"rosic {__version__}"
METADATA: Final = "rosic"
JSON: Final = "json"
JSON_SCHEMA: Final = "jsonschema"
CHUNK_BYTES: Final = 1_000_000

log = logging.getLogger("rosic.recording")


class _Parts(io.BufferedIOBase):
    """A stream that gives away what was written to it, and knows how far it came."""

    def __init__(self) -> None:
        self._held = bytearray()
        self._given = 0

    def write(self, data: Any) -> int:  # noqa: ANN401 - anything that is bytes
        self._held += data
        return len(data)

    def tell(self) -> int:
        return self._given + len(self._held)

    def take(self) -> bytes:
        taken = bytes(self._held)
        self._given += len(taken)
        self._held.clear()
        return taken


class _File:
    """A writer and the parts that it makes; schemas and channels come as they are needed."""

    def __init__(self) -> None:
        self._parts = _Parts()
        parts: Any = self._parts  # the library's types know fewer streams than it takes
        self._writer: Any = Writer(parts, chunk_size=CHUNK_BYTES)
        self._writer.start(library=LIBRARY)
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}

    def about(self, told: dict[str, str], name: str = METADATA) -> None:
        self._writer.add_metadata(name, told)

    def channel(self, described: ChannelDescription) -> int:
        known = self._channels.get(described.topic)
        if known is None:
            schema = self._schemas.get(described.schema)
            if schema is None:
                definition = described.definition.encode()
                schema = self.schema(described.schema, JSON_SCHEMA, definition)
                self._schemas[described.schema] = schema
            known = self.row(described.topic, JSON, schema, dict(described.about))
            self._channels[described.topic] = known
        return known

    def schema(self, name: str, encoding: str, data: bytes) -> int:
        return int(self._writer.register_schema(name, encoding, data))

    def row(self, topic: str, encoding: str, schema: int, about: dict[str, str]) -> int:
        return int(self._writer.register_channel(topic, encoding, schema, about))

    def add(self, channel: int, log_ns: int, publish_ns: int, content: bytes) -> None:
        self._writer.add_message(channel, log_ns, content, publish_ns)

    def part(self) -> bytes:
        self._writer.flush()
        return self._parts.take()

    def end(self) -> bytes:
        self._writer.finish()
        self._writer.flush()
        return self._parts.take()


class McapEncoder:
    """Makes one file; see ``contracts.recording.RecordingEncoder``."""

    def __init__(self, robots: Sequence[RecordedRobot], about: dict[str, str]) -> None:
        self._messages = FoxgloveMessages(robots)
        self._file = _File()
        names = {f"robot.{robot.id}": robot.shown for robot in robots}
        told = {name: _plain(text) for name, text in (about | names).items()}
        self._file.about(told)

    def encode(self, seen: Sequence[Observation]) -> bytes:
        """Return the next part: a chunk with all of this, or nothing."""
        for message in self._messages.messages(seen):
            channel = self._file.channel(message.channel)
            self._file.add(channel, message.at_ns, message.at_ns, message.content)
        return self._file.part()

    def finish(self) -> bytes:
        """Return the last part."""
        return self._file.end()


def repair(content: bytes) -> bytes:
    """Return a whole file of one that was broken off; see ``contracts.recording.Recorder``."""
    rescue = _Rescue()
    try:
        for record in StreamReader(io.BytesIO(content), validate_crcs=True).records:
            rescue.take(record)
    except (McapError, ValueError, KeyError, struct.error, EOFError) as end:
        log.info("a recording was read until it broke off (%s)", type(end).__name__)
    except Exception:  # the decompressor has errors of its own
        log.info("a recording was read until it broke off", exc_info=True)
    return rescue.end()


class _Rescue:
    """Takes over the records of a broken file."""

    def __init__(self) -> None:
        self._file = _File()
        self._schemas: dict[int, int] = {0: 0}
        self._channels: dict[int, int] = {}
        self._count = 0

    def take(self, record: object) -> None:
        if isinstance(record, Metadata):
            self._file.about(record.metadata, record.name)
        elif isinstance(record, Schema):
            if record.id not in self._schemas:
                known = self._file.schema(record.name, record.encoding, record.data)
                self._schemas[record.id] = known
        elif isinstance(record, Channel):
            if record.id not in self._channels:
                self._channels[record.id] = self._file.row(
                    record.topic,
                    record.message_encoding,
                    self._schemas[record.schema_id],
                    record.metadata,
                )
        elif isinstance(record, Message):
            channel = self._channels[record.channel_id]
            self._file.add(channel, record.log_time, record.publish_time, record.data)
            self._count += 1

    def end(self) -> bytes:
        return self._file.end() if self._count else b""


def _plain(text: str) -> str:
    return text.encode("utf-8", "replace").decode()
