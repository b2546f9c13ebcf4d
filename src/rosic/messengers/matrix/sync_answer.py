"""An answer of a homeserver, split into pieces that are read one at a time.

Splitting looks for the ends of the pieces and at nothing else; a piece that is malformed or too
large is passed over by itself, and what stands beside it is read. Matrix specification v1.11,
client-server API: ``GET /_matrix/client/v3/sync``, "Size limits".
"""

from __future__ import annotations

from typing import Any, Final, TypeVar

import msgspec
from msgspec import Raw

T = TypeVar("T")

MOST_BYTES: Final = 8 * 2**20
"""Of one answer. Splitting that many takes some milliseconds; of more, less is asked for."""
MOST_AT_START: Final = 64 * 2**20
"""Of the first answer of a run, which holds the whole state of all rooms: some 150,000 members."""
LONGEST_EVENT: Final = 2**17
"""An honest event has 65,536 bytes at the most, and what the homeserver adds for us."""
LONGEST_ID: Final = 255
"""Of a room, a user or an event."""


NOTHING: Final = Raw(b"null")


class RoomPart(msgspec.Struct, frozen=True):
    """What an answer brought of one room that we are in.

    Attributes:
        state: Its state before the timeline, as far as it has changed.
        timeline: What happened in it, oldest first.
        limited: The homeserver has left something out before that.
        before: From where what was left out is asked for.
    """

    state: tuple[Raw, ...] = ()
    timeline: tuple[Raw, ...] = ()
    limited: bool = False
    before: str = ""


class SyncAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """One answer to a sync. None of its pieces is read yet.

    Attributes:
        next_batch: Where the next sync goes on.
        joined: Rooms that we are in, by their ids; each is read by `room_part`.
        invited: Rooms that we were invited to, with what is shown of their state.
        left: Rooms that we are not in any more.
        to_device: What came to this device.
        changed: People whose devices are others, or who share no room with us any more.
        one_time_keys: So many of ours are left there; None: it does not say.
    """

    next_batch: str
    joined: dict[str, Raw] = {}
    invited: dict[str, Raw] = {}
    left: tuple[str, ...] = ()
    to_device: tuple[Raw, ...] = ()
    changed: tuple[str, ...] = ()
    one_time_keys: int | None = None


class _Answer(msgspec.Struct):
    next_batch: str
    rooms: Raw = NOTHING
    to_device: Raw = NOTHING
    device_lists: Raw = NOTHING
    device_one_time_keys_count: Raw = NOTHING


class _Rooms(msgspec.Struct):
    join: Raw = NOTHING
    invite: Raw = NOTHING
    leave: Raw = NOTHING


class _Events(msgspec.Struct):
    events: list[Raw] = []


class _Timeline(msgspec.Struct):
    events: list[Raw] = []
    limited: bool = False
    prev_batch: str | None = None


class _Joined(msgspec.Struct):
    state: Raw = NOTHING
    timeline: Raw = NOTHING


class _Invited(msgspec.Struct):
    invite_state: Raw = NOTHING


class _DeviceLists(msgspec.Struct):
    changed: list[str] = []
    left: list[str] = []


class _Chunk(msgspec.Struct):
    chunk: list[Raw]
    end: str | None = None


def split_answer(body: bytes) -> SyncAnswer:
    """Return the pieces of an answer to a sync.

    Raises:
        ValueError: It is none.
    """
    answer = _read(body, _Answer)
    if answer is None or not answer.next_batch:
        raise ValueError("this is no answer to a sync")
    rooms = _read(answer.rooms, _Rooms) or _Rooms()
    lists = _read(answer.device_lists, _DeviceLists) or _DeviceLists()
    counts = _read(answer.device_one_time_keys_count, dict[str, int]) or {}
    return SyncAnswer(
        next_batch=answer.next_batch,
        joined=_rooms_of(rooms.join),
        invited=_rooms_of(rooms.invite),
        left=tuple(_rooms_of(rooms.leave)),
        to_device=tuple((_read(answer.to_device, _Events) or _Events()).events),
        changed=tuple(one for one in (*lists.changed, *lists.left) if len(one) <= LONGEST_ID),
        one_time_keys=counts.get("signed_curve25519"),
    )


def room_part(piece: Raw) -> RoomPart:
    """Return what an answer brought of a room that we are in; nothing, where it is malformed."""
    room = _read(piece, _Joined) or _Joined()
    timeline = _read(room.timeline, _Timeline) or _Timeline()
    return RoomPart(
        tuple((_read(room.state, _Events) or _Events()).events),
        tuple(timeline.events),
        timeline.limited,
        timeline.prev_batch or "",
    )


def invite_state(piece: Raw) -> tuple[Raw, ...]:
    """Return what is shown of the state of a room that we were invited to."""
    room = _read(piece, _Invited) or _Invited()
    return tuple((_read(room.invite_state, _Events) or _Events()).events)


def earlier_part(body: bytes) -> tuple[tuple[Raw, ...], str]:
    """Return events of ``GET .../messages``, and the point that they reach back to.

    Raises:
        ValueError: It is none.
    """
    found = _read(body, _Chunk)
    if found is None:
        raise ValueError("this is no part of a room")
    return tuple(found.chunk), found.end or ""


def event_of(piece: Raw) -> dict[str, Any] | None:
    """Return an event as it came; None for what is none, or is too large."""
    if len(bytes(piece)) > LONGEST_EVENT:
        return None
    found = _read(piece, dict[str, Any])
    if found is None:
        return None
    names = (found.get("event_id", ""), found.get("sender", ""), found.get("type", ""))
    if any(not isinstance(name, str) or len(name) > LONGEST_ID for name in names):
        return None
    return found


def _rooms_of(piece: Raw) -> dict[str, Raw]:
    found = _read(piece, dict[str, Raw]) or {}
    return {room: of for room, of in found.items() if len(room) <= LONGEST_ID}


def _read(piece: Raw | bytes, kind: type[T]) -> T | None:
    """Return a piece as what it should be; None where it is something else, or is missing."""
    try:
        return msgspec.json.decode(piece, type=kind)
    except (ValueError, RecursionError):  # msgspec's own errors are of these
        return None
