"""People who go on giving commands, whatever happens to the gateway."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, NamedTuple

from tests.journeys.fleet import GROUP, ROBOTS, Person
from tests.journeys.verdict import Said

if TYPE_CHECKING:
    from random import Random

    from rosic.testing.telegram import Control

PEOPLE = 20
STOPPING = 0.03
GROUPED = 0.08
IN_A_GROUP_CHAT = 0.05
LESS = 5.0


class Crowd(NamedTuple):
    """Everybody, and where they write.

    Attributes:
        people: Give commands, each in a private chat.
        keepers: One for each robot, by its name; they undo stops and holds.
        rooms: Group chats in which all people are.
    """

    people: tuple[Person, ...]
    keepers: dict[str, Person]
    rooms: tuple[int, ...]

    @property
    def known(self) -> tuple[Person, ...]:
        """Everybody who is in the gateway's configuration."""
        return (*self.people, *self.keepers.values())

    @property
    def chats(self) -> tuple[int, ...]:
        """Every chat in which something is said."""
        return (*(person.account for person in self.known), *self.rooms)


async def gather(control: Control) -> Crowd:
    """Let everybody open an account."""
    people = tuple(
        [Person(await control.create_user(f"P{i}"), f"Person {i}") for i in range(PEOPLE)]
    )
    keepers = {
        robot: Person(await control.create_user(robot), f"Keeper of {robot}", "admin")
        for robot in ROBOTS
    }
    members = [person.account for person in people]
    rooms = [
        await control.create_chat("supergroup", f"Room {i}", members=members) for i in range(2)
    ]
    return Crowd(people, keepers, tuple(rooms))


class Stream:
    """Says things until it is cancelled.

    Attributes:
        unheard: Nobody listens now, and people say less.
        commands: What was asked so far.
        stops: How many stops were said.
        resumes: Chat and message of every resume that was said.
        duplicated: How many updates the server was told to give out twice.
    """

    def __init__(
        self, control: Control, crowd: Crowd, chance: Random, pause_s: float, twice: float
    ) -> None:
        self.commands: list[Said] = []
        self.stops = 0
        self.resumes: list[tuple[int, int]] = []
        self.duplicated = 0
        self.unheard = True
        self._control = control
        self._crowd = crowd
        self._chance = chance
        self._pause_s = pause_s
        self._twice = twice

    async def run(self) -> None:
        """Say something, wait a little, and so on."""
        while True:
            await self._say_one()
            pause_s = self._pause_s * (LESS if self.unheard else 1)
            await asyncio.sleep(self._chance.expovariate(1 / pause_s))

    async def _say_one(self) -> None:
        chance, crowd = self._chance, self._crowd
        person = chance.choice(crowd.people)
        chat = person.account
        if chance.random() < IN_A_GROUP_CHAT:
            chat = chance.choice(crowd.rooms)
        if chance.random() < self._twice:
            self.duplicated += 1
            await self._control.call("duplicate", new_id=chance.random() < 0.5)
        if chance.random() < STOPPING:
            self.stops += 1
            words = chance.choice([*(f"stop {robot}" for robot in ROBOTS), f"stop {GROUP}", "stop"])
            await self._control.say(chat, person.account, words)
            return
        text, robots = self._command(person)
        message = await self._control.say(chat, person.account, text)
        self.commands.append(Said(chat, person.account, message, text, robots))

    def _command(self, person: Person) -> tuple[str, tuple[str, ...]]:
        """Return what somebody asks, mostly of the robot that they use mostly."""
        if self._chance.random() < GROUPED:
            return f"{GROUP} hop", ("fly1", "fly2")
        at_home = self._chance.random() < 0.8
        robot = ROBOTS[person.account % len(ROBOTS)] if at_home else self._chance.choice(ROBOTS)
        what = self._chance.choice(("hop", "hop 2 m", "sort"))
        return f"{robot} {what}", (robot,)

    async def resume_all(self) -> None:
        """Let every keeper resume their robot, whether or not it is stopped."""
        for robot, keeper in self._crowd.keepers.items():
            chat = keeper.account
            message = await self._control.say(chat, chat, f"resume {robot}")
            self.resumes.append((chat, message))
