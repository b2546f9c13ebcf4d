"""How far each session of a sender's device has come: over restarts, so that nothing old is new.

Whoever runs a homeserver can give a ciphertext out again as another event, or hold it back and give
it out later, with any time. Two things they cannot change: its index within its session, which
belongs to one message for good (Matrix specification v1.11, client-server API, "Message replay
attacks"), and the order of the indices, in which its sender encrypted. So what comes when its
session had come further was written before that, and so was everything in a session that its
device has given up for a newer one in that room.

What is remembered is bounded, and what was forgotten is old: a session that was given up is gone
with its key, and of one that is kept nothing below a floor is new.
"""

from __future__ import annotations

import asyncio
import enum
import sqlite3
from collections import OrderedDict
from contextlib import closing
from hashlib import blake2b
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.errors import ConfigurationError, MessengerFault

if TYPE_CHECKING:
    from pathlib import Path

SESSIONS_AT_MOST: Final = 5_000
WINDOW: Final = 128
"""Indices of one session that are remembered one by one, below the highest."""
PLACES_AT_MOST: Final = 50_000
"""Of all sessions together."""
FILE: Final = "sessions.db"

_MAKE: Final = """
CREATE TABLE IF NOT EXISTS sessions (
    session BLOB PRIMARY KEY,
    device BLOB NOT NULL,
    number INTEGER NOT NULL,
    floor INTEGER NOT NULL,
    first_ms INTEGER NOT NULL
) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS places (
    session BLOB NOT NULL,
    place INTEGER NOT NULL,
    event BLOB NOT NULL,
    received_ms INTEGER NOT NULL,
    PRIMARY KEY (session, place)
) WITHOUT ROWID;
"""


class SessionPlace(NamedTuple):
    """Where a message stands.

    Attributes:
        room: In which the session is used.
        sender_key: Identity key of the device that encrypts with it.
        session: Its id.
        at: Index of the message within it.
    """

    room: str
    sender_key: str
    session: str
    at: int


class PlaceStanding(enum.Enum):
    """What the place of a message says of it."""

    NEW = "nothing after it has come"
    HELD_BACK = "something after it has come already"
    SAME = "this event has come already"
    FORGOTTEN = "whether it has come is not known any more"
    REPLAYED = "another event had this place"


class PlaceVerdict(NamedTuple):
    """What is known of a message by its place.

    Attributes:
        before_ms: It was sent at that time or earlier, on our own clock.
    """

    standing: PlaceStanding
    before_ms: int

    @property
    def is_late(self) -> bool:
        """Whether it was held back."""
        return self.standing in {PlaceStanding.HELD_BACK, PlaceStanding.FORGOTTEN}


class SessionRecord:
    """What is remembered of one session.

    Attributes:
        device: Of which room and device it is.
        names: Room, identity key and session; None: nobody has its key in this run.
        number: In which order its key came.
        floor: Nothing at this index or below it is new.
        first_ms: When its first message came; 0: none has.
        places: Index to the event that had it, and when that came; all above the floor.
    """

    __slots__ = ("device", "first_ms", "floor", "names", "number", "places")

    def __init__(self, device: bytes, number: int, floor: int = -1, first_ms: int = 0) -> None:
        self.device = device
        self.names: tuple[str, str, str] | None = None
        self.number = number
        self.floor = floor
        self.first_ms = first_ms
        self.places: dict[int, tuple[bytes, int]] = {}

    def has_key(self, room: str, sender_key: str, session: str) -> None:
        """Note that its key is here, and whose it is."""
        self.names = room, sender_key, session

    def came(self, index: int, event: bytes, received_ms: int) -> None:
        """Note that a message came."""
        self.places[index] = event, received_ms
        self.first_ms = self.first_ms or received_ms

    def later_ms(self, index: int) -> int | None:
        """Return when the first of those after an index came; None: none has."""
        return min((ms for at, (_, ms) in self.places.items() if at > index), default=None)

    def forget_below(self, most: int) -> int:
        """Raise the floor until so many places are left; return how many went."""
        gone = sorted(self.places)[: max(0, len(self.places) - most)]
        for index in gone:
            del self.places[index]
            self.floor = max(self.floor, index)
        return len(gone)


