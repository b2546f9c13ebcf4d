"""What was said when a task was given, and where: sealed in its author's container."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.message import Chat
from rosic.core.records import Fact, Letter

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.fleet.task import TaskId
    from rosic.core.identity import PrincipalId

KIND: Final = "task-letter"
THERE: Final = b"\x01"

log = logging.getLogger("rosic.fleet")


class TaskText(msgspec.Struct, frozen=True):
    """What a task is about.

    Attributes:
        lines: What a robot is asked, step by step, without its name.
        messenger: Through which it was given.
        chat: Where its orders are shown.
        title: How people call it; empty for its first line.
    """

    lines: tuple[str, ...]
    messenger: str
    chat: Chat
    title: str = ""

    @property
    def shown(self) -> str:
        """What people read."""
        return self.title or "; ".join(self.lines)


_encode = msgspec.msgpack.Encoder().encode
_said = msgspec.msgpack.Decoder(TaskText).decode


class TaskTexts:
    """What is known of tasks besides ids and numbers."""

    def __init__(self) -> None:
        self._said: dict[TaskId, TaskText] = {}
        self._whose: dict[TaskId, PrincipalId] = {}

    def get(self, task: TaskId) -> TaskText | None:
        """Return what was said; None if its author's container was erased."""
        return self._said.get(task)

    def fact(self, task: TaskId, author: PrincipalId, said: TaskText) -> Fact:
        """Return what keeps it."""
        return Fact(kind=KIND, key=task, body=THERE, letter=Letter(author, _encode(said)))

    def forgotten(self, tasks: Iterable[TaskId]) -> tuple[Fact, ...]:
        """Return what lets it go."""
        return tuple(Fact(kind=KIND, key=task, body=b"") for task in tasks)

    def end_all(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what lets go everything that somebody has said."""
        return self.forgotten(task for task, who in self._whose.items() if who == principal)

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so; one that nobody can read any more is as good as none."""
        self._said.pop(fact.key, None)
        self._whose.pop(fact.key, None)
        if not fact.body or fact.letter is None:
            return
        try:
            self._said[fact.key] = _said(fact.letter.content)
            self._whose[fact.key] = fact.letter.container
        except msgspec.MsgspecError:
            log.warning("what was said for a task cannot be read")
