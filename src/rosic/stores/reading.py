"""From rows to records: what a gateway has to know before it takes the first message."""

from __future__ import annotations

import logging
from typing import Any

import msgspec
from sqlalchemy import Column, ColumnElement, Connection, Row, func, select

from rosic.core.identity import AuthorisationKey, CommandId
from rosic.core.order import Ending
from rosic.core.record import Enrolled, Letter, Memory, Seeded, Selected, Unfinished
from rosic.stores import tables
from rosic.stores.scribe import CARD, CLAIM, PLACED, SEAL, WORDS
from rosic.stores.sealing import Key, Root, Unreadable

log = logging.getLogger("rosic.stores")

ROLES = tuple[str, ...]


def seq_of(connection: Connection, cid: CommandId) -> int | None:
    """Return the number of a command, if there is one."""
    commands = tables.commands
    seq: int | None = connection.scalar(select(commands.c.seq).where(commands.c.cid == cid))
    return seq


def wrapped_key(connection: Connection, container: str) -> bytes | None:
    """Return the wrapped key of a container, if it has one."""
    table = tables.containers
    found: bytes | None = connection.scalar(
        select(table.c.wrapped).where(table.c.container == container)
    )
    return found


def lives(connection: Connection) -> dict[CommandId, int]:
    """Return the open commands and their numbers."""
    commands = tables.commands
    open_commands = select(commands.c.cid, commands.c.seq).where(is_open(commands.c.seq))
    return {cid: seq for cid, seq in connection.execute(open_commands)}  # noqa: C416  rows, not pairs


def is_open(seq: Column[int]) -> ColumnElement[bool]:
    """Whether a row belongs to an open command.

    Not a join: that may be done from the side of the history, which is long.
    """
    return seq.in_(select(tables.open_lives.c.seq))


def next_seq(connection: Connection) -> int:
    """Return the number of the next command."""
    newest: int | None = connection.scalar(select(func.max(tables.commands.c.seq)))
    return (newest or 0) + 1


class Reader:
    """Reads everything once, at opening.

    Attributes:
        unreadable: Letters that could not be opened though their container has a key.
    """

    def __init__(self, connection: Connection, root: Root) -> None:
        self._connection = connection
        self._root = root
        self._keys: dict[str, Key | None] = {}
        self.unreadable = 0

    def memory(self) -> Memory:
        """Return what was.

        A letter that cannot be opened is left out: whoever it names is not recognised, and
        whoever it would tell is not told. Both are safe, and the log says how many there were.
        """
        numbers = self._connection.execute(select(tables.robots)).all()
        memory = Memory(
            enrolled=self._enrolled(),
            keys=self._issued(),
            seeded=self._seeded(),
            selected=self._selected(),
            numbers={row.robot: (row.n, row.fence) for row in numbers if row.n or row.fence},
            generations={row.robot: row.generation for row in numbers if row.generation},
            unfinished=self._unfinished(),
        )
        if self.unreadable:
            log.warning("%d sealed letters could not be opened; left out", self.unreadable)
        return memory

    def _seeded(self) -> tuple[Seeded, ...]:
        rows = self._connection.execute(select(tables.seeds))
        return tuple(Seeded(name_digest=row.name_digest, principal=row.principal) for row in rows)

    def _selected(self) -> tuple[Selected, ...]:
        table = tables.selections
        rows = self._connection.execute(select(table).where(table.c.robot != ""))
        return tuple(
            Selected(principal=row.principal, chat=row.chat, robot=row.robot) for row in rows
        )

    def _unsealed(self, container: str, kind: bytes, subject: bytes, sealed: bytes) -> bytes | None:
        key = self._key(container)
        if key is None:
            return None  # the container was erased
        try:
            return key.unseal(kind, subject, sealed)
        except Unreadable:
            self.unreadable += 1
            return None

    def _key(self, container: str) -> Key | None:
        if container not in self._keys:
            wrapped = wrapped_key(self._connection, container)
            self._keys[container] = None
            if wrapped is not None:
                self._keys[container] = self._unwrapped(container, wrapped)
        return self._keys[container]

    def _unwrapped(self, container: str, wrapped: bytes) -> Key | None:
        try:
            return self._root.unwrap(container, wrapped)
        except Unreadable:
            self.unreadable += 1
            return None

    def _enrolled(self) -> tuple[Enrolled, ...]:
        found = []
        for row in self._connection.execute(
            select(tables.principals, tables.cards.c.container, tables.cards.c.sealed)
            .join(tables.cards)
            .order_by(tables.principals.c.at_ns)
        ):
            content = self._unsealed(row.container, CARD, row.principal.encode(), row.sealed)
            if content is not None:
                roles = msgspec.json.decode(row.roles, type=ROLES)
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
                scopes=msgspec.json.decode(row.scopes, type=ROLES),
                expires_ns=row.expires_ns,
                revoked_ns=row.at_ns if row.revoked_ns is None else row.revoked_ns,
            )
            for row in self._connection.execute(query.order_by(keys.c.issued_ns))
        )

    def _unfinished(self) -> tuple[Unfinished, ...]:
        commands, endings = tables.commands, tables.endings
        query = (
            select(commands, endings.c.ending)
            .where(is_open(commands.c.seq))
            .outerjoin(endings, endings.c.seq == commands.c.seq)
            .order_by(commands.c.seq)
        )
        letters = self._letters()
        return tuple(
            self._life(row, letters.get(row.seq, {})) for row in self._connection.execute(query)
        )

    def _life(self, row: Row[Any], letters: dict[str, bytes | None]) -> Unfinished:
        claimed = row.kind == "claimed"
        return Unfinished(
            cid=row.cid,
            principal=row.principal,
            robot=row.robot or "",
            skill=row.skill or "",
            ending=row.ending if claimed else Ending.REFUSED.value,
            claim=letters.get(CLAIM),
            words=letters.get(WORDS) if claimed else None,
            placed=letters.get(PLACED),
        )

    def _letters(self) -> dict[int, dict[str, bytes | None]]:
        """Return the letters of open commands by number and kind."""
        letters, commands = tables.letters, tables.commands
        query = (
            select(letters, commands.c.cid)
            .join(commands, commands.c.seq == letters.c.seq)
            .where(is_open(letters.c.seq))
        )
        found: dict[int, dict[str, bytes | None]] = {}
        for row in self._connection.execute(query):
            content = self._unsealed(row.container, SEAL[row.kind], row.cid, row.sealed)
            found.setdefault(row.seq, {})[row.kind] = content
        return found
