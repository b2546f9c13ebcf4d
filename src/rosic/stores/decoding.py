"""From rows to records: what a gateway has to know before it takes the first message."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

import msgspec
from sqlalchemy import (
    Column,
    ColumnElement,
    Connection,
    Row,
    Select,
    exists,
    func,
    or_,
    select,
    union_all,
)

from rosic.core.identity import AuthorisationKey, CommandId
from rosic.core.order import OrderEnding
from rosic.core.records import APART, Enrolled, Fact, Letter, Memory, Seeded, Selected, Unfinished
from rosic.errors import ConfigurationError
from rosic.stores import tables
from rosic.stores.encoding import CARD, CLAIM, FACT, PLACED, WORDS, DatabasePosition
from rosic.stores.encryption import ContainerKey, DecryptionError, RootKey, place_of_fact
from rosic.stores.fact_index import by_kind

if TYPE_CHECKING:
    from collections.abc import Iterator

log = logging.getLogger("rosic.stores")

ROLES = tuple[str, ...]
KEY_SHOWN = 40


def unreadable(column: Any, key: object) -> ConfigurationError:  # noqa: ANN401 - of any kind
    """Say which value of the record is none that ROSIC has written."""
    named = key.hex() if isinstance(key, bytes) else str(key)
    return ConfigurationError(
        f"The record holds a value that cannot be read: {column.name} of {named[:KEY_SHOWN]!r} in "
        f"its table {column.table.name}.",
        hint="Put rosic.db back from your copy, together with record.mark. Nothing was started.",
    )


def checked(connection: Connection, query: Select[Any], key: object = None) -> Iterator[Row[Any]]:
    """Yield rows whose values are of the types of their columns: SQLite keeps whatever it is given.

    Args:
        connection: To the record.
        query: Of columns, with or without labels.
        key: Whose rows they are; None: the first value of each row says so.

    Raises:
        ConfigurationError: One is not.
    """
    columns = [getattr(column, "element", column) for column in query.selected_columns]
    kinds = [(column, column.type.python_type) for column in columns]
    for row in connection.execute(query):
        for value, (column, kind) in zip(row, kinds, strict=True):
            if value is not None and not isinstance(value, kind):
                raise unreadable(column, row[0] if key is None else key)
        yield row


def _list(column: Column[Any], key: str, text: str) -> tuple[str, ...]:
    """Read a list of words.

    Raises:
        ConfigurationError: It is none.
    """
    try:
        return msgspec.json.decode(text, type=ROLES)
    except msgspec.MsgspecError as wrong:
        raise unreadable(column, key) from wrong


def wrapped_key(connection: Connection, container: str) -> bytes | None:
    """Return the wrapped key of a container, if it has one."""
    table = tables.containers
    query = select(table.c.wrapped).where(table.c.container == container)
    found: bytes | None = next((row.wrapped for row in checked(connection, query, container)), None)
    return found


def standing(connection: Connection) -> DatabasePosition:
    """Return where the database stands.

    The next number is never one below which it was sifted: a number that was given to a call that
    was not written leaves no command behind, but may have been counted in sifting.
    """
    commands, sifted = tables.commands, tables.sifted
    newest: int | None = connection.scalar(select(func.max(commands.c.seq)))
    below = max((row.below for row in checked(connection, select(sifted.c.below))), default=0)
    open_commands = select(commands.c.cid, commands.c.seq).where(is_open(commands.c.seq))
    open_orders = {row.cid: row.seq for row in checked(connection, open_commands)}
    return DatabasePosition(open_orders, below, max((newest or 0) + 1, below))


def is_open(seq: Column[int]) -> ColumnElement[bool]:
    """Whether a row belongs to an open command.

    Not a join: that may be done from the side of the history, which is long.
    """
    commands, endings, tellings = tables.commands, tables.endings, tables.tellings
    number = commands.c.seq
    told = exists().where(tellings.c.seq == number)
    ended_silently = exists().where(endings.c.seq == number, endings.c.container.is_(None))
    unsifted = select(number).where(
        number >= select(func.coalesce(func.max(tables.sifted.c.below), 0)).scalar_subquery(),
        or_(commands.c.kind == "claimed", commands.c.container.is_not(None)),
        ~told,
        ~ended_silently,
    )
    return seq.in_(union_all(select(tables.open_orders_of.c.seq), unsifted.correlate(None)))


class RecordDecoder:
    """Reads everything once, at opening.

    Attributes:
        unreadable: Letters that could not be opened though their container has a key.
    """

    def __init__(self, connection: Connection, root: RootKey) -> None:
        self._connection = connection
        self._root = root
        self._keys: dict[str, ContainerKey | None] = {}
        self.unreadable = 0

    def memory(self) -> Memory:
        """Return what was.

        A letter that cannot be opened is left out: whoever it names is not recognised, and
        whoever it would tell is not told. Both are safe, and the log says how many there were.
        """
        numbers = list(checked(self._connection, select(tables.robots)))
        memory = Memory(
            enrolled=self._enrolled(),
            keys=self._issued(),
            seeded=self._seeded(),
            selected=self._selected(),
            numbers={row.robot: (row.n, row.fence) for row in numbers if row.n or row.fence},
            generations={row.robot: row.generation for row in numbers if row.generation},
            unfinished=self._unfinished(),
            facts=self._facts(),
        )
        if self.unreadable:
            log.warning("%d sealed letters could not be opened; left out", self.unreadable)
        return memory

    def _seeded(self) -> tuple[Seeded, ...]:
        rows = checked(self._connection, select(tables.seeds))
        return tuple(Seeded(name_digest=row.name_digest, principal=row.principal) for row in rows)

    def _selected(self) -> tuple[Selected, ...]:
        table = tables.selections
        rows = checked(self._connection, select(table).where(table.c.robot != ""))
        return tuple(
            Selected(principal=row.principal, chat=row.chat, robot=row.robot) for row in rows
        )

    def _facts(self) -> dict[str, tuple[Fact, ...]]:
        """Return what is so, in the order in which it was first written."""
        facts = tables.facts.c
        rows = checked(
            self._connection,
            select(facts.kind, facts.key, facts.body, facts.container, facts.sealed)
            .where(facts.kind.not_in(APART))
            .order_by(facts.id),
        )
        return by_kind(
            Fact(kind=row.kind, key=row.key, body=row.body)
            if row.container is None
            else self._fact(row.kind, row.key, row.body, row.container, row.sealed)
            for row in rows
        )

    def _fact(self, kind: str, key: str, body: bytes, container: str, sealed: bytes) -> Fact:
        content = self._unsealed(container, FACT, place_of_fact(kind, key), sealed)
        letter = None if content is None else Letter(container, content)
        return Fact(kind=kind, key=key, body=body, letter=letter)

    def _unsealed(self, container: str, kind: bytes, subject: bytes, sealed: bytes) -> bytes | None:
        key = self._key(container)
        if key is None:
            return None  # the container was erased
        try:
            return key.unseal(kind, subject, sealed)
        except DecryptionError:
            self.unreadable += 1
            return None

    def _key(self, container: str) -> ContainerKey | None:
        if container not in self._keys:
            wrapped = wrapped_key(self._connection, container)
            self._keys[container] = None
            if wrapped is not None:
                self._keys[container] = self._unwrapped(container, wrapped)
        return self._keys[container]

    def _unwrapped(self, container: str, wrapped: bytes) -> ContainerKey | None:
        try:
            return self._root.unwrap(container, wrapped)
        except DecryptionError:
            self.unreadable += 1
            return None

    def _enrolled(self) -> tuple[Enrolled, ...]:
        found = []
        for row in checked(
            self._connection,
            select(tables.principals, tables.cards.c.container, tables.cards.c.sealed)
            .join(tables.cards)
            .order_by(tables.principals.c.at_ns),
        ):
            content = self._unsealed(row.container, CARD, row.principal.encode(), row.sealed)
            if content is not None:
                roles = _list(tables.principals.c.roles, row.principal, row.roles)
                letter = Letter(row.container, content)
                found.append(
                    Enrolled(principal=row.principal, roles=roles, at_ns=row.at_ns, letter=letter)
                )
        return tuple(found)

    def _issued(self) -> tuple[AuthorisationKey, ...]:
        keys, revocations = tables.keys, tables.revocations
        query = select(keys, revocations.c.at_ns).outerjoin(
            revocations, revocations.c.key == keys.c.key
        )
        return tuple(
            AuthorisationKey(
                id=row.key,
                principal=row.principal,
                issuer=row.issuer,
                issued_ns=row.issued_ns,
                scopes=_list(keys.c.scopes, row.key, row.scopes),
                expires_ns=row.expires_ns,
                revoked_ns=row.at_ns if row.revoked_ns is None else row.revoked_ns,
            )
            for row in checked(self._connection, query.order_by(keys.c.issued_ns))
        )

    def _unfinished(self) -> tuple[Unfinished, ...]:
        commands, endings, places = tables.commands, tables.endings, tables.places
        query = (
            select(
                commands,
                endings.c.ending,
                endings.c.container.label("words_container"),
                endings.c.sealed.label("words_sealed"),
                places.c.container.label("placed_container"),
                places.c.sealed.label("placed_sealed"),
            )
            .where(is_open(commands.c.seq))
            .outerjoin_from(commands, endings, endings.c.seq == commands.c.seq)
            .outerjoin(places, places.c.seq == commands.c.seq)
            .order_by(commands.c.seq)
        )
        return tuple(self._open_order(row) for row in checked(self._connection, query))

    def _open_order(self, row: Row[Any]) -> Unfinished:
        claimed = row.kind == "claimed"
        claim = self._letter(row.container, CLAIM, row.cid, row.sealed)
        words = self._letter(row.words_container, WORDS, row.cid, row.words_sealed)
        return Unfinished(
            cid=row.cid,
            principal=row.principal,
            robot=row.robot or "",
            skill=row.skill or "",
            ending=row.ending if claimed else OrderEnding.REFUSED.value,
            claim=claim,
            words=words if claimed else None,
            placed=self._letter(row.placed_container, PLACED, row.cid, row.placed_sealed),
        )

    def _letter(
        self, container: str | None, kind: bytes, cid: CommandId, sealed: bytes | None
    ) -> bytes | None:
        if container is None or sealed is None:
            return None
        return self._unsealed(container, kind, cid, sealed)
