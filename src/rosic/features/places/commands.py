"""``/place omni dock``: keep where a robot is under a name. ``/places``: which there are."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

from rosic.core.i18n import joined, said
from rosic.core.language import hears_cancel, hears_stop
from rosic.core.language.command import Command, HelpEntry, HelpNeed, HelpPage
from rosic.core.language.compiled import fold
from rosic.core.language.formatting import show
from rosic.core.language.numbers import read_numeral
from rosic.core.language.vocabulary import means_else
from rosic.core.message import Button
from rosic.core.policy.scope import PLACES
from rosic.core.records import Decided
from rosic.errors import NotUnderstood, OutOfBounds, TooManyRequests
from rosic.features.places import messages as words
from rosic.features.places.place_book import PlaceEntry, here, kept_place
from rosic.gateway.commands import Reply
from rosic.gateway.requests import check_command_fresh

if TYPE_CHECKING:
    from rosic.core.robot.profile import RobotId
    from rosic.features.places.place_book import PlaceBook
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.components import Components
    from rosic.gateway.robot_argument import RobotArgument
    from rosic.gateway.transactions import Transactions

OF_ONE_AT_MOST: Final = 50
ROBOTS_SHOWN: Final = 20
BUTTONS_AT_MOST: Final = 8
REMOVE: Final = frozenset({"remove", "forget", "entfernen", "vergessen", "löschen"})
_NAME: Final = re.compile(r"[^\W\d_][\w-]{0,23}\Z")

COMMANDS: Final = (
    Command(
        name="place",
        aliases=("ort",),
        typed=said("/place"),
        summary=said("Keep the place where a robot is under a name"),
        explained=True,
        help=HelpEntry(HelpPage.MOVE, 95, HelpNeed.MOTION),
    ),
    Command(
        name="places",
        observes=True,
        aliases=("orte",),
        summary="which places robots have",
        page=HelpPage.MOVE,
    ),
)


class PlaceCommands:
    """The handler of places."""

    def __init__(
        self,
        rooms: Components,
        changes: Transactions,
        naming: RobotArgument,
        book: PlaceBook,
    ) -> None:
        self._rooms = rooms
        self._changes = changes
        self._naming = naming
        self._book = book

    def register(self, commands: CommandRegistry) -> None:
        """Take these commands."""
        commands.register("place", self.place)
        commands.register("places", self.places)

    async def places(self, asked: CommandContext) -> Reply:
        """List the places of the robots that somebody may see."""
        visible = self._rooms.organiser.visible(asked.caller.principal)
        known = self._rooms.vocabulary.places
        robots = [robot for robot in self._rooms.profiles if robot in visible and known.get(robot)]
        if not robots:
            return Reply(words.NONE)
        lines = [self._line(robot) for robot in robots[:ROBOTS_SHOWN]]
        offers = [
            f"{robot} {self._spoken(robot, name)} {name}"
            for robot in robots
            for name in known[robot]
        ]
        rows = tuple((Button(offer, offer),) for offer in offers[:BUTTONS_AT_MOST])
        return Reply(joined("\n", lines), rows)

    def _spoken(self, robot: RobotId, name: str) -> str:
        place = self._rooms.vocabulary.places[robot][name]
        compiled = self._rooms.vocabulary.compiled_skill(robot, place.skill)
        return place.skill if compiled is None else compiled.spoken

    def _line(self, robot: RobotId) -> str:
        known = self._rooms.vocabulary.places[robot]
        return words.places(
            self._rooms.profiles[robot].shown, [self._shown(robot, name) for name in known]
        )

    def _shown(self, robot: RobotId, name: str) -> str:
        """Return a place as an order to go there reads."""
        vocabulary = self._rooms.vocabulary
        place = vocabulary.places[robot][name]
        skill = self._rooms.profiles[robot].skills[place.skill]
        return show(vocabulary, robot, skill, place.arguments)

    async def place(self, asked: CommandContext) -> Reply:
        """Keep where a robot is, or forget a place.

        Raises:
            NotUnderstood: No such robot, no name, or it is not known where it is.
            NotPermitted: They may not keep places for it.
            Expired: It was not said just now: by now it may be elsewhere.
        """
        if not asked.rest.strip():
            return Reply(words.HOW_TO)
        robot, rest = self._naming.robot(asked, "place", asked.rest)
        self._rooms.organiser.check_word(asked.caller, robot, PLACES)
        name, *more = [fold(word) for word in rest.split()] or [""]
        if len(more) == 1 and more[0] in REMOVE:
            return await self._forget(asked, robot, name)
        if more or not _NAME.match(name):
            raise NotUnderstood(words.ONE_WORD)
        self._check_name(robot, name)
        check_command_fresh(asked.inbound, f"/place {asked.rest}")
        return await self._keep(asked, robot, name)

    def _check_name(self, robot: RobotId, name: str) -> None:
        """See that a word means nothing yet, and never a stop.

        Raises:
            NotUnderstood: It does.
        """
        vocabulary = self._rooms.vocabulary
        line = f"{robot} goto {name}"
        urgent = any(
            hears(text, vocabulary.known) is not None
            for hears in (hears_stop, hears_cancel)
            for text in (name, line)
        )
        taken = name in vocabulary.known or vocabulary.commands.find(name) is not None
        number = read_numeral(name) is not None or vocabulary.units.find(name) is not None
        if urgent or taken or number or name in REMOVE or means_else(name):
            raise NotUnderstood(words.means_else(name))

    async def _keep(self, asked: CommandContext, robot: RobotId, name: str) -> Reply:
        rooms, profile = self._rooms, self._rooms.profiles[robot]
        described = here(rooms.vocabulary, profile, rooms.linker.presence(robot))
        described = replace(described, name=name)
        try:
            kept_place(rooms.vocabulary, robot, described)
        except OutOfBounds as why:
            raise OutOfBounds(words.outside(profile.shown, why.sentence)) from why
        who, now_ns = asked.caller.principal, rooms.organiser.wall_ns()
        decided = Decided(act="place", by=who, about=robot, at_ns=now_ns, digest=asked.cid)
        async with self._changes.turn() as turn:
            there = self._book.of(robot)
            if name not in there and len(there) >= OF_ONE_AT_MOST:
                full = words.too_many(profile.shown, OF_ONE_AT_MOST)
                raise TooManyRequests(full, retry_after_s=60.0)
            await turn.write((decided, self._book.fact(PlaceEntry(robot, who, now_ns), described)))
        going = f"{robot} {self._spoken(robot, name)} {name}"
        text = words.kept(profile.shown, name, self._shown(robot, name))
        return Reply(text, ((Button(going, going),),), about=robot)

    async def _forget(self, asked: CommandContext, robot: RobotId, name: str) -> Reply:
        who, shown = asked.caller.principal, self._rooms.profiles[robot].shown
        now_ns = self._rooms.organiser.wall_ns()
        decided = Decided(act="place", by=who, about=robot, at_ns=now_ns, digest=asked.cid)
        async with self._changes.turn() as turn:
            if name not in self._book.of(robot):
                raise NotUnderstood(words.no_such(shown, name), offers=("/places",))
            await turn.write((decided, self._book.end(robot, name)))
        return Reply(words.forgotten(shown, name), about=robot)
