"""What happens to groups: we come and go, they move, people leave. Nobody gains a right by it."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.container.archive import Archive
from rosic.contracts.background_tasks import BackgroundTasks
from rosic.contracts.clock import Clock
from rosic.contracts.messenger import hearing_of
from rosic.core.i18n import joined, said
from rosic.core.identity import PrincipalId
from rosic.core.language import clean_name
from rosic.core.message import ChatEventKind, ChatKind, Outbound
from rosic.core.rate_limit import Bucket, RateLimit
from rosic.core.records import Fact
from rosic.errors import Refusal
from rosic.gateway.chat_dashboards import ChatDashboards
from rosic.gateway.components import Components
from rosic.gateway.delivery.notifier import Notifier
from rosic.gateway.delivery.sender import ChatSender, OutgoingMessage
from rosic.gateway.delivery.translation import translated
from rosic.gateway.reply_context import RobotFollowers
from rosic.gateway.transactions import Transactions

if TYPE_CHECKING:
    from collections.abc import Coroutine, Iterable

    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import Principal
    from rosic.core.message import Chat, ChatEvent
    from rosic.gateway.chat_dashboards import ChatDashboard

KIND: Final = "deaf"
RULE: Final = "rule"
"""Who ends an archive when we are put out of its chat."""
# Anybody may put a bot into a group: all groups together are greeted no faster than this.
GREETINGS: Final = RateLimit(burst=6.0, per_s=0.02)

log = logging.getLogger("rosic.groups")


class GroupQueries(msgspec.Struct, frozen=True, kw_only=True):
    """What groups are looked after with.

    Attributes:
        place: Its name, as people see it.
        admins: Returns who looks after people here.
        cards: The live cards.
    """

    rooms: Components
    followers: RobotFollowers
    chat_sender: ChatSender
    reach: Notifier
    changes: Transactions
    archive: Archive
    clock: Clock
    place: str
    admins: Callable[[], Sequence[PrincipalId]]
    cards: ChatDashboards


class GroupMembership:
    """Follows what messengers say of their chats."""

    def __init__(self, around: GroupQueries) -> None:
        self._around = around
        self._greetings = Bucket(GREETINGS, around.clock.monotonic_ns())
        self._deaf: set[str] = set()
        self._tasks: BackgroundTasks[None] = BackgroundTasks()
        around.changes.keep(KIND, self.apply)

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over of which messengers the admins know that they hear little in groups."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """It was written down that the admins know."""
        if fact.body:
            self._deaf.add(fact.key)
        else:
            self._deaf.discard(fact.key)

    def passed(self, messenger: Messenger, passing: ChatEvent) -> None:
        """Follow what has happened to a chat. Returns at once."""
        if not passing.chat.id:
            self._spawn(self._account(messenger, deaf=passing.what is ChatEventKind.DEAF))
        elif passing.what is ChatEventKind.REMOVED:
            self._around.followers.leave(messenger.name, passing.chat.id)
            self._spawn(self._end_archive(passing.chat))
        elif passing.what is ChatEventKind.LEFT:
            self._left(messenger, passing)
        elif passing.what is ChatEventKind.MOVED:
            self._moved(messenger, passing)
        elif passing.chat.kind is ChatKind.GROUP:
            self._greet(messenger, passing)

    # ---- we come and go ----

    def _greet(self, messenger: Messenger, passing: ChatEvent) -> None:
        """Say once in a new group what being there means, and tell the admins what is heard."""
        around = self._around
        found = self._known(passing)
        if found is not None:
            around.rooms.container.meet(found.id, passing.chat)
        if self._greetings.take(around.clock.monotonic_ns()):
            return
        if passing.what is ChatEventKind.ADDED:
            text = joined(" ", (greeting(around.place), heard(deaf=passing.deaf)))
            said_by = around.chat_sender.languages
            reader = said_by.of_address(passing.who) if passing.who is not None else None
            greeted = translated(Outbound(chat=passing.chat, text=text), reader)
            around.chat_sender.say(OutgoingMessage(messenger, greeted))
        group = clean_name(passing.title) or said("a group")
        if passing.what is ChatEventKind.ADDED:
            first = said("{who} put me into {group}.", who=self._who(passing), group=group)
        else:
            first = said(
                "{who} changed what I hear in {group}.", who=self._who(passing), group=group
            )
        if passing.deaf:
            rest = heard_in_part(messenger, everywhere=False)
        else:
            rest = said("I read everything there.")
        around.reach.tell(around.admins(), joined(" ", (first, rest)))

    def _who(self, passing: ChatEvent) -> str:
        """Return how the one who brought it about is called here; strangers have no name."""
        found = self._known(passing)
        return clean_name(found.name) if found is not None else said("Somebody I do not know")

    def _known(self, passing: ChatEvent) -> Principal | None:
        directory = self._around.rooms.authoriser.directory
        found = directory.at(passing.who) if passing.who is not None else None
        return None if found is None else found[0]

    async def _account(self, messenger: Messenger, *, deaf: bool) -> None:
        """Tell the admins, once, that this account hears little in groups."""
        if deaf == (messenger.name in self._deaf):
            return
        fact = Fact(kind=KIND, key=messenger.name, body=b"1" if deaf else b"")
        async with self._around.changes.turn() as turn:
            await turn.write((fact,))
        if deaf:
            self._around.reach.tell(
                self._around.admins(), heard_in_part(messenger, everywhere=True)
            )

    async def _end_archive(self, chat: Chat) -> None:
        archive = self._around.archive
        async with self._around.changes.turn() as turn:
            if archive.keeps(chat):
                await turn.write(archive.end(chat, RULE))

    # ---- they move, people leave ----

    def _left(self, messenger: Messenger, passing: ChatEvent) -> None:
        """Somebody left: what was told there because of them is told there no longer."""
        rooms, found = self._around.rooms, self._known(passing)
        if found is None:
            return
        principal = found.id
        self._around.followers.leave(messenger.name, passing.chat.id, principal)
        rooms.container.part(principal, passing.chat)

    def _moved(self, messenger: Messenger, passing: ChatEvent) -> None:
        old = passing.chat
        new = msgspec.structs.replace(old, id=passing.new_id)
        self._around.rooms.container.moved(old, new)
        self._around.followers.leave(messenger.name, old.id)
        self._spawn(self._move_archive(messenger, old, new))
        # Whoever shows it may find the old message lost before this comes to its turn.
        if (dashboard := self._around.cards.of(messenger, old)) is not None:
            self._spawn(self._move_card(dashboard, new))

    async def _move_archive(self, messenger: Messenger, old: Chat, new: Chat) -> None:
        archive = self._around.archive
        async with self._around.changes.turn() as turn:
            keeping = archive.state(old)
            if keeping is None or not archive.keeps(old):
                return
            await turn.write(archive.end(old, RULE))
            if not archive.keeps(new):
                days = keeping.switch.days
                await turn.write(archive.begin(messenger.name, new, RULE, days=days))

    async def _move_card(self, dashboard: ChatDashboard, new: Chat) -> None:
        """Go on with a live card in a new message: what was said in the old group stays there."""
        cards, pinned = self._around.cards, dashboard.pinned or dashboard.wanted_pinned
        await cards.end(dashboard)
        cards.begin(dashboard.messenger, new, dashboard.owner, dashboard.robots, pinned=pinned)

    # ---- inside ----

    def _spawn(self, work: Coroutine[None, None, None]) -> None:
        self._tasks.begin(self._follow(work))

    async def _follow(self, work: Coroutine[None, None, None]) -> None:
        try:
            await work
        except Refusal as refusal:
            log.warning("what happened to a chat was not followed: %s", refusal)
        except Exception:
            log.exception("what happened to a chat was not followed")


# ---- sentences ----


def greeting(place: str) -> str:
    """Say what we are doing in a group."""
    return said(
        "Hello. I pass commands to the robots of {place}, for people I know, each within their own"
        " rights. Being in this group gives nobody any.",
        place=place,
    )


def heard(*, deaf: bool) -> str:
    """Say how to be heard in a group."""
    if deaf:
        return said(
            "Here I hear only commands, replies to me and messages that name me:"
            " say /stop, not stop."
        )
    return said("I hear everything here, so stop is enough to stop.")


def heard_in_part(messenger: Messenger, *, everywhere: bool) -> str:
    """Say to an admin what is not heard, and how to change that where the messenger knows."""
    return hearing_of(messenger, everywhere=everywhere) or heard(deaf=True)
