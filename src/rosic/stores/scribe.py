"""From records to rows. Runs in the writer's thread, so that the event loop does none of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import msgspec

from rosic.core.record import (
    Claimed,
    Concluded,
    Enrolled,
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

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.core.identity import CommandId, PrincipalId
    from rosic.core.robot import RobotId
    from rosic.stores.sealing import Key, Root

CLAIM, WORDS, PLACED = "claim", "words", "placed"
# One byte each, for ever: they are part of what a letter is sealed with.
SEAL = {CLAIM: b"c", WORDS: b"w", PLACED: b"p"}
CARD = b"e"

KEYS_MAX = 10_000  # kept at hand; more are read again when they are needed
NO_NUMBERS = (0, 0, 0)
NOTHING = (None,) * 9


class Batch:
    """The rows of one group, table by table; each list is flat, row after row.

    Where a later record of the group replaces an earlier one, a dict keeps only the last: no
    statement may touch a row twice.

    Attributes:
        fresh: Commands that are new in this group.
        opened: Those of them whose author is to hear of them.
        closed: Commands that need not be told any more.
        keys: Keys of containers that are new in this group.
    """

    __slots__ = (
        "cards",
        "closed",
        "commands",
        "endings",
        "fresh",
        "issued",
        "keys",
        "letters",
        "opened",
        "principals",
        "revocations",
        "robots",
        "seeds",
        "selections",
        "stops",
        "tellings",
    )

    def __init__(self) -> None:
        self.commands: list[object] = []
        self.endings: list[object] = []
        self.tellings: list[object] = []
        self.stops: list[object] = []
        self.issued: list[object] = []
        self.revocations: list[object] = []
        self.seeds: list[object] = []
        self.letters: dict[tuple[int, str], tuple[str, bytes]] = {}
        self.robots: dict[RobotId, tuple[int, int, int]] = {}
        self.principals: dict[PrincipalId, tuple[str, int]] = {}
        self.cards: dict[PrincipalId, tuple[str, bytes]] = {}
        self.selections: dict[tuple[PrincipalId, bytes], str] = {}
        self.keys: dict[str, Key] = {}
        self.fresh: dict[CommandId, int] = {}
        self.opened: dict[CommandId, int] = {}
        self.closed: dict[CommandId, int] = {}


class Scribe:
    """Turns records into rows, and knows the numbers of the commands that are still open.

    Args:
        root: Wraps the keys of new containers.
        lives: Open commands and their numbers, as the database has them.
        next_seq: The number of the next command.
        find_seq: Asks the database for the number of a command that is not open any more.
        find_key: Asks the database for the wrapped key of a container.
        lives_max: Open commands, before further ones are refused.
    """

    def __init__(
        self,
        root: Root,
        lives: dict[CommandId, int],
        next_seq: int,
        find_seq: Callable[[CommandId], int | None],
        find_key: Callable[[str], bytes | None],
        *,
        lives_max: int,
    ) -> None:
        self._lives_max = lives_max
        self._root = root
        self._lives = lives
        self._next_seq = next_seq
        self._find_seq = find_seq
        self._find_key = find_key
        self._keys: dict[str, Key] = {}
        self._take: dict[type, Callable[[Batch, Any], None]] = {
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
        }

    def rows(self, calls: Iterable[tuple[Record, ...]]) -> Batch:
        """Return the rows of a group. Remembers nothing but that numbers were used.

        Raises:
            StoreFault: Too many commands are open.
        """
        batch = Batch()
        take = self._take
        for records in calls:
            for record in records:
                take[type(record)](batch, record)
        if batch.opened and len(self._lives) + len(batch.opened) > self._lives_max:
            raise StoreFault("The record is full. Nothing was written.")
        return batch

    def remember(self, batch: Batch) -> None:
        """The rows are in the database now."""
        self._lives.update(batch.opened)
        for cid in batch.closed:
            self._lives.pop(cid, None)
        if len(self._keys) > KEYS_MAX:
            self._keys.clear()
        self._keys.update(batch.keys)

    def forget_key(self, container: str) -> None:
        """The key of a container was erased."""
        self._keys.pop(container, None)

    # ---- commands ----

    def _number(self, batch: Batch, cid: CommandId) -> int:
        seq = self._next_seq
        self._next_seq = seq + 1
        batch.fresh[cid] = seq
        return seq

    def _seq(self, batch: Batch, cid: CommandId) -> int | None:
        seq = self._lives.get(cid)
        if seq is None:
            seq = batch.fresh.get(cid)
        return self._find_seq(cid) if seq is None else seq

    def _claimed(self, batch: Batch, record: Claimed) -> None:
        cid, robot = record.cid, record.robot
        seq = self._number(batch, cid)
        batch.opened[cid] = seq
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
        )
        self._raise(batch, robot, record.n, record.fence, record.stop_generation)
        if record.letter is not None:
            self._letter(batch, seq, CLAIM, cid, record.letter)

    def _refused(self, batch: Batch, record: Refused) -> None:
        cid = record.cid
        seq = self._number(batch, cid)
        batch.commands += (seq, cid, "refused", record.principal, record.at_ns, record.code)
        batch.commands += (None, None, *NOTHING[:8])
        if record.letter is not None:
            batch.opened[cid] = seq
            self._letter(batch, seq, CLAIM, cid, record.letter)

    def _resumed(self, batch: Batch, record: Resumed) -> None:
        seq = self._number(batch, record.cid)
        batch.commands += (seq, record.cid, "resumed", record.principal, record.at_ns, None)
        batch.commands += (None, record.robot, None, None, None, None, record.generation)
        batch.commands += (None, None, None)
        self._raise(batch, record.robot, 0, 0, record.generation)

    def _concluded(self, batch: Batch, record: Concluded) -> None:
        seq = self._seq(batch, record.cid)
        if seq is None:
            return  # the command itself was never written, so nothing came of it
        batch.endings += (seq, record.ending, record.at_ns)
        if record.letter is None:
            batch.closed[record.cid] = seq
        elif (seq, WORDS) not in batch.letters:
            self._letter(batch, seq, WORDS, record.cid, record.letter)

    def _placed(self, batch: Batch, record: Placed) -> None:
        seq = self._seq(batch, record.cid)
        if seq is not None:
            self._letter(batch, seq, PLACED, record.cid, record.letter)

    def _told(self, batch: Batch, record: Told) -> None:
        seq = self._seq(batch, record.cid)
        if seq is not None:
            batch.tellings += (seq, record.at_ns)
            batch.closed[record.cid] = seq

    # ---- robots ----

    def _stopped(self, batch: Batch, record: Stopped) -> None:
        robot, generation = record.robot, record.generation
        batch.stops += (robot, generation, record.principal, record.at_ns, record.gap)
        self._raise(batch, robot, 0, 0, generation)

    def _raise(self, batch: Batch, robot: RobotId, n: int, fence: int, generation: int) -> None:
        seen = batch.robots.get(robot, NO_NUMBERS)
        batch.robots[robot] = (max(n, seen[0]), max(fence, seen[1]), max(generation, seen[2]))

    # ---- people ----

    def _enrolled(self, batch: Batch, record: Enrolled) -> None:
        principal, letter = record.principal, record.letter
        key = self._key(batch, letter.container)
        sealed = key.seal(CARD, principal.encode(), letter.content)
        batch.principals[principal] = (msgspec.json.encode(record.roles).decode(), record.at_ns)
        batch.cards[principal] = (letter.container, sealed)

    def _key_issued(self, batch: Batch, record: KeyIssued) -> None:
        key = record.key
        scopes = msgspec.json.encode(key.scopes).decode()
        batch.issued += (key.id, key.principal, key.issuer, key.issued_ns)
        batch.issued += (scopes, key.expires_ns, key.revoked_ns)

    def _key_revoked(self, batch: Batch, record: KeyRevoked) -> None:
        batch.revocations += (record.key, record.by, record.at_ns)

    def _selected(self, batch: Batch, record: Selected) -> None:
        batch.selections[record.principal, record.chat] = record.robot

    def _seeded(self, batch: Batch, record: Seeded) -> None:
        batch.seeds += (record.name_digest, record.principal)

    # ---- letters ----

    def _letter(self, batch: Batch, seq: int, kind: str, cid: CommandId, letter: Letter) -> None:
        container = letter.container
        key = self._keys.get(container) or self._key(batch, container)
        batch.letters[seq, kind] = (container, key.seal(SEAL[kind], cid, letter.content))

    def _key(self, batch: Batch, container: str) -> Key:
        key = self._keys.get(container) or batch.keys.get(container)
        if key is None:
            wrapped = self._find_key(container)
            if wrapped is None:
                key = batch.keys[container] = self._root.new_key(container)
            else:
                key = self._keys[container] = self._root.unwrap(container, wrapped)
        return key
