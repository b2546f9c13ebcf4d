"""One chat's card: whose, of which robots, in which message; and how that is written down."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec
from msgspec.structs import replace

from rosic.core.i18n import joined
from rosic.core.identity import PrincipalId
from rosic.core.message import Attachment, Button, Chat, ChatKind
from rosic.core.messages import named_of, rest_unmeasured, unmeasured
from rosic.core.records import Fact, Letter
from rosic.core.robot.profile import RobotId, Slots
from rosic.core.time_units import SECOND_NS
from rosic.features.dashboard import messages as words
from rosic.gateway.chat_dashboards import key_of

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Iterable, Iterator

    from rosic.contracts.messenger import Messenger
    from rosic.core.order_status import Face
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.components import Components
    from rosic.gateway.order_execution import OrderExecutor, RunningOrder


# ---- one chat's card ----

KIND: Final = "card"
LOOKING_S: Final = 180.0
"""For so long after a tap somebody is taken to look."""
RENEWED_S: Final[dict[ChatKind, float]] = {ChatKind.PRIVATE: 10.0, ChatKind.GROUP: 30.0}
"""From one picture to the next at the least: half of those that somebody may have at all."""


LONGEST_WAIT_S: Final = 300.0


class RefreshPace(NamedTuple):
    """How often a card may change, and how old it may become.

    Attributes:
        between_s: From one edit to the next, at the least.
        refresh_s: After so long it is said anew how it is, though nothing has changed.
        promise_s: What it says about that, with room for a slow network.
    """

    between_s: float
    refresh_s: float
    promise_s: float


PRIVATE: Final = RefreshPace(3.0, 45.0, 60.0)
GROUP: Final = RefreshPace(15.0, 90.0, 120.0)
"""Four of the twenty messages and edits that a platform may let a group have in a minute."""


def pace_of(chat: Chat) -> RefreshPace:
    """Return how often a card in this chat may change."""
    return PRIVATE if chat.kind is ChatKind.PRIVATE else GROUP


class DashboardBody(msgspec.Struct, frozen=True):
    """What stands in the open.

    Attributes:
        robots: As they were named; none: every robot that the owner may see.
        pinned: It is kept in sight.
        picture_of: The robot whose picture its message shows; empty for none.
        picture_ns: When that was so, wall clock.
    """

    owner: PrincipalId
    robots: tuple[RobotId, ...]
    pinned: bool
    picture_of: RobotId = ""
    picture_ns: int = 0


class DashboardPlace(msgspec.Struct, frozen=True):
    """Where it is: in the owner's container, for a chat's id is an account's."""

    messenger: str
    platform: str
    chat: str
    kind: str
    message: str


_encode = msgspec.msgpack.Encoder().encode
_body = msgspec.msgpack.Decoder(DashboardBody).decode
_place = msgspec.msgpack.Decoder(DashboardPlace).decode


class PreviewedCamera(msgspec.Struct, frozen=True):
    """A picture for a card.

    Attributes:
        robot: Whose it is.
        at_ns: When it was taken, wall clock.
        content: None once it was shown: what is shown is not kept.
    """

    robot: RobotId
    at_ns: int
    content: Attachment | None = None


class PreviewViewer:
    """Somebody looks at a robot on a card.

    Attributes:
        asked: The tap.
        until_ns: So long, monotonic clock.
        next_ns: No picture is taken by itself before, monotonic clock.
    """

    __slots__ = ("asked", "next_ns", "robot", "until_ns")

    def __init__(self, asked: CommandContext, robot: RobotId, now_ns: int) -> None:
        self.asked = asked
        self.robot = robot
        self.until_ns = now_ns + int(LOOKING_S * SECOND_NS)
        self.next_ns = 0
        self.wait(now_ns)

    def wait(self, now_ns: int) -> None:
        """A picture has just been asked for."""
        every_s = RENEWED_S.get(self.asked.inbound.chat.kind, RENEWED_S[ChatKind.GROUP])
        self.next_ns = now_ns + int(every_s * SECOND_NS)


