"""Channels as windows: a live card of some robots, for reading. Nothing comes in through one.

Putting a bot into a channel shows nothing there, and asks nobody anything: anybody may do it. An
admin of this place who may give rights opens the window, for the robots named, with their own eyes:
what they may see no longer, it shows no longer. When one of them has put it there, they are
asked. There is no button under it, and no person's name on it.
"""

from __future__ import annotations

import logging
from collections import OrderedDict
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.contracts.background_tasks import BackgroundTasks
from rosic.core.i18n import joined, said
from rosic.core.language import clean_name
from rosic.core.message import Button, Chat, ChatEventKind, ChatKind
from rosic.core.policy.scope import FLEET, GRANT
from rosic.core.rate_limit import Bucket, RateLimit
from rosic.core.records import Decided
from rosic.core.time_units import DAY_S
from rosic.errors import NotPermitted, NotUnderstood, Refusal
from rosic.gateway.button_rows import rows
from rosic.gateway.chat_dashboards import key_of
from rosic.gateway.commands import Reply, check_private
from rosic.gateway.delivery.notifier import Notification

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.message import ChatEvent
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.chat_dashboards import ChatDashboards
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.transactions import Transactions

VERB: Final = "channel"
KNOWN_AT_MOST: Final = 100
STRANGE_AT_MOST: Final = 20
"""Channels into which somebody else put us; kept apart, so that no stranger has ours forgotten."""
OFFERED_AT_MOST: Final = 11
ASKED_AT_MOST: Final = 10
"""Channels that the list offers to ask about."""
# Whoever puts us into channels fast is asked about the last of them by the list alone.
QUESTIONS: Final = RateLimit(burst=6.0, per_s=0.02)
GOOD_FOR_S: Final = float(DAY_S)
ALL: Final = "all"
CLOSE: Final = "close"

log = logging.getLogger("rosic.groups")


class KnownChannel(NamedTuple):
    """A channel that a messenger has told of.

    Attributes:
        by: Who put us there, as they are called here; empty where that is not known any more.
    """

    messenger: Messenger
    chat: Chat
    title: str = ""
    by: str = ""