class ReplayGuard:
    """Judges every message that is decrypted.

    Args:
        folder: Its file lies there.
        sessions: So many are remembered.
        places: So many messages, of all sessions together.
    """

    def __init__(
        self, folder: Path, *, sessions: int = SESSIONS_AT_MOST, places: int = PLACES_AT_MOST
    ) -> None:
        self._file = folder / FILE
        self._most_sessions, self._most_places = sessions, places
        self._sessions: OrderedDict[bytes, SessionRecord] = OrderedDict()
        self._newest: dict[bytes, SessionRecord] = {}
        self._number = 0
        self._count = 0
        self._changed: set[bytes] = set()
        self._given_up: list[tuple[str, str, str]] = []
        self._writing = asyncio.Lock()

    def opened(self, room: str, sender_key: str, session: str) -> list[tuple[str, str, str]]:
        """Note that the key of a session is here; one that is known keeps its number.

        Returns:
            Sessions that are remembered no longer: their keys must go.
        """
        name = _digest(room, sender_key, session)
        if name not in self._sessions:
            self._number += 1
            self._sessions[name] = SessionRecord(_digest(room, sender_key), self._number)
            self._changed.add(name)
        self._sessions[name].has_key(room, sender_key, session)
        self._bound()
        given_up, self._given_up = self._given_up, []
        return given_up

    def closed(self, room: str, sender_key: str, session: str) -> None:
        """Forget a session whose key is gone."""
        name = _digest(room, sender_key, session)
        record = self._sessions.pop(name, None)
        if record is not None:
            self._drop(name, record)

    def is_known(self, room: str, sender_key: str, session: str) -> bool:
        """Whether a session is remembered; of one that is not, nothing may be decrypted."""
        return _digest(room, sender_key, session) in self._sessions

    def judge(
        self, place: SessionPlace, event: str, received_ms: int, *, note: bool = True
    ) -> PlaceVerdict:
        """Return what is known of a message.

        Args:
            place: Where it stands.
            event: Under which it came.
            received_ms: When it came, on our own clock.
            note: It has come; False: it is merely looked at, and will be judged again.
        """
        name = _digest(*place[:3])
        record = self._sessions.get(name)
        if record is None:
            return PlaceVerdict(PlaceStanding.FORGOTTEN, 0)
        verdict = self._verdict(record, place.at, _digest(event), received_ms)
        if note and verdict.standing in {PlaceStanding.NEW, PlaceStanding.HELD_BACK}:
            record.came(place.at, _digest(event), received_ms)
            self._note(name, record)
        return verdict

    def _verdict(
        self, record: SessionRecord, index: int, event: bytes, received_ms: int
    ) -> PlaceVerdict:
        known = record.places.get(index)
        if known is not None:
            same = known[0] == event
            return PlaceVerdict(PlaceStanding.SAME if same else PlaceStanding.REPLAYED, known[1])
        newest = self._newest.get(record.device)
        bounds = [received_ms, record.later_ms(index)]
        if newest is not None and newest.number > record.number:
            bounds.append(newest.first_ms)
        before_ms = min(ms for ms in bounds if ms is not None)
        if index <= record.floor:
            return PlaceVerdict(PlaceStanding.FORGOTTEN, before_ms)
        after = len([ms for ms in bounds if ms is not None]) > 1
        return PlaceVerdict(PlaceStanding.HELD_BACK if after else PlaceStanding.NEW, before_ms)

    def _note(self, name: bytes, record: SessionRecord) -> None:
        self._count += 1 - record.forget_below(WINDOW)
        self._sessions.move_to_end(name)
        newest = self._newest.get(record.device)
        if newest is None or newest.number < record.number:
            self._newest[record.device] = record
        self._changed.add(name)
        self._bound()

    def _bound(self) -> None:
        """Forget: places of whatever was used least lately, and in the end sessions as a whole."""
        while len(self._sessions) > self._most_sessions:
            name, record = self._sessions.popitem(last=False)
            self._drop(name, record)
            if record.names is not None:
                self._given_up.append(record.names)
        if self._count <= self._most_places:
            return
        for name, record in self._sessions.items():
            gone = record.forget_below(1)  # the last one says how far it has come
            if gone:
                self._count -= gone
                self._changed.add(name)
            if self._count <= self._most_places:
                return

    def _drop(self, name: bytes, record: SessionRecord) -> None:
        self._count -= len(record.places)
        self._changed.add(name)
        if self._newest.get(record.device) is record:
            del self._newest[record.device]

    # ---- on disk ----

    async def open(self) -> None:
        """Read what earlier runs have noted.

        Raises:
            ConfigurationError: The file is damaged, or cannot be used.
        """
        try:
            sessions, places = await asyncio.to_thread(self._read)
        except sqlite3.Error as error:
            raise ConfigurationError(
                f"{self._file} cannot be read, so nobody knows what was said before.",
                hint=f"Bring the folder back from your copy. ({error})",
            ) from None
        for name, device, number, floor, first_ms in sessions:
            record = self._sessions[name] = SessionRecord(device, number, floor, first_ms)
            self._number = max(self._number, number)
            newest = self._newest.get(device)
            if first_ms and (newest is None or newest.number < number):
                self._newest[device] = record
        for name, index, event, received_ms in places:
            if name in self._sessions:
                self._sessions[name].came(index, event, received_ms)
                self._count += 1
        self._bound()

    async def settle(self) -> None:
        """Wait until all that was noted is on disk.

        Raises:
            MessengerFault: It is not: it could be given out again as something new.
        """
        async with self._writing:
            changed, self._changed = self._changed, set()
            if not changed:
                return
            rows = [(name, self._row(name)) for name in changed]
            try:
                await asyncio.to_thread(self._write, rows)
            except Exception as error:  # whatever is wrong with it, the run goes on
                self._changed |= changed
                raise MessengerFault("What was decrypted could not be written down.") from error

    def _row(self, name: bytes) -> _Row | None:
        record = self._sessions.get(name)
        if record is None:
            return None
        row = (record.device, record.number, record.floor, record.first_ms)
        return _Row(row, [(at, *came) for at, came in record.places.items()])

    def _opened(self) -> sqlite3.Connection:
        connection = sqlite3.connect(self._file)
        connection.execute("PRAGMA synchronous = FULL")
        connection.executescript(_MAKE)
        return connection

    def _read(
        self,
    ) -> tuple[list[tuple[bytes, bytes, int, int, int]], list[tuple[bytes, int, bytes, int]]]:
        with closing(self._opened()) as connection:
            sessions = connection.execute(
                "SELECT session, device, number, floor, first_ms FROM sessions ORDER BY number"
            ).fetchall()
            places = connection.execute(
                "SELECT session, place, event, received_ms FROM places"
            ).fetchall()
        return sessions, places

    def _write(self, rows: list[tuple[bytes, _Row | None]]) -> None:
        with closing(self._opened()) as connection, connection:
            for name, row in rows:
                connection.execute("DELETE FROM places WHERE session = ?", (name,))
                connection.execute("DELETE FROM sessions WHERE session = ?", (name,))
                if row is not None:
                    connection.execute(
                        "INSERT INTO sessions VALUES (?, ?, ?, ?, ?)", (name, *row.session)
                    )
                    connection.executemany(
                        "INSERT INTO places VALUES (?, ?, ?, ?)",
                        [(name, *place) for place in row.places],
                    )


class _Row(NamedTuple):
    """A session as it is written down."""

    session: tuple[bytes, int, int, int]
    places: list[tuple[int, bytes, int]]


def _digest(*parts: str) -> bytes:
    """Return a short name for what strangers may choose the length and the signs of."""
    text = "\x00".join(parts).encode("utf-8", "surrogatepass")
    return blake2b(text, digest_size=20).digest()