class Dashboard:
    """A card.

    Attributes:
        kind: Of its fact: what sort of card it is.
        key: Of its fact: a digest of the chat.
        message: The platform's id; empty until it was sent.
        pinned: It is kept in sight, as far as is known.
        wanted_pinned: It is to be.
        shows: Robots in the newest text, and the number of the look at each.
        stamped_ns: When that text was so, monotonic clock; 0: never in this run.
        settled_ns: When the last edit was over, monotonic clock.
        lag_s: How long the last edit took to arrive.
        failures: Edits that failed in a row.
        again_ns: Not to be tried before, monotonic clock.
        picture: The picture on it, or the one that is to be; None: it is text.
        offered, offered_ns, buttons: Robots that can be looked at by a tap, since when, and how.
        last: What it says when it is over; empty while it is not.
        watched: Who looks at its picture; None: it is not renewed by itself.
        task: The edit under way.
    """

    __slots__ = (
        "again_ns",
        "buttons",
        "chat",
        "failures",
        "key",
        "kind",
        "lag_s",
        "last",
        "message",
        "messenger",
        "offered",
        "offered_ns",
        "owner",
        "picture",
        "pinned",
        "robots",
        "settled_ns",
        "shows",
        "stamped_ns",
        "task",
        "wanted_pinned",
        "watched",
    )

    def __init__(
        self,
        messenger: Messenger,
        chat: Chat,
        owner: PrincipalId,
        robots: tuple[RobotId, ...],
        kind: str = KIND,
    ) -> None:
        self.kind = kind
        self.key = key_of(messenger, chat)
        self.messenger = messenger
        self.chat = chat
        self.owner = owner
        self.robots = robots
        self.message = ""
        self.pinned = self.wanted_pinned = False
        self.shows: dict[RobotId, int] = {}
        self.stamped_ns = 0
        self.settled_ns = 0
        self.lag_s = 0.0
        self.failures = 0
        self.again_ns = 0
        self.picture: PreviewedCamera | None = None
        self.watched: PreviewViewer | None = None
        self.offered: tuple[RobotId, ...] = ()
        self.offered_ns = 0
        self.buttons: tuple[Button, ...] = ()
        self.last = ""
        self.task: asyncio.Task[None] | None = None

    @property
    def pictured_anew(self) -> bool:
        """Whether there is a picture that its message does not show yet."""
        return self.picture is not None and self.picture.content is not None

    # ---- edits ----

    def begin_edit(self, edit: Coroutine[None, None, None]) -> None:
        """Begin to bring its message up to date, or to its end."""
        self.task = asyncio.create_task(edit)

    def edit_over(self, task: asyncio.Task[None] | None) -> None:
        """An edit is over, however it went; another one may have taken its place."""
        if self.task is task:
            self.task = None

    def call_off_edit(self) -> None:
        """Cut the edit under way short."""
        if self.task is not None:
            self.task.cancel()
            self.task = None

    def may_show(self, shows: dict[RobotId, int]) -> None:
        """A text is on its way: until it is known to be there, the chat shows it or the last."""
        self.shows = self.shows | shows

    def brought(self, message: str, shows: dict[RobotId, int], began_ns: int, now_ns: int) -> None:
        """Its message shows the newest text, which was so when the edit began."""
        self.message = message
        self.shows, self.stamped_ns, self.failures = shows, began_ns, 0
        self.settled_ns = now_ns
        self.lag_s = (now_ns - began_ns) / SECOND_NS

    def failed(self, now_ns: int) -> None:
        """An edit failed: it is tried again later, and ever more seldom."""
        self.failures += 1
        self.stamped_ns = 0
        between_s = pace_of(self.chat).between_s
        wait_s = min(LONGEST_WAIT_S, between_s * 2 ** min(self.failures, 10))
        self.again_ns = now_ns + int(wait_s * SECOND_NS)

    def end(self, last: str) -> None:
        """It is over; its message is to say so at once."""
        self.last, self.again_ns, self.failures = last, 0, 0
        if self.message:
            self.call_off_edit()

    def _change_at_once(self) -> None:
        self.stamped_ns = self.settled_ns = 0

    # ---- kept in sight ----

    def keep_in_sight(self, *, pinned: bool) -> None:
        """Pin it, or unpin it, with the next edit, which is due at once."""
        self.wanted_pinned = pinned
        self._change_at_once()

    def pinning_done(self, *, pinned: bool) -> None:
        """The platform has pinned it, or unpinned it."""
        self.pinned = pinned

    def pinning_failed(self) -> None:
        """The platform did not do what was wanted: it stays as it is."""
        self.wanted_pinned = self.pinned

    # ---- pictures ----

    def show_picture(self, picture: PreviewedCamera) -> None:
        """Show a picture with the next edit, which is due at once."""
        self.picture = picture
        self._change_at_once()

    def picture_shown(self, content: Attachment) -> None:
        """Its message shows a picture: what is shown is not kept."""
        if self.picture is not None and self.picture.content is content:
            self.picture = replace(self.picture, content=None)

    def offer(self, robots: tuple[RobotId, ...], buttons: tuple[Button, ...], now_ns: int) -> None:
        """Let these robots be looked at by a tap."""
        self.offered, self.buttons, self.offered_ns = robots, buttons, now_ns

    def use_up_buttons(self) -> None:
        """One of them was tapped, and is no more: the next edit offers others."""
        self.offered = ()

    def watch(self, viewer: PreviewViewer) -> None:
        """Somebody looks from now on."""
        self.watched = viewer

    def look_away(self) -> None:
        """Nobody looks any more."""
        self.watched = None

    def renew_picture(self, viewer: PreviewViewer, picture: PreviewedCamera) -> None:
        """Show a newer picture with the next edit, if the same person still looks."""
        if self.watched is viewer and not self.last:
            self.picture = picture

    # ---- what is written down ----

    def fact(self) -> Fact:
        """Return what is to be written so that it outlives this process."""
        chat = self.chat
        shown = self.picture or PreviewedCamera("", 0)
        place = DashboardPlace(
            self.messenger.name, chat.platform, chat.id, chat.kind.value, self.message
        )
        return Fact(
            kind=self.kind,
            key=self.key,
            body=_encode(
                DashboardBody(self.owner, self.robots, self.pinned, shown.robot, shown.at_ns)
            ),
            letter=Letter(self.owner, _encode(place)),
        )

    def no_fact(self) -> Fact:
        """Return what is to be written so that it is over."""
        return Fact(kind=self.kind, key=self.key, body=b"")


