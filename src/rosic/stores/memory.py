"""The record without a disk: for tests and ``rosic demo``. Forgotten when the process ends."""

from __future__ import annotations

from collections import deque
from itertools import islice
from typing import TYPE_CHECKING, Any, Final

import msgspec
from msgspec.structs import replace

from rosic.core.history import STOPPED, HistoryEntry, HistoryQuery, with_stops
from rosic.core.i18n import said
from rosic.core.order import OrderEnding
from rosic.core.records import (
    APART,
    Claimed,
    Concluded,
    Decided,
    Enrolled,
    Fact,
    KeyIssued,
    KeyRevoked,
    Letter,
    Memory,
    Placed,
    Record,
    Refused,
    Resumed,
    Seeded,
    Selected,
    Stopped,
    Told,
    Unfinished,
)
from rosic.errors import Repeated, StoreFault
from rosic.stores.fact_index import by_kind

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rosic.core.identity import AuthorisationKey, CommandId, KeyId, PrincipalId
    from rosic.core.robot.profile import RobotId


# ---- commands that are over ----

COMMANDS_KEPT: Final = 10_000


class MemoryHistory:
    """Keeps the newest commands, also those whose author has heard how they ended."""

    def __init__(self) -> None:
        self._asked: deque[Claimed | Refused | Resumed] = deque(maxlen=COMMANDS_KEPT)
        self._came: dict[CommandId, Concluded] = {}
        self._stops: deque[Stopped] = deque(maxlen=COMMANDS_KEPT)

    def _keep_past(self, record: Claimed | Refused | Resumed) -> None:
        if len(self._asked) == COMMANDS_KEPT:
            self._came.pop(self._asked[0].cid, None)
        self._asked.append(record)

    def _forget_words(self, container: str) -> None:
        """Read no more what one person's commands said, up to now."""
        kept = (_without(record, container) for record in self._asked)
        self._asked = deque(kept, maxlen=COMMANDS_KEPT)
        self._came = {cid: _ended_without(c, container) for cid, c in self._came.items()}

    async def history(self, query: HistoryQuery) -> tuple[HistoryEntry, ...]:
        """Return commands, the newest first, at most as many as are asked for."""
        found: list[HistoryEntry] = []
        for record in reversed(self._asked):
            if len(found) >= query.limit:
                break
            if query.cid not in {b"", record.cid}:
                continue
            entry = self._entry(record)
            ours = query.principal in {"", entry.principal} and query.robot in {"", entry.robot}
            if ours and entry.at_ns >= query.since_ns:
                found.append(entry)
        if query.cid:
            return tuple(found)
        return with_stops(found, islice(self._stopped_by(query), query.limit), query.limit)

    def _stopped_by(self, query: HistoryQuery) -> Iterator[HistoryEntry]:
        for stop in reversed(self._stops):
            ours = query.principal in {"", stop.principal} and query.robot in {"", stop.robot}
            if ours and stop.at_ns >= query.since_ns:
                yield HistoryEntry(
                    principal=stop.principal, kind=STOPPED, at_ns=stop.at_ns, robot=stop.robot
                )

    def _entry(self, record: Claimed | Refused | Resumed) -> HistoryEntry:
        came = self._came.get(record.cid)
        ended = "" if came is None else came.ending
        return HistoryEntry(
            principal=record.principal,
            kind=type(record).__name__.lower(),
            at_ns=record.accepted_ns if isinstance(record, Claimed) else record.at_ns,
            robot="" if isinstance(record, Refused) else record.robot,
            skill=record.skill if isinstance(record, Claimed) else "",
            n=record.n if isinstance(record, Claimed) else 0,
            outcome=record.code if isinstance(record, Refused) else ended,
            ended_ns=None if came is None else came.at_ns,
            letter=None if isinstance(record, Resumed) else _content(record.letter),
            words=None if came is None else _content(came.letter),
        )


def _content(letter: Letter | None) -> bytes | None:
    return None if letter is None else letter.content


def _without(record: Claimed | Refused | Resumed, container: str) -> Claimed | Refused | Resumed:
    if isinstance(record, Resumed) or record.letter is None:
        return record
    return replace(record, letter=None) if record.letter.container == container else record


