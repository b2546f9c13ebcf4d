"""From records to rows. Runs in the writer's thread, so that the event loop does none of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import msgspec

from rosic.core.i18n import said
from rosic.core.identity import CommandId
from rosic.core.records import (
    Claimed,
    Concluded,
    Decided,
    Enrolled,
    Fact,
    KeyIssued,
    KeyRevoked,
    Letter,
    Placed,
    Record,
    Refused,
    Resumed,
    Seeded,
    Selected,
    Stopped,
    Told,
)
from rosic.errors import StoreFault
from rosic.stores.encryption import place_of_fact

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.stores.data_dir import StoreSettings
    from rosic.stores.encryption import ContainerKey, RootKey


# ---- rows of one transaction ----


class WriteBatch:
    """The rows of one group, table by table; each list is flat, row after row.

    Where one record of the group bears on the row of another, a dict keeps only one: no statement
    may touch a row twice.

    Attributes:
        opened: New commands whose author is to hear of them.
        silent: New commands of which nobody is to hear.
        closed: Commands that need not be told any more.
        struck: Those of them that stand in ``open_orders_of``.
        below: Up to where the record is sifted with this group; None for no change.
        kept: Commands that sifting finds open.
        facts: What is so, in the order in which it was first said.
        ended: Kinds and keys of facts that were taken back, before those in ``facts`` were said.
        keys: Keys of containers that are new in this group.
    """

    __slots__ = (
        "below",
        "cards",
        "closed",
        "commands",
        "decisions",
        "ended",
        "endings",
        "facts",
        "issued",
        "kept",
        "keys",
        "opened",
        "places",
        "principals",
        "revocations",
        "robots",
        "seeds",
        "selections",
        "silent",
        "stops",
        "struck",
        "tellings",
    )

    def __init__(self) -> None:
        self.commands: list[object] = []
        self.tellings: list[object] = []
        self.stops: list[object] = []
        self.issued: list[object] = []
        self.revocations: list[object] = []
        self.seeds: list[object] = []
        self.struck: list[object] = []
        self.kept: list[object] = []
        self.decisions: list[object] = []
        self.below: int | None = None
        self.endings: dict[int, tuple[object, ...]] = {}
        self.places: dict[int, tuple[object, ...]] = {}
        self.robots: dict[RobotId, tuple[int, int, int]] = {}
        self.principals: dict[PrincipalId, tuple[str, int]] = {}
        self.cards: dict[PrincipalId, tuple[str, bytes]] = {}
        self.selections: dict[tuple[PrincipalId, bytes], str] = {}
        self.facts: dict[tuple[str, str], tuple[object, ...]] = {}
        self.ended: set[tuple[str, str]] = set()
        self.keys: dict[str, ContainerKey] = {}
        self.opened: dict[CommandId, int] = {}
        self.silent: dict[CommandId, int] = {}
        self.closed: dict[CommandId, int] = {}


# The kinds of letters. One byte each, for ever: they are part of what a letter is sealed with.
CLAIM, WORDS, PLACED, CARD, FACT = b"c", b"w", b"p", b"e", b"f"

KEYS_MAX = 10_000  # kept at hand; more are read again when they are needed
NO_LETTER = (None, None)


class DatabasePosition(msgspec.Struct, frozen=True):
    """Where the database stands.

    Attributes:
        open_orders: Open commands and their numbers.
        below: Up to which number it is sifted.
        next_seq: The number of the next command.
    """

    open_orders: dict[CommandId, int]
    below: int
    next_seq: int


class RecordEncoder:
    """Turns records into rows, and knows the numbers of the commands that are still open.

    Args:
        root: Wraps the keys of new containers.
        standing: From where to go on.
        find_seq: Asks the database for the number of a command that is not open any more.
        find_key: Asks the database for the wrapped key of a container.
        settings: How many commands may be open, and how many are left unsifted.
    """

    def __init__(
        self,
        root: RootKey,
        standing: DatabasePosition,
        find_seq: Callable[[CommandId], int | None],
        find_key: Callable[[str], bytes | None],
        *,
        settings: StoreSettings,
    ) -> None:
        self._settings = settings
        self._root = root
        self._open_orders = dict(standing.open_orders)
        self._below = standing.below
        self._next_seq = standing.next_seq
        self._find_seq = find_seq
        self._find_key = find_key
        self._keys: dict[str, ContainerKey] = {}
        self._take: dict[type, Callable[[WriteBatch, Any], None]] = {
            Claimed: self._claimed,
            Refused: self._refused,
            Concluded: self._concluded,
            Placed: self._placed,
            Told: self._told,
            Stopped: self._stopped,
            Resumed: self._resumed,
            Enrolled: self._enrolled,
            KeyIssued: self._key_issued,
            KeyRevoked: self._key_revoked,
            Selected: self._selected,
            Seeded: self._seeded,
            Fact: self._fact,
            Decided: self._decided,
        }

    def rows(self, calls: Iterable[tuple[Record, ...]]) -> WriteBatch:
        """Return the rows of a group. Remembers nothing but that numbers were used.

        Raises:
            StoreFault: Too many commands are open.
        """
        batch, first, take = WriteBatch(), self._next_seq, self._take
        for records in calls:
            for record in records:
                take[type(record)](batch, record)
        if (
            batch.opened
            and len(self._open_orders) + len(batch.opened) > self._settings.open_orders_max
        ):
            raise StoreFault(said("The record is full. Nothing was written."))
        below = self._below
        batch.struck = [seq for seq in batch.closed.values() if seq < below]
        unsifted = self._settings.unsifted
        if first - below >= 2 * unsifted:
            self._sift(batch, first - unsifted)
        return batch

    def _sift(self, batch: WriteBatch, below: int) -> None:
        """Write down which commands are open below a number; none of them is of this batch."""
        batch.below = below
        batch.kept = [
            seq
            for cid, seq in self._open_orders.items()
            if self._below <= seq < below and cid not in batch.closed
        ]

    def remember(self, batch: WriteBatch) -> None:
        """The rows are in the database now."""
        self._open_orders.update(batch.opened)
        for cid in batch.closed:
            self._open_orders.pop(cid, None)
        if batch.below is not None:
            self._below = batch.below
        if len(self._keys) > KEYS_MAX:
            self._keys.clear()
        self._keys.update(batch.keys)

    def forget_key(self, container: str) -> None:
        """The key of a container was erased."""
        self._keys.pop(container, None)

    # ---- commands ----

    def _number(self) -> int:
        seq = self._next_seq
        self._next_seq = seq + 1
        return seq

    def _seq(self, batch: WriteBatch, cid: CommandId) -> int | None:
        seq = self._open_orders.get(cid) or batch.opened.get(cid) or batch.silent.get(cid)
        return self._find_seq(cid) if seq is None else seq

    def _claimed(self, batch: WriteBatch, record: Claimed) -> None:
        cid, robot = record.cid, record.robot
        seq = batch.opened[cid] = self._number()
        batch.commands += (
            seq,
            cid,
            "claimed",
            record.principal,
            record.accepted_ns,
            None,
            record.key,
            robot,
            record.skill,
            record.n,
            record.fence,
            record.new_fence,
            record.stop_generation,
            record.epoch,
            record.digest,
            record.expires_ns,
            *self._sealed(batch, CLAIM, cid, record.letter),
        )
        self._raise(batch, robot, record.n, record.fence, record.stop_generation)

    def _refused(self, batch: WriteBatch, record: Refused) -> None:
        cid, letter = record.cid, record.letter
        seq = self._number()
        (batch.silent if letter is None else batch.opened)[cid] = seq
        batch.commands += (seq, cid, "refused", record.principal, record.at_ns, record.code)
        batch.commands += (None,) * 10
        batch.commands += self._sealed(batch, CLAIM, cid, letter)

    def _resumed(self, batch: WriteBatch, record: Resumed) -> None:
        seq = batch.silent[record.cid] = self._number()
        batch.commands += (seq, record.cid, "resumed", record.principal, record.at_ns, None)
        batch.commands += (None, record.robot, None, None, None, None, record.generation)
        batch.commands += (None, None, None, *NO_LETTER)
        self._raise(batch, record.robot, 0, 0, record.generation)

    def _concluded(self, batch: WriteBatch, record: Concluded) -> None:
        cid, letter = record.cid, record.letter
        seq = self._seq(batch, cid)
        if seq is None:
            return  # the command itself was never written, so nothing came of it
        first = batch.endings.get(seq)
        if first is None:
            sealed = self._sealed(batch, WORDS, cid, letter)
            batch.endings[seq] = (seq, record.ending, record.at_ns, *sealed)
        elif letter is None:
            batch.endings[seq] = (*first[:3], *NO_LETTER)
        if letter is None:
            batch.closed[cid] = seq

    def _placed(self, batch: WriteBatch, record: Placed) -> None:
        cid = record.cid
        seq = self._seq(batch, cid)
        if seq is not None:
            batch.places[seq] = (seq, *self._sealed(batch, PLACED, cid, record.letter))

    def _told(self, batch: WriteBatch, record: Told) -> None:
        cid = record.cid
        seq = self._seq(batch, cid)
        if seq is not None:
            batch.tellings += (seq, record.at_ns)
            batch.closed[cid] = seq

    # ---- robots ----

    def _stopped(self, batch: WriteBatch, record: Stopped) -> None:
        robot, generation = record.robot, record.generation
        if not record.repeated:
            batch.stops += (robot, generation, record.principal, record.at_ns, record.gap)
        self._raise(batch, robot, 0, 0, generation)

    def _raise(
        self, batch: WriteBatch, robot: RobotId, n: int, fence: int, generation: int
    ) -> None:
        seen = batch.robots.get(robot)
        if seen is not None:
            n, fence, generation = max(n, seen[0]), max(fence, seen[1]), max(generation, seen[2])
        batch.robots[robot] = (n, fence, generation)

    # ---- people ----

    def _enrolled(self, batch: WriteBatch, record: Enrolled) -> None:
        principal, letter = record.principal, record.letter
        key = self._key(batch, letter.container)
        sealed = key.seal(CARD, principal.encode(), letter.content)
        batch.principals[principal] = (msgspec.json.encode(record.roles).decode(), record.at_ns)
        batch.cards[principal] = (letter.container, sealed)

    def _key_issued(self, batch: WriteBatch, record: KeyIssued) -> None:
        key = record.key
        scopes = msgspec.json.encode(key.scopes).decode()
        batch.issued += (key.id, key.principal, key.issuer, key.issued_ns)
        batch.issued += (scopes, key.expires_ns, key.revoked_ns)

    def _key_revoked(self, batch: WriteBatch, record: KeyRevoked) -> None:
        batch.revocations += (record.key, record.by, record.at_ns)

    def _selected(self, batch: WriteBatch, record: Selected) -> None:
        batch.selections[record.principal, record.chat] = record.robot

    def _seeded(self, batch: WriteBatch, record: Seeded) -> None:
        batch.seeds += (record.name_digest, record.principal)

    # ---- what the rooms know ----

    def _fact(self, batch: WriteBatch, record: Fact) -> None:
        place = (record.kind, record.key)
        if record.body:
            subject = place_of_fact(*place)
            batch.facts[place] = (record.body, *self._sealed(batch, FACT, subject, record.letter))
        else:
            # Taken back and said again in one group, it stands behind all others.
            batch.facts.pop(place, None)
            batch.ended.add(place)

    def _decided(self, batch: WriteBatch, record: Decided) -> None:
        batch.decisions += (record.act, record.by, record.about, record.at_ns, record.digest)

    # ---- letters ----

    def _sealed(
        self, batch: WriteBatch, kind: bytes, subject: bytes, letter: Letter | None
    ) -> tuple[object, object]:
        """Return whose key seals a letter, and the sealed letter."""
        if letter is None:
            return NO_LETTER
        container = letter.container
        key = self._keys.get(container) or self._key(batch, container)
        return container, key.seal(kind, subject, letter.content)

    def _key(self, batch: WriteBatch, container: str) -> ContainerKey:
        key = self._keys.get(container) or batch.keys.get(container)
        if key is None:
            wrapped = self._find_key(container)
            if wrapped is None:
                key = batch.keys[container] = self._root.new_key(container)
            else:
                key = self._keys[container] = self._root.unwrap(container, wrapped)
        return key
