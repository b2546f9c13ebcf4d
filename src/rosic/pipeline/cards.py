"""What one message in a chat shows: the lives of the orders one line gave."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.life import Face, Life
from rosic.core.order import Order, Outcome, Report, Stage

if TYPE_CHECKING:
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import CommandId, PrincipalId
    from rosic.core.message import Button, Chat


# What a robot reports while nothing can be said is not worth more.
LINES_AT_MOST = 100


class Card:
    """One message and the lives in it.

    Attributes:
        message: The platform's id, once it was sent.
        dirty: It differs from what the chat shows.
        lines: For a messenger that cannot edit: what is to be said, line by line.
        settled: Every life in it has ended and what it says is final.
    """

    __slots__ = (
        "_face", "_last_ns", "_lives", "_open", "buttons", "chat", "dirty", "lines", "message",
        "messenger", "principal", "reply_to", "untold",
    )  # fmt: skip

    def __init__(
        self,
        messenger: Messenger,
        chat: Chat,
        reply_to: str,
        principal: PrincipalId,
        face: Face,
    ) -> None:
        self.messenger = messenger
        self.chat = chat
        self.reply_to = reply_to
        self.principal = principal
        self.message = ""
        self.dirty = False
        self.lines: list[str] = []
        self.untold: list[CommandId] = []
        self.buttons: tuple[tuple[Button, ...], ...] = ()
        self._face = face
        self._lives: dict[CommandId, Life] = {}
        self._open = 0

    def add(self, order: Order, where: str, title: str, at_ns: int) -> None:
        """Show one more life, which begins now."""
        life = Life(where, title, self._face)
        self._lives[order.cid] = life
        self._open += 1
        self.step(order.cid, ACCEPTED, at_ns)

    def step(self, cid: CommandId, report: Report, at_ns: int) -> None:
        """Take a report in."""
        life = self._lives[cid]
        news = life.step(report, at_ns)
        if self.messenger.edits:
            self.dirty = True
        elif news and (report.stage is not Stage.RUNNING or len(self.lines) < LINES_AT_MOST):
            self.lines.append(life.line(report))

    def wording(self, cid: CommandId, outcome: Outcome, at_ns: int) -> str:
        """Return how an ending will read; the card does not show it yet."""
        return self._lives[cid].wording(outcome, at_ns)

    def end(self, cid: CommandId, words: str) -> None:
        """One life has ended, and that is on disk."""
        life = self._lives[cid]
        life.end(words)
        self._open -= 1
        self.untold.append(cid)
        self.dirty = True
        if not self.messenger.edits:
            self.lines.append(f"{life.where}: {words}")

    def cids(self) -> tuple[CommandId, ...]:
        """Return the orders whose lives are shown here."""
        return tuple(self._lives)

    @property
    def settled(self) -> bool:
        """Whether nothing more will be said here."""
        return not self._open

    def text(self, *, endings: bool) -> str:
        """Return the message as it should read now, with or without how lives ended."""
        return "\n".join([life.text(ending=endings) for life in self._lives.values()])


ACCEPTED = Report(Stage.ACCEPTED)
