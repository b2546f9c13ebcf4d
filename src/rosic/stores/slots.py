"""The form of the stop file: a header, a place for each robot's name, and one for its state.

Every slot has 64 bytes, so none crosses a sector, and a checksum of its own. The name is written
once and the state again and again: a state that was torn or damaged still says whose it is.
"""

from __future__ import annotations

import struct
from hashlib import blake2b

import msgspec

from rosic.core.robot.profile import ROBOT_ID, RobotId

SLOT_BYTES = 64
BODY = struct.Struct("<32sQ8s")
SUM_BYTES = 16
MAGIC = b"rosic stop file 1"
FREE = bytes(SLOT_BYTES)
PLAUSIBLE = 1 << 40  # a generation above this was never reached by stopping robots


class DamagedSlot(Exception):
    """A slot is not what was written."""


class SlotState(msgspec.Struct, frozen=True):
    """What one slot says of one robot."""

    robot: RobotId
    generation: int
    latched: bool


def pack(kind: bytes, name: bytes, number: int, flag: bytes) -> bytes:
    """Return a slot of one kind: header, name or state. None can be read as another."""
    body = BODY.pack(name, number, flag)
    return body + blake2b(body, digest_size=SUM_BYTES, person=kind).digest()


def unpack(kind: bytes, slot: bytes) -> tuple[bytes, int, bytes] | None:
    """Read a slot; None when it was never used.

    Raises:
        DamagedSlot: Not whole.
    """
    if slot == FREE:
        return None
    body = slot[: BODY.size]
    if slot[BODY.size :] != blake2b(body, digest_size=SUM_BYTES, person=kind).digest():
        raise DamagedSlot
    name, number, flag = BODY.unpack(body)
    return name.rstrip(b"\0"), number, flag.rstrip(b"\0")


def header(robots_max: int) -> bytes:
    """Return the first slot of the file."""
    return pack(b"header", MAGIC, robots_max, b"")


def empty_file(robots_max: int) -> bytes:
    """Return a whole file in which no robot is known."""
    return header(robots_max) + bytes(2 * robots_max * SLOT_BYTES)


def robots_max_of(content: bytes) -> int:
    """Return for how many robots a file has room.

    Raises:
        DamagedSlot: It is no stop file, or a part of it is missing.
    """
    found = unpack(b"header", content[:SLOT_BYTES])
    if found is None or found[0] != MAGIC or len(content) != len(empty_file(found[1])):
        raise DamagedSlot
    return found[1]


def enlarged(content: bytes, robots_max: int) -> bytes:
    """Return a file with more room; every slot is as it was, damaged ones included.

    Raises:
        DamagedSlot: It is no stop file, or a part of it is missing.
    """
    room = robots_max_of(content)
    more = bytes((robots_max - room) * SLOT_BYTES)
    names, states = state_offset(0, room), len(content)
    held = content[SLOT_BYTES:names], content[names:states]
    return b"".join((header(robots_max), held[0], more, held[1], more))


def pack_name(robot: RobotId) -> bytes:
    """Return the slot that says whose place this is."""
    return pack(b"name", robot.encode(), 0, b"")


def pack_state(state: SlotState) -> bytes:
    """Return the slot that says whether a robot is stopped."""
    return pack(b"state", state.robot.encode(), state.generation, b"s" if state.latched else b"r")


def name_offset(index: int) -> int:
    """Return where in the file a robot's name is."""
    return (1 + index) * SLOT_BYTES


def state_offset(index: int, robots_max: int) -> int:
    """Return where in the file a robot's state is."""
    return (1 + robots_max + index) * SLOT_BYTES


def read_place(name_slot: bytes, state_slot: bytes) -> SlotState | None:
    """Read what is known of one robot; None for a place that was never used.

    Whatever is damaged reads as stopped, with the generation that the damaged bytes show.

    Raises:
        DamagedSlot: So much that it cannot be said which robot it is.
    """
    if name_slot == FREE and state_slot == FREE:
        return None
    name, state = robot_named(name_slot), whole_state(state_slot)
    if state is not None and name in (None, state.robot):
        return state
    if name is None:
        raise DamagedSlot
    generation = int(BODY.unpack(state_slot[: BODY.size])[1])
    return SlotState(name, generation if generation < PLAUSIBLE else 0, latched=True)


def robot_named(slot: bytes) -> RobotId | None:
    """Return the name in a name slot, if it can be read."""
    try:
        found = unpack(b"name", slot)
    except DamagedSlot:
        return None
    return None if found is None else found[0].decode()


def whole_state(slot: bytes) -> SlotState | None:
    """Return the state in a state slot, if it can be read."""
    try:
        found = unpack(b"state", slot)
    except DamagedSlot:
        return None
    return None if found is None else SlotState(found[0].decode(), found[1], found[2] == b"s")


def is_robot(robot: RobotId) -> bool:
    """Whether a name fits into a slot."""
    return ROBOT_ID.match(robot) is not None
