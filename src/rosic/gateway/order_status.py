"""What one message in a chat shows: the lives of the orders one line gave."""

from __future__ import annotations

from functools import lru_cache
from operator import attrgetter
from typing import TYPE_CHECKING

from rosic.core.message import AnswerState, Button, Outbound, SendPriority
from rosic.core.messages import headed
from rosic.core.order import OrderStage, StageReport
from rosic.core.order_status import ENGLISH, OrderStatus

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import CommandId, PrincipalId
    from rosic.core.message import Chat
    from rosic.core.order import Outcome
    from rosic.core.order_status import Face, StatusTexts


# What a robot reports while nothing can be said is not worth more.
LINES_AT_MOST = 100

OUTCOME, QUESTION, FEEDBACK = SendPriority.OUTCOME, SendPriority.QUESTION, SendPriority.FEEDBACK
GOES_ON, DONE, NOT_DONE = AnswerState.GOES_ON, AnswerState.DONE, AnswerState.NOT_DONE


class OrderMessage:
    """One message and the lives in it.

    Attributes:
        where: Messenger and chat.
        in_place: The message is edited as the lives go on; otherwise they are told line by line.
        message: The platform's id, once it was sent.
        adopted: It is to take the place of ``message``, the question that was answered.
        dirty: It differs from what the chat shows.
        lines: For a messenger that cannot edit: what is to be said, line by line.
        untold: Orders that ended and whose author has not read it here.
        cids: The orders whose lives are shown here.
        about: The robot or group that was commanded, for whoever replies to it.
        buttons: Beneath it while anything in it goes on.
        after: Beneath it once all of it has ended.
        open: How many lives have not ended; at 0 nothing more will be said here.
        doubted: A message that said the ending may have arrived, or not.
        words: In the language of whoever is answered.
        cause: Id of the message or the tap that gave the orders.
    """

    __slots__ = (
        "_statuses",
        "about",
        "adopted",
        "after",
        "buttons",
        "cause",
        "chat",
        "cids",
        "dirty",
        "doubted",
        "in_place",
        "lines",
        "message",
        "messenger",
        "open",
        "principal",
        "reply_to",
        "untold",
        "where",
        "words",
    )

    def __init__(  # noqa: PLR0913 - a record of them would cost every order a call
        self,
        messenger: Messenger,
        chat: Chat,
        reply_to: str,
        principal: PrincipalId,
        words: StatusTexts = ENGLISH,
        *,
        about: str = "",
        buttons: tuple[tuple[Button, ...], ...] = (),
        after: tuple[tuple[Button, ...], ...] = (),
        cause: str = "",
    ) -> None:
        self.messenger = messenger
        self.in_place = messenger.edits
        self.chat = chat
        self.where = (messenger.name, chat.id)
        self.reply_to = reply_to
        self.principal = principal
        self.message = ""
        self.about = about
        self.adopted = False
        self.words = words
        self.dirty = self.doubted = False
        self.lines: tuple[str, ...] = ()
        self.untold: tuple[CommandId, ...] = ()
        self.cids: tuple[CommandId, ...] = ()
        self.buttons = buttons
        self.after = after
        self.cause = cause
        self._statuses: tuple[OrderStatus, ...] = ()
        self.open = 0

    @property
    def is_over_unseen(self) -> bool:
        """Every life has ended, and certainly nobody has read anything of them yet."""
        return not self.open and not self.message and not self.doubted

    def show(self, cid: CommandId, status: OrderStatus) -> None:
        """Show one more life."""
        self.cids += (cid,)
        self._statuses += (status,)
        self.open += 1
        if not self.in_place:
            self.lines += (status.line(ACCEPTED),)

    def step(self, status: OrderStatus, report: StageReport, at_ns: int) -> bool:
        """Take a report in. Return whether the chat is to hear of it.

        Not while the first message is still to be sent: that will show it.
        """
        news = status.step(report, at_ns)
        if self.in_place:
            self.dirty = True
            return self.message != "" and not self.adopted
        if news and (report.stage is not OrderStage.RUNNING or len(self.lines) < LINES_AT_MOST):
            self.lines += (status.line(report),)
        return bool(self.lines)

    def end(self, cid: CommandId, status: OrderStatus, words: str) -> None:
        """One life has ended, and that is on disk."""
        status.end(words)
        self.open -= 1
        self.untold += (cid,)
        self.dirty = True
        if not self.in_place:
            self.lines += (headed(status.where, words),)

    @property
    def ending(self) -> bool:
        """An ending is on its way to the disk, or there."""
        return any(map(_RESULT, self._statuses))

    @property
    def weight(self) -> SendPriority:
        """How important it is now: more once one of its lives has ended."""
        if self.untold:
            return OUTCOME
        return FEEDBACK if self.message and not self.adopted else QUESTION

    def read(self, *, endings: bool) -> Outbound:
        """Return the message as it should read now: from here on only what is newer is to be shown.

        Args:
            endings: With how lives ended.
        """
        self.dirty = not endings and bool(self.untold)
        if len(self._statuses) == 1:
            text = self._statuses[0].text(ending=endings)
        else:
            text = "\n".join([status.text(ending=endings) for status in self._statuses])
        if self.open or (self.untold and not endings):
            state = GOES_ON
        else:
            state = DONE if all(map(_GOOD, self._statuses)) else NOT_DONE
        return Outbound(  # its weight is `weight`, without a call on the way of every order
            chat=self.chat,
            text=text,
            reply_to=self.reply_to,
            buttons=self.buttons if self.open else self.after if endings else (),
            weight=OUTCOME
            if self.untold
            else FEEDBACK
            if self.message and not self.adopted
            else QUESTION,
            cause=self.cause,
            state=state,
        )

    def stands_in(self, message: str) -> None:
        """Take in which message shows it."""
        self.message = message

    def adopt(self, question: str) -> None:
        """Take the place of a question that was answered, if there is one."""
        self.message, self.adopted = question, question != ""

    def take_place(self) -> str:
        """Return the question whose place it takes now; if that fails it has its own message."""
        question, self.message, self.adopted = self.message, "", False
        return question

    def doubt(self) -> None:
        """It may stand in the chat already, for ever."""
        self.doubted = True

    def not_edited(self, *, gone: bool) -> None:
        """It is to be shown all the same: in a new message if a person has deleted the old one."""
        self.dirty = True
        if gone:
            self.message = ""

    def line_said(self) -> None:
        """The first of its lines was said."""
        self.lines = self.lines[1:]

    def settle(self) -> tuple[CommandId, ...]:
        """Return whose endings count as told now; nothing of it is left to be said."""
        self.dirty, self.lines = False, ()
        told, self.untold = self.untold, ()
        return told


_RESULT = attrgetter("result")
_GOOD = attrgetter("good")
ACCEPTED = StageReport(OrderStage.ACCEPTED)


@lru_cache(maxsize=1024)
def stop_button(name: str) -> tuple[tuple[Button, ...], ...]:
    """Return the row under a life: a stop is never bound to anybody, nor used up."""
    return ((Button("STOP", f"stop {name}", f"stop {name}"),),)


class AwaitedOrder(OrderStatus):
    """A life whose end somebody waits for: told once it is on disk, with what the robot did."""

    __slots__ = ("_outcome", "over")

    def __init__(
        self, where: str, title: str, face: Face, at_ns: int, words: StatusTexts = ENGLISH
    ) -> None:
        super().__init__(where, title, face, at_ns, words)
        self.over: Callable[[Outcome], None] = _unheard
        self._outcome: Outcome | None = None

    def wording(self, outcome: Outcome, at_ns: int) -> str:
        """Return how an outcome reads, and remember it."""
        self._outcome = outcome
        return super().wording(outcome, at_ns)

    def end(self, words: str) -> None:
        """The life is over, and that is on disk."""
        super().end(words)
        if self._outcome is not None:
            self.over(self._outcome)


def _unheard(_outcome: Outcome) -> None:
    return None
