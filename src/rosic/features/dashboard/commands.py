"""``/card``: begin a live card, choose its robots, keep it in sight, end it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import said
from rosic.core.language.command import Command, HelpEntry, HelpPage
from rosic.core.language.compiled import fold
from rosic.core.language.keywords import FILLERS
from rosic.core.language.suggestions import did_you_mean
from rosic.core.message import Button
from rosic.core.messages import NOTHING_VISIBLE
from rosic.errors import NotUnderstood
from rosic.features.dashboard import messages as words
from rosic.gateway.commands import Reply

if TYPE_CHECKING:
    from rosic.core.language import VocabularyHolder
    from rosic.core.robot.profile import RobotId
    from rosic.features.dashboard.dashboard import RobotSnapshots
    from rosic.features.dashboard.dashboards import Dashboards
    from rosic.features.dashboard.rendering import DashboardQueries
    from rosic.gateway.commands import CommandContext

COMMANDS: Final = (
    Command(
        name="card",
        verbs={"anheften": "pin", "loslösen": "unpin", "bild": "picture", "aus": "off"},
        aliases=("tafel",),
        typed=said("/card"),
        summary=said("A message that always shows how robots are"),
        help=HelpEntry(HelpPage.SEE, 30),
    ),
)


_ENDS = ".,;:!?"
_BETWEEN = str.maketrans(",;", "  ")


class DashboardCommands:
    """The handler of live cards.

    Args:
        live: The cards.
        snapshots: Looks at what they show.
        vocabularies: Knows robots by name.
        sides: What the rooms know.
        verb: What asks for such a card.
    """

    def __init__(
        self,
        live: Dashboards,
        snapshots: RobotSnapshots,
        vocabularies: VocabularyHolder,
        sides: DashboardQueries,
        verb: str = "card",
    ) -> None:
        self._live = live
        self._snapshots = snapshots
        self._vocabularies = vocabularies
        self._sides = sides
        self._verb = verb

    async def card(self, asked: CommandContext) -> Reply:
        """Do what was said about this chat's card. The card itself is the answer.

        Raises:
            NotUnderstood: There is no such robot, as far as this person may know.
            NothingToSee: There is no card, or no camera for it.
            TooManyRequests: There are too many cards, or too many of theirs.
            RecordUnavailable: It could not be ended.
        """
        typed = asked.rest.strip().rstrip(_ENDS).translate(_BETWEEN).split()
        verb = fold(typed[0]) if typed else ""
        if verb not in self._vocabularies.current.callees:
            verb = self._vocabularies.current.commands.verb("card", verb)
        if verb == "off" and len(typed) == 1:
            return await self._off(asked)
        if verb == "picture" and len(typed) > 1:
            return self._picture(asked, typed[1:])
        known = self._live.of(asked.messenger, asked.inbound.chat)
        if verb in {"pin", "unpin"} and len(typed) == 1 and known is not None:
            self._live.keep_in_sight(known, pinned=verb == "pin")
            return Reply("")
        if verb == "unpin" and len(typed) == 1:
            return Reply(words.NO_SUCH_CARD)
        return self._begin(asked, typed[1:] if verb == "pin" else typed, pinned=verb == "pin")

    def _picture(self, asked: CommandContext, typed: list[str]) -> Reply:
        """Let the card show what its camera sees; the card itself is the answer."""
        [robot, *_] = self._robots(typed, self._sides.sees(asked.caller.principal)) or ("",)
        self._live.drawing.picturing.ask(asked, self._live, robot)
        return Reply("")

    async def _off(self, asked: CommandContext) -> Reply:
        known = self._live.of(asked.messenger, asked.inbound.chat)
        if known is None:
            return Reply(words.NO_SUCH_CARD)
        await self._live.end(known)
        return Reply(words.OFF)

    def _begin(self, asked: CommandContext, typed: list[str], *, pinned: bool) -> Reply:
        owner, chat = asked.caller.principal, asked.inbound.chat
        visible = self._sides.sees(owner)
        if not visible:
            return Reply(NOTHING_VISIBLE)
        robots = self._robots(typed, visible)
        if not asked.messenger.edits:
            return self._once(asked, robots or tuple(sorted(visible)), " ".join(typed))
        self._live.begin(asked.messenger, chat, owner, robots, pinned=pinned)
        return Reply("")

    def _once(self, asked: CommandContext, robots: tuple[RobotId, ...], named: str) -> Reply:
        """Show how it is now, where nothing that was shown can be changed: a terminal scrolls."""
        self._snapshots.look(robots)
        text = self._live.drawing.now(asked.inbound.chat, asked.caller.principal, robots)
        again = Button(words.LOOK_AGAIN, f"/{self._verb} {named}".rstrip())
        return Reply(text, ((again,),))

    def _robots(self, typed: list[str], visible: frozenset[RobotId]) -> tuple[RobotId, ...]:
        """Return the robots that were named; what one may not see, there is not."""
        robots: dict[RobotId, None] = {}
        at = 0
        while at < len(typed):
            if fold(typed[at]) in FILLERS:
                at += 1
                continue
            found, at = self._named(typed, at, visible)
            robots.update(dict.fromkeys(found))
        return tuple(robots)

    def _named(
        self, typed: list[str], at: int, visible: frozenset[RobotId]
    ) -> tuple[tuple[RobotId, ...], int]:
        """Return whom the longest name means that begins here, and where it ends."""
        first = fold(typed[at]).partition(" ")[0]
        most = self._vocabularies.current.longest_callee.get(first, 1)
        for end in range(min(len(typed), at + most), at, -1):
            name = " ".join(typed[at:end])
            profile = self._vocabularies.current.robot(name)
            meant = self._vocabularies.current.members(name) if profile is None else (profile.id,)
            seen = tuple(robot for robot in meant if robot in visible)
            if seen:
                return seen, end
        close = did_you_mean(fold(typed[at]), (*sorted(visible), *self._groups(visible)))
        offers = tuple(f"/{self._verb} {name}" for name in close) or (f"/{self._verb}",)
        raise NotUnderstood(words.no_such_robot(typed[at]), offers=offers)

    def _groups(self, visible: frozenset[RobotId]) -> list[str]:
        """Return the groups of which somebody sees a robot."""
        vocabulary = self._vocabularies.current
        groups = (name for name in vocabulary.names if name not in vocabulary.profiles)
        return [name for name in groups if not visible.isdisjoint(vocabulary.members(name))]