def read_fact(fact: Fact) -> tuple[DashboardBody, DashboardPlace] | None:
    """Return what a fact says; None if there is no card, or nobody can read any more where.

    Raises:
        msgspec.MsgspecError: It cannot be read.
    """
    if not fact.body or fact.letter is None:
        return None
    return _body(fact.body), _place(fact.letter.content)


def chat_of(place: DashboardPlace) -> Chat:
    """Return the chat.

    Raises:
        ValueError: Of an unknown kind.
    """
    return Chat(place.platform, place.chat, ChatKind(place.kind))


# ---- what robots show now ----


class RobotSnapshots:
    """The newest look at each robot.

    A number beside it grows whenever there is something new to see: a card compares numbers. While
    nobody looks, orders are not followed.

    Args:
        benchmark: Returns what is to be said of a robot against its benchmarks; empty for nothing.
    """

    def __init__(
        self,
        rooms: Components,
        executor: OrderExecutor,
        face: Face,
        benchmark: Callable[[RobotId], str],
    ) -> None:
        self._rooms = rooms
        self._executor = executor
        self._face = face
        self._benchmark = benchmark
        self._seen: dict[RobotId, tuple[int, str]] = {}
        self._followed: dict[RobotId, RunningOrder] = {}

    def begin(self) -> None:
        """Follow orders from now on, those under way included."""
        self._followed = self._executor.follow()

    def end(self) -> None:
        """Follow nothing any more."""
        self._executor.leave_off()
        self._followed = {}

    def look(self, robots: Iterable[RobotId]) -> None:
        """Look at these robots."""
        for robot in robots:
            text = joined("\n", self._lines(robot))
            number, before = self._seen.get(robot, (0, ""))
            if text != before:
                self._seen[robot] = (number + 1, text)

    def number(self, robot: RobotId) -> int:
        """Return how often there was something new to see."""
        return self._seen[robot][0]

    def text(self, robot: RobotId, *, named: bool = True) -> str:
        """Return what there is to see; perhaps without the names of people."""
        return self._seen[robot][1] if named else joined("\n", self._lines(robot, named=False))

    # ---- one robot ----

    def _lines(self, robot: RobotId, *, named: bool = True) -> Iterator[str]:
        linker, profile = self._rooms.linker, self._rooms.profiles[robot]
        presence, queued = linker.presence(robot), linker.waiting(robot)
        states = [
            self._stopped(robot, named=named),
            self._holder(robot, named=named),
            words.waiting(queued) if queued else "",
            words.battery(profile, presence),
            words.link(presence),
        ]
        yield words.head(profile, [state for state in states if state])
        life = self._followed.get(robot)
        if life is not None:
            what = _what(life)
            yield from (words.step(step, what) for step in life.shown.steps)
        if measured := self._benchmark(robot):
            yield words.benchmark(measured)
        done = life.shown.now(briefly=not named) if life is not None else ""
        if done:
            yield words.now(done)
        elif presence.doing:
            yield words.now(words.doing(named_of(profile, presence.doing)))
        elif presence.at_rest:
            yield words.now(words.at_rest())
        elif rest_unmeasured(profile, presence):
            yield words.now(unmeasured(presence))

    def _stopped(self, robot: RobotId, *, named: bool) -> str:
        entry = self._rooms.stops[robot]
        if not entry.latched:
            return ""
        name = self._rooms.organiser.name_of(entry.by) if entry.by and named else ""
        return words.stopped(name, self._face(entry.since_ns) if entry.since_ns else "")

    def _holder(self, robot: RobotId, *, named: bool) -> str:
        organiser = self._rooms.organiser
        calendar, now_ns = organiser.calendar, organiser.wall_ns()
        booked = self._rooms.profiles[robot].slots is not Slots.NONE and calendar.has_slots(robot)
        slot = calendar.present(robot, now_ns) if booked else None
        who = organiser.whose(robot)
        if who is not None:
            ends = slot is not None and slot.principal == who
            # On the place's clocks, as all of a card: others look at it as well.
            until = organiser.moment("", slot.end_ns) if slot is not None and ends else ""
            return words.theirs(organiser.name_of(who) if named else words.taken(), until)
        following = calendar.next_of(robot, now_ns) if booked else None
        return words.free("" if following is None else organiser.moment("", following.start_ns))


def _what(life: RunningOrder) -> str:
    """Return what was asked; what somebody wrote freely is theirs, and stays in their own chat."""
    skill = life.order.skill
    if any(parameter.text for parameter in skill.parameters.values()):
        return skill.shown
    return words.short(life.order.words)