def _ended_without(record: Concluded, container: str) -> Concluded:
    if record.letter is None or record.letter.container != container:
        return record
    return replace(record, letter=None)


# ---- the store ----

IDS_MAX = 200_000
OPEN_ORDERS_MAX = 100_000
NO_NUMBERS = (0, 0)
SETTLING = frozenset((Claimed, Refused, Resumed))
DECISIONS_MAX = 10_000


class MemoryStore(MemoryHistory):
    """The same rules as the record on disk. Opening again gives what was written before.

    Writing never suspends, so a caller in a hot loop loses no turn.

    Args:
        ids_max: A duplicate is recognised while at most this many commands came after it, and
            forgotten after at most twice as many.
        open_orders_max: Commands whose end was not told, before further ones are refused.
        decisions_max: Administrative acts that are kept; the oldest are forgotten first.
    """

    def __init__(
        self,
        *,
        ids_max: int = IDS_MAX,
        open_orders_max: int = OPEN_ORDERS_MAX,
        decisions_max: int = DECISIONS_MAX,
    ) -> None:
        super().__init__()
        self._ids_max = ids_max
        self._open_orders_max = open_orders_max
        self._open = False
        # Two generations of ids: the older one is dropped whole, so no id costs a search.
        self._ids: set[CommandId] = set()
        self._older: set[CommandId] = set()
        # What a life still lacks when its end is not told: three tables,
        # so that a claim costs one entry.
        self._open_orders: dict[CommandId, Claimed | Refused] = {}
        self._endings: dict[CommandId, Concluded] = {}
        self._places: dict[CommandId, Letter] = {}
        self._enrolled: dict[PrincipalId, Enrolled] = {}
        self._keys: dict[KeyId, AuthorisationKey] = {}
        self._revoked: dict[KeyId, int] = {}
        self._seeded: dict[bytes, Seeded] = {}
        self._selected: dict[tuple[PrincipalId, bytes], Selected] = {}
        self._numbers: dict[RobotId, tuple[int, int]] = {}
        self._generations: dict[RobotId, int] = {}
        self._facts: dict[tuple[str, str], Fact] = {}
        self._decisions: deque[Decided] = deque(maxlen=decisions_max)
        self._take: dict[type, Callable[[Any], None]] = {
            Claimed: self._claimed,
            Refused: self._refused,
            Concluded: self._concluded,
            Placed: self._placed,
            Told: self._finish,
            Stopped: self._stopped,
            Resumed: self._resumed,
            Enrolled: self._enrol,
            KeyIssued: self._key_issued,
            KeyRevoked: self._key_revoked,
            Selected: self._select,
            Seeded: self._seed,
            Fact: self._fact,
            Decided: self._decisions.append,
        }

    async def open(self) -> Memory:
        """Return what was written before, by this very object."""
        self._open = True
        return Memory(
            enrolled=tuple(self._enrolled.values()),
            keys=tuple(self._with_revocation(key) for key in self._keys.values()),
            seeded=tuple(self._seeded.values()),
            selected=tuple(self._selected.values()),
            numbers=dict(self._numbers),
            generations=dict(self._generations),
            unfinished=tuple(
                self._unfinished(open_order) for open_order in self._open_orders.values()
            ),
            facts=by_kind(fact for fact in self._facts.values() if fact.kind not in APART),
        )

    async def close(self) -> None:
        """Take no more writes until opened again."""
        self._open = False

    async def write(self, *records: Record) -> None:
        """Write all or none, at once.

        Raises:
            Repeated: As in ``contracts.store``.
            StoreFault: Closed, or too many commands whose end was never told.
        """
        if not self._open:
            raise StoreFault(said("The record is closed."))
        self._refuse_repeated(records)
        take = self._take
        for record in records:
            take[type(record)](record)

    def keep(self, record: Record, then: Callable[[], None]) -> None:
        """Write at once, and call ``then``."""
        if type(record) in SETTLING:
            self.note(record)
        elif self._open:
            self._take[type(record)](record)
        then()

    def note(self, *records: Record) -> None:
        """Write at once; what cannot be written is dropped."""
        if not self._open:
            return
        take = self._take
        if not SETTLING.isdisjoint(map(type, records)):
            try:
                self._refuse_repeated(records)
            except (Repeated, StoreFault):
                return
        for record in records:
            take[type(record)](record)

    async def decisions(self, limit: int) -> tuple[Decided, ...]:
        """Return the newest administrative acts, the newest first; at most so many.

        Raises:
            StoreFault: The record is closed.
        """
        if not self._open:
            raise StoreFault(said("The record is closed."))
        return tuple(islice(reversed(self._decisions), max(limit, 0)))

    async def forget_decisions(self, before_ns: int) -> int:
        """Forget administrative acts from before a time, but never the newest; return how many."""
        count = 0
        while len(self._decisions) > 1 and self._decisions[0].at_ns < before_ns:
            self._decisions.popleft()
            count += 1
        return count

    async def facts(self, kind: str, after: str, limit: int) -> tuple[Fact, ...]:
        """Return at most so many facts of a kind, by key, from behind a key on.

        Raises:
            StoreFault: The record is closed.
        """
        self._check_open()
        keys = sorted(key for of, key in self._facts if of == kind and key > after)
        return tuple(self._facts[kind, key] for key in keys[:limit])

    async def container_facts(self, container: str) -> tuple[Fact, ...]:
        """Return everything that belongs to a container; of commands, those that are not settled.

        Raises:
            StoreFault: The record is closed.
        """
        self._check_open()
        cards = (
            Fact(kind="card", key=who, body=msgspec.json.encode(of.roles), letter=of.letter)
            for who, of in self._enrolled.items()
            if of.letter.container == container
        )
        facts = (
            fact
            for fact in self._facts.values()
            if owner(fact.letter) == container and fact.kind not in APART
        )
        found = [*cards, *facts]
        for cid, open_order in self._open_orders.items():
            if open_order.principal == container:
                ending = self._endings.get(cid)
                words = None if ending is None else ending.letter
                letters = (open_order.letter, words, self._places.get(cid))
                body = msgspec.msgpack.encode({"is": type(open_order).__name__.lower()})
                kinds = zip(("command", "outcome", "message"), letters, strict=True)
                found += [
                    Fact(kind=kind, key=cid.hex(), body=body, letter=letter)
                    for kind, letter in kinds
                    if letter is not None
                ]
        return tuple(found)

    async def containers(self) -> tuple[str, ...]:
        """Return whose containers hold something.

        Raises:
            StoreFault: The record is closed.
        """
        self._check_open()
        letters = (
            *(record.letter for record in self._enrolled.values()),
            *(fact.letter for fact in self._facts.values()),
            *(open_order.letter for open_order in self._open_orders.values()),
        )
        return tuple(sorted({name for letter in letters if (name := owner(letter))}))

    def _check_open(self) -> None:
        if not self._open:
            raise StoreFault(said("The record is closed."))

    async def shred(self, container: str) -> None:
        """Forget the personal content of one container for good."""
        self._enrolled = {
            principal: record
            for principal, record in self._enrolled.items()
            if record.letter.container != container
        }
        self._forget_words(container)
        without_letters(self._open_orders, container)
        without_letters(self._endings, container)
        without_letters(self._facts, container)
        self._places = {
            cid: letter for cid, letter in self._places.items() if letter.container != container
        }

    def _refuse_repeated(self, records: tuple[Record, ...]) -> None:
        """Look before anything is changed, so that a call is written whole or not at all."""
        young, older = self._ids, self._older
        fresh: set[CommandId] | None = None
        for record in records:
            if type(record) in SETTLING:
                cid = record.cid  # type: ignore[union-attr]  # the three kinds that have one
                if cid in young or cid in older or (fresh is not None and cid in fresh):
                    raise Repeated("This was already settled.")
                if len(self._open_orders) >= self._open_orders_max:
                    raise StoreFault(said("The record is full. Nothing was written."))
                if len(records) > 1:
                    fresh = fresh or set()
                    fresh.add(cid)

    def _remember(self, cid: CommandId) -> None:
        if len(self._ids) >= self._ids_max:
            self._older = self._ids
            self._ids = set()
        self._ids.add(cid)

    def _claimed(self, record: Claimed) -> None:
        cid, asked = record.cid, self._asked
        if len(asked) == COMMANDS_KEPT:  # as `_keep_past`, without the call
            self._came.pop(asked[0].cid, None)
        asked.append(record)
        self._remember(cid)
        self._open_orders[cid] = record
        robot = record.robot
        n, fence = self._numbers.get(robot, NO_NUMBERS)
        if record.n > n and record.fence >= fence:
            self._numbers[robot] = (record.n, record.fence)
        elif record.n > n or record.fence > fence:
            self._numbers[robot] = (max(n, record.n), max(fence, record.fence))
        if record.stop_generation > self._generations.get(robot, 0):
            self._generations[robot] = record.stop_generation

    def _refused(self, record: Refused) -> None:
        self._keep_past(record)
        self._remember(record.cid)
        if record.letter is not None:
            self._open_orders[record.cid] = record

    def _concluded(self, record: Concluded) -> None:
        cid = record.cid
        self._came.setdefault(cid, record)
        if record.letter is None:
            self._finish(record)
        elif cid in self._open_orders:
            self._endings.setdefault(cid, record)

    def _placed(self, record: Placed) -> None:
        if record.cid in self._open_orders:
            self._places[record.cid] = record.letter

    def _finish(self, record: Told | Concluded) -> None:
        cid = record.cid
        self._open_orders.pop(cid, None)
        self._endings.pop(cid, None)
        self._places.pop(cid, None)

    def _stopped(self, record: Stopped) -> None:
        if not record.repeated:
            self._stops.append(record)
        self._raise_generation(record.robot, record.generation)

    def _resumed(self, record: Resumed) -> None:
        self._keep_past(record)
        self._remember(record.cid)
        self._raise_generation(record.robot, record.generation)

    def _raise_generation(self, robot: RobotId, generation: int) -> None:
        if generation > self._generations.get(robot, 0):
            self._generations[robot] = generation

    def _enrol(self, record: Enrolled) -> None:
        self._enrolled[record.principal] = record

    def _key_issued(self, record: KeyIssued) -> None:
        self._keys.setdefault(record.key.id, record.key)

    def _key_revoked(self, record: KeyRevoked) -> None:
        self._revoked.setdefault(record.key, record.at_ns)

    def _with_revocation(self, key: AuthorisationKey) -> AuthorisationKey:
        at_ns = self._revoked.get(key.id)
        if at_ns is None or key.revoked_ns is not None:
            return key
        return msgspec.structs.replace(key, revoked_ns=at_ns)

    def _select(self, record: Selected) -> None:
        place = (record.principal, record.chat)
        if record.robot:
            self._selected[place] = record
        else:
            self._selected.pop(place, None)

    def _seed(self, record: Seeded) -> None:
        self._seeded.setdefault(record.name_digest, record)

    def _fact(self, record: Fact) -> None:
        place = (record.kind, record.key)
        if record.body:
            self._facts[place] = record
        else:
            self._facts.pop(place, None)

    def _unfinished(self, open_order: Claimed | Refused) -> Unfinished:
        """Say what a life still lacks; a refusal names no robot and no skill."""
        claim, placed = content(open_order.letter), content(self._places.get(open_order.cid))
        if isinstance(open_order, Refused):
            return Unfinished(
                cid=open_order.cid,
                principal=open_order.principal,
                robot="",
                skill="",
                ending=OrderEnding.REFUSED.value,
                claim=claim,
                words=None,
                placed=placed,
            )
        ending = self._endings.get(open_order.cid)
        return Unfinished(
            cid=open_order.cid,
            principal=open_order.principal,
            robot=open_order.robot,
            skill=open_order.skill,
            ending=None if ending is None else ending.ending,
            claim=claim,
            words=None if ending is None else content(ending.letter),
            placed=placed,
        )


def content(letter: Letter | None) -> bytes | None:
    """Return what a letter says, if there is one."""
    return None if letter is None else letter.content


def owner(letter: Letter | None) -> str:
    """Return whose container a letter belongs to; empty if there is none."""
    return "" if letter is None else letter.container


def without_letters(table: dict[Any, Any], container: str) -> None:
    """Take the letters of one container out of records that stay."""
    for cid, record in table.items():
        if record.letter is not None and record.letter.container == container:
            table[cid] = msgspec.structs.replace(record, letter=None)