class ChannelDisplays:
    """Every channel that this place may show robots in."""

    def __init__(
        self,
        live: ChatDashboards,
        rooms: Components,
        changes: Transactions,
        reach: Notifier,
        clock: Clock,
    ) -> None:
        self._live = live
        self._rooms = rooms
        self._changes = changes
        self._reach = reach
        self._clock = clock
        # Only what a messenger has called a channel is one: no id that somebody writes is trusted.
        self._known: OrderedDict[str, KnownChannel] = OrderedDict()
        self._strange: OrderedDict[str, KnownChannel] = OrderedDict()
        self._questions = Bucket(QUESTIONS, clock.monotonic_ns())
        # By messenger and chat of an admin: the question that stands there, so that it is one.
        self._asked: dict[tuple[str, str], str] = {}
        # Their card is being ended; should that not be written, they are not shown all the same.
        self._left: set[str] = set()
        self._tasks: BackgroundTasks[None] = BackgroundTasks()

    def register(self, commands: CommandRegistry) -> None:
        """Take the command."""
        commands.register(VERB, self.channel)

    # ---- we come and go ----

    def passed(self, messenger: Messenger, passing: ChatEvent) -> None:
        """We were put into a channel, or out of it. Returns at once."""
        if passing.chat.kind is not ChatKind.CHANNEL:
            return
        key = key_of(messenger, passing.chat)
        if passing.what is ChatEventKind.REMOVED:
            self._known.pop(key, None)
            self._strange.pop(key, None)
            if self._live.of(messenger, passing.chat) is not None:
                self._left.add(key)
            self._tasks.begin(self._close(messenger, passing.chat))
        elif passing.what is ChatEventKind.ADDED:
            self._left.discard(key)
            self._added(key, messenger, passing)

    def _added(self, key: str, messenger: Messenger, passing: ChatEvent) -> None:
        directory = self._rooms.authoriser.directory
        found = directory.at(passing.who) if passing.who is not None else None
        by = said("Somebody I do not know") if found is None else clean_name(found[0].name)
        channel = KnownChannel(messenger, passing.chat, clean_name(passing.title), by)
        self._known.pop(key, None)
        self._strange.pop(key, None)
        ours = found is not None and self._acts(found[0].id)
        known, most = (self._known, KNOWN_AT_MOST) if ours else (self._strange, STRANGE_AT_MOST)
        known[key] = channel
        if len(known) > most:
            known.popitem(last=False)
        if ours and not self._questions.take(self._clock.monotonic_ns()):
            self._offer(key, channel)

    def _acts(self, who: PrincipalId) -> bool:
        """Whether somebody may open windows, and their key is good."""
        return self._may(who) and self._rooms.authoriser.has_access(who)

    def _offer(self, key: str, channel: KnownChannel) -> None:
        """Ask whoever may open it what it is to show, each for what they see themselves."""
        organiser = self._rooms.organiser
        for who in organiser.rights.givers(FLEET, organiser.wall_ns()):
            robots = sorted(organiser.visible(who))
            if robots and self._may(who):
                notice = Notification(
                    text=put_into(channel),
                    buttons=self._choices(key, robots),
                    lifetime_s=GOOD_FOR_S,
                    still=True,
                    instead_of=self._asked,
                    landed=self._landed,
                )
                self._reach.give((who,), notice)

    def _landed(self, messenger: Messenger, chat: Chat, message: str) -> None:
        self._asked[messenger.name, chat.id] = message

    def _choices(self, key: str, robots: list[RobotId]) -> tuple[tuple[Button, ...], ...]:
        profiles = self._rooms.profiles
        buttons = [
            Button(show(profiles[robot].shown), f"/{VERB} {key} {robot}")
            for robot in robots[:OFFERED_AT_MOST]
        ]
        if len(robots) > 1:
            buttons.append(Button(said("Show all"), f"/{VERB} {key} {ALL}"))
        return rows(buttons)

    # ---- what admins say ----

    async def channel(self, asked: CommandContext) -> Reply:
        """Do ``/channel``: list the windows; what its buttons say opens and closes them.

        Raises:
            NotPermitted: Not in private, or not theirs to say.
            NotUnderstood: No such channel or robot.
            TooManyRequests: There are too many cards.
            RecordUnavailable: Not written; nothing was changed.
        """
        check_private(asked)
        who = asked.caller.principal
        if not self._may(who):
            raise NotPermitted(said("Only who may give rights here decides what a channel shows."))
        key, _, what = asked.rest.strip().partition(" ")
        where = (asked.messenger.name, asked.inbound.chat.id)
        if asked.inbound.under and self._asked.get(where) == asked.inbound.under:
            del self._asked[where]  # the answer stands there now
        if not key:
            return self._list()
        known = self._all()
        if key not in known:
            raise NotUnderstood(GONE, offers=(f"/{VERB}",))
        messenger, chat, title, _ = channel = known[key]
        if not what:
            seen = sorted(self._rooms.organiser.visible(who))
            return Reply(put_into(channel), self._choices(key, seen))
        if what == CLOSE:
            await self._close(messenger, chat)
            return Reply(said("{channel} shows no robot any more.", channel=_named(title)))
        robots = self._robots(who, what)
        decided = Decided(
            act=VERB,
            by=who,
            about=key,
            at_ns=self._rooms.organiser.wall_ns(),
            digest=" ".join(robots).encode(),
        )
        async with self._changes.turn() as turn:
            await turn.write((decided,))
        self._live.begin(messenger, chat, who, robots, pinned=False)
        return Reply(self._shown(title, robots), ((self._closing(key),),))

    def _robots(self, who: PrincipalId, what: str) -> tuple[RobotId, ...]:
        visible = self._rooms.organiser.visible(who)
        robots = tuple(sorted(visible)) if what == ALL else tuple(what.split())
        if not robots or not visible.issuperset(robots):
            raise NotUnderstood(said("I know no such robot."), offers=("robots",))
        return robots

    def _all(self) -> dict[str, KnownChannel]:
        """Return the channels that were heard of, and those that an earlier run has opened."""
        opened = {
            dashboard.key: KnownChannel(dashboard.messenger, dashboard.chat)
            for dashboard in self._live.in_channels()
        }
        heard = opened | self._strange | self._known
        return {key: it for key, it in heard.items() if key not in self._left}

    def _list(self) -> Reply:
        lines: list[str] = []
        buttons: list[Button] = []
        offered = 0
        for key, (messenger, chat, title, by) in reversed(self._all().items()):
            dashboard = self._live.of(messenger, chat)
            if dashboard is None:
                lines.append(
                    said(
                        "{channel} shows no robot. {who} put me there.",
                        channel=_named(title),
                        who=by,
                    )
                )
                if offered < ASKED_AT_MOST:
                    offered += 1
                    label = said("Show something in {channel}", channel=_named(title))
                    buttons.append(Button(label, f"/{VERB} {key}"))
            else:
                lines.append(self._shown(title, dashboard.robots))
                label = said("Close {channel}", channel=_named(title))
                buttons.append(Button(label, f"/{VERB} {key} {CLOSE}"))
        return Reply(joined("\n", lines) if lines else NONE, rows(buttons))

    def _shown(self, title: str, robots: tuple[RobotId, ...]) -> str:
        names = ", ".join(self._rooms.profiles[robot].shown for robot in robots)
        return said(
            "{channel} shows {robots}, to everybody who reads it. Nothing that is written there"
            " commands anything.",
            channel=_named(title),
            robots=names,
        )

    def _closing(self, key: str) -> Button:
        return Button(said("Close it"), f"/{VERB} {key} {CLOSE}")

    def _may(self, who: PrincipalId) -> bool:
        organiser = self._rooms.organiser
        return organiser.rights.holds(who, FLEET, GRANT, organiser.wall_ns())

    async def _close(self, messenger: Messenger, chat: Chat) -> None:
        dashboard = self._live.of(messenger, chat)
        if dashboard is None:
            return
        try:
            await self._live.end(dashboard)
            self._left.discard(dashboard.key)
        except Refusal:
            log.warning("a window could not be closed; it is closed when it can be written")


GONE: Final = said(
    "I do not know that channel. Take me out of it and put me in again, as one of its admins."
)
NONE: Final = said(
    "I am in no channel, as far as I have heard since I was started. Put me into one as an admin of"
    " it, and I ask here what it is to show."
)


def _named(title: str) -> str:
    return title or said("A channel")


def put_into(channel: KnownChannel) -> str:
    """Say that we are in a channel, and by whom, and ask what it is to show."""
    return said(
        "{who} put me into the channel {channel}. It shows nothing yet. Whatever you show there,"
        " everybody who reads the channel sees: how the robot is and what it was asked, no names."
        " Nothing that is written there commands anything.",
        who=channel.by or said("Somebody I do not know"),
        channel=_named(channel.title),
    )


def show(robot: str) -> str:
    """Return the label of what shows a robot in a channel."""
    return said("Show {robot}", robot=robot)
