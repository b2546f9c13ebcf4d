"""What robots say to each other, mirrored to chats: a few lines now and then, with a button."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.i18n import joined
from rosic.core.message import Button, Outbound, SendPriority
from rosic.core.time_units import HOUR_NS
from rosic.features.robot_to_robot import messages as words
from rosic.gateway.delivery.sender import OutgoingMessage
from rosic.gateway.delivery.translation import translated

if TYPE_CHECKING:
    from rosic.authoriser.authoriser import Authoriser
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.features.robot_to_robot.permissions import PeerPermissions
    from rosic.features.robot_to_robot.subscriptions import SubscriberChat, Subscriptions
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.delivery.sender import ChatSender

EVERY_S: Final = 5.0
LINES_AT_MOST: Final = 12
BUTTONS_LIVE_NS: Final = HOUR_NS


class _Line(NamedTuple):
    """What there is to say of one topic: the newest, and how much came before it."""

    text: str
    before: int


class _Page(NamedTuple):
    who: PrincipalId
    where: SubscriberChat
    lines: dict[tuple[RobotId, str], _Line]


class ConversationDigests:
    """Collects, and says at most one message per chat in `EVERY_S`: the newest of each topic."""

    def __init__(
        self,
        post: Subscriptions,
        rights: PeerPermissions,
        authoriser: Authoriser,
        chat_sender: ChatSender,
        reach: Notifier,
    ) -> None:
        self._post = post
        self._rights = rights
        self._authoriser = authoriser
        self._chat_sender = chat_sender
        self._messengers = {messenger.name: messenger for messenger in reach.messengers}
        self._may_read = reach.may_read
        self._pages: dict[str, _Page] = {}

    def note(self, robot: RobotId, topic: str, text: str) -> None:
        """Let those who follow a robot read something with the next digest.

        Args:
            robot: Who said it; whoever may not read it hears nothing.
            topic: On which topic; empty for what only those read who follow all of it.
            text: What they read; the newest on a topic stands for all.
        """
        for _, who, where in self._post.chats(robot, topic):
            place = f"{who}\0{where.messenger}\0{where.chat.id}\0{where.chat.topic}"
            page = self._pages.setdefault(place, _Page(who, where, {}))
            before = page.lines.pop((robot, topic), None)
            page.lines[robot, topic] = _Line(text, 0 if before is None else before.before + 1)

    def say(self) -> None:
        """Say what was collected."""
        pages, self._pages = self._pages, {}
        for page in pages.values():
            messenger = self._messengers.get(page.where.messenger)
            if messenger is not None and self._may_read(page.who, page.where.chat):
                self._say(messenger, page)

    def _say(self, messenger: Messenger, page: _Page) -> None:
        kept = {k: line for k, line in page.lines.items() if self._rights.may(page.who, k[0])}
        newest = list(kept.items())[-LINES_AT_MOST:]
        if not newest:
            return
        text = joined("\n", [words.digest_line(line.text, line.before) for _, line in newest])
        robots = dict.fromkeys(robot for (robot, _), _ in newest)
        row = tuple(
            self._authoriser.buttons.issue(
                Button(words.quiet_label(self._rights.shown(robot)), f"/quiet {robot}"),
                page.who,
                page.where.chat.id,
                lifetime_ns=BUTTONS_LIVE_NS,
                still=True,
            )
            for robot in list(robots)[:3]
            if self._rights.operates(page.who, robot)
        )
        outbound = Outbound(
            chat=page.where.chat, text=text, buttons=(row,) if row else (), weight=SendPriority.IDLE
        )
        plain = translated(outbound, self._chat_sender.languages.of(page.who))
        self._chat_sender.say(OutgoingMessage(messenger, plain))
