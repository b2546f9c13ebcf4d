"""``/shared``, ``/assist``, ``/strategy`` and ``/quiet``: people read robots and interrupt them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined
from rosic.core.language import clean, inert_text
from rosic.core.language.command import Command
from rosic.core.language.keywords import option_typed
from rosic.core.language.time_tokens import length_said
from rosic.core.message import Button
from rosic.core.messages import no_robot
from rosic.core.time_units import DAY_S
from rosic.errors import NotPermitted, NotUnderstood, OutOfBounds
from rosic.features.robot_to_robot import messages as words
from rosic.features.robot_to_robot.subscriptions import Subscriber, SubscriberChat
from rosic.gateway.commands import Reply, check_length
from rosic.gateway.requests import check_command_fresh

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.identity import PrincipalId
    from rosic.core.records import Fact
    from rosic.core.robot.profile import RobotId
    from rosic.features.robot_to_robot.service import RobotMessaging
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.components import Components

COMMANDS: Final = (
    Command(
        name="shared",
        summary="what robots share with each other",
    ),
    Command(
        name="assist", summary="who needs help, and giving it", aliases=("helfen",), explained=True
    ),
    Command(name="strategy", summary="how a robot works", aliases=("strategie",), explained=True),
    Command(name="quiet", summary="hear less of what a robot says", explained=True),
)


LONGEST_LINE = 300
LINES_AT_MOST = 24
NAME_WORDS = 4
USUAL_S = 600.0
SHORTEST_S = 60.0
LONGEST_S = 7.0 * DAY_S
FOLLOW, UNFOLLOW = "follow", "unfollow"
DONE = frozenset({"done", "over"})
OFF = frozenset({"off", "no", "end", "aus"})


class RobotToRobotCommands:
    """Answers about robots among themselves; reads only what its asker may see (I11)."""

    def __init__(self, messaging: RobotMessaging, rooms: Components) -> None:
        self._messaging = messaging
        self._circle = messaging.circle
        self._around = messaging.circle.around
        self._rooms = rooms

    def register(self, commands: CommandRegistry) -> None:
        """Take the commands."""
        commands.register("shared", self.shared)
        commands.register("assist", self.assist)
        commands.register("strategy", self.strategy)
        commands.register("quiet", self.quiet)

    # ---- shared data ----

    async def shared(self, asked: CommandContext) -> Reply:
        """Show what robots share; ``/shared omni road follow`` has it said here from now on.

        Raises:
            NotUnderstood: No such robot.
            TooManyRequests: Too many follow it.
            RecordUnavailable: Not written; nothing was changed.
        """
        said = _words(asked)
        if not said:
            return self._all(asked.caller.principal)
        robot, shown, rest = self._whom(asked.caller.principal, said)
        if rest and rest[-1] in {FOLLOW, UNFOLLOW}:
            return await self._follow(asked, robot, rest)
        if rest:
            one = self._circle.shared_state.get(robot, "_".join(rest))
            if one is not None:
                row = (Button(words.follow_label(), f"/shared {robot} {one.topic} follow"),)
                return Reply(words.whole(one, shown, self._past_s(one.at_ns)), (row,), about=robot)
        lines = self._lines(robot)
        return Reply(joined("\n", lines) if lines else words.nothing_shared(shown), about=robot)

    def _all(self, who: PrincipalId) -> Reply:
        visible = sorted(self._rooms.organiser.visible(who))
        lines = [line for robot in visible for line in self._lines(robot)]
        return Reply(joined("\n", lines[:LINES_AT_MOST]) if lines else words.nobody_shares())

    def _lines(self, robot: RobotId) -> list[str]:
        shown = self._around.rights.shown(robot)
        return [
            words.line(s, shown, self._past_s(s.at_ns)) for s in self._circle.shared_state.of(robot)
        ]

    def _past_s(self, at_ns: int) -> float:
        return max(0, self._around.clock.wall_ns() - at_ns) / 1e9

    async def _follow(self, asked: CommandContext, robot: RobotId, rest: list[str]) -> Reply:
        *named, verb = rest
        topic, who = "_".join(named), asked.caller.principal
        subscriber, where = (
            Subscriber(robot, topic, "", who),
            SubscriberChat(asked.messenger.name, asked.inbound.chat),
        )
        post, shown = self._around.post, self._around.rights.shown(robot)
        async with self._around.changes.turn() as turn:
            facts: tuple[Fact | None, ...]
            if verb == FOLLOW:
                facts = (post.follow(subscriber, where),)
            elif topic:
                facts = (post.unfollow(subscriber, where),)
            else:
                facts = post.unfollow_here(robot, who, where)
            await turn.write([fact for fact in facts if fact is not None])
        if verb == FOLLOW:
            return Reply(words.following(shown, robot, topic), about=robot)
        return Reply(words.not_following(shown, topic), about=robot)

    # ---- help ----

    async def assist(self, asked: CommandContext) -> Reply:
        """Show who asks for help, or help: ``/assist ID``, ``/assist ID cf1``, ``/assist ID done``.

        Raises:
            NotUnderstood: No such request, or no such robot.
            Expired: Somebody was faster; or it was not sent just now: robots change tasks by it.
            NotPermitted: Not theirs.
            RecordUnavailable: Not written; nobody has accepted it.
        """
        said, helping = _words(asked), self._circle.helping
        if not said:
            return self._open(asked.caller.principal)
        ident, *rest = said
        self._seen(asked.caller.principal, helping.book.find(ident).robot)
        if rest and rest[0] in DONE:
            return Reply(await helping.end(asked.caller, ident))
        helper = ""
        if rest:
            helper, _, _ = self._whom(asked.caller.principal, rest)
        check_command_fresh(asked.inbound, f"/assist {asked.rest}")
        return Reply(await helping.accept(asked.caller, ident, helper))

    def _open(self, who: PrincipalId) -> Reply:
        visible, book = self._rooms.organiser.visible(who), self._circle.helping.book
        shown, name_of = self._around.rights.shown, self._rooms.organiser.name_of
        open_ = [h for h in book.open() if h.robot in visible]
        lines = [words.open_help(h.id, shown(h.robot), inert_text(h.what)) for h in open_]
        lines += [
            words.under_way(
                shown(h.robot),
                inert_text(h.what),
                shown(h.helper) if h.helper else clean(name_of(h.by)),
            )
            for h in book.under_way()
            if h.robot in visible
        ]
        rows = [
            row
            for h in open_[:4]
            if self._around.rights.may(who, h.robot, "help")
            for row in self._circle.helping.buttons(h, who)
        ]
        if not lines:
            return Reply(words.no_help_open())
        return Reply(joined("\n", lines[:LINES_AT_MOST]), tuple(rows))

    # ---- strategies ----

    async def strategy(self, asked: CommandContext) -> Reply:
        """Show a robot's strategy, or change it: ``/strategy omni careful speed=0.2 now``.

        Raises:
            NotUnderstood, OutOfBounds: Its profile declares no such thing.
            NotPermitted, RobotTaken: Not theirs, or not now.
            Expired: It was not sent just now.
        """
        said = _words(asked)
        if not said:
            raise NotUnderstood(words.how_to_adjust())
        robot, _, rest = self._whom(asked.caller.principal, said)
        strategies = self._circle.strategies
        if not rest:
            return Reply(strategies.now(robot), about=robot)
        check_command_fresh(asked.inbound, f"/strategy {asked.rest}")
        name, *values = map(option_typed, rest)
        now = bool(values) and values[-1] == "now"
        if values and values[-1] in {"now", "idle"}:
            values = values[:-1]
        given = dict(_pairs(values))
        text = await strategies.change(asked.caller, robot, name, given, idle=not now)
        return Reply(text, about=robot)

    # ---- silence ----

    async def quiet(self, asked: CommandContext) -> Reply:
        """Let nobody hear a robot for a while: ``/quiet omni``, ``10 min``, ``off``.

        Raises:
            NotUnderstood, OutOfBounds: No such robot or length of time.
            NotPermitted: Not theirs.
        """
        said, who = _words(asked), asked.caller.principal
        if not said:
            raise NotUnderstood(words.how_to_quiet())
        robot, shown, rest = self._whom(who, said)
        if not self._around.rights.operates(who, robot):
            raise NotPermitted(words.may_not_quiet(shown))
        if len(rest) == 1 and rest[0] in OFF:
            await self._messaging.silence(robot, who, 0)
            await self._tell_others(robot, who, lambda _: words.heard_again(shown))
            return Reply(words.heard_again(shown), about=robot)
        lasts_s = _length(rest)
        until_ns = self._around.clock.wall_ns() + int(lasts_s * 1e9)
        await self._messaging.silence(robot, who, until_ns)
        name = clean(self._rooms.organiser.name_of(who))
        moment = self._rooms.organiser.moment
        await self._tell_others(
            robot, who, lambda o: words.quieted(shown, name, moment(o, until_ns))
        )
        return Reply(words.quieted(shown, name, moment(who, until_ns)), about=robot)

    async def _tell_others(
        self, robot: RobotId, who: PrincipalId, text: Callable[[PrincipalId], str]
    ) -> None:
        async for other in self._around.rights.operators(robot):
            if other != who:
                self._around.reach.tell((other,), text(other))

    def _whom(self, who: PrincipalId, said: list[str]) -> tuple[RobotId, str, list[str]]:
        """Return the robot that the first words call, how it is shown, and what follows.

        Raises:
            NotUnderstood: No robot that they see.
        """
        for used in range(min(len(said), NAME_WORDS), 0, -1):
            profile = self._rooms.vocabulary.robot(" ".join(said[:used]))
            if profile is not None:
                return profile.id, self._seen(who, profile.id), said[used:]
        raise NotUnderstood(no_robot(said[0]))

    def _seen(self, who: PrincipalId, robot: RobotId) -> str:
        """Return how a robot is shown, if somebody may see it."""
        if robot not in self._rooms.organiser.visible(who):
            raise NotUnderstood(no_robot(robot))
        return self._around.rights.shown(robot)


def _words(asked: CommandContext) -> list[str]:
    """Return the words of a line.

    Raises:
        OutOfBounds: It is too long.
    """
    line = clean(asked.rest)
    check_length(line, LONGEST_LINE)
    return line.casefold().split()


def _pairs(said: list[str]) -> list[tuple[str, str]]:
    """Split ``speed=0.2 m/s spacing=1`` into names and values."""
    pairs: list[tuple[str, str]] = []
    for word in said:
        name, equals, value = word.partition("=")
        if equals:
            pairs.append((name, value))
        elif pairs:
            pairs[-1] = (pairs[-1][0], pairs[-1][1] + word)
        else:
            raise NotUnderstood(words.how_to_adjust())
    return pairs


def _length(rest: list[str]) -> float:
    if not rest:
        return USUAL_S
    if rest[0] == "for":
        rest = rest[1:]
    seconds, used = length_said(rest)
    if not used or used != len(rest) or seconds is None:
        raise NotUnderstood(words.how_to_quiet())
    if not SHORTEST_S <= seconds <= LONGEST_S:
        raise OutOfBounds(words.quiet_bounds(int(LONGEST_S)))
    return seconds
