"""What the operator of this machine may ask of a running gateway, without a chat.

They own the process and its data, so nothing here asks the organiser; everything that changes
something is on the record under `OPERATOR`.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.core import words
from rosic.core.identity import OPERATOR
from rosic.core.language import clean
from rosic.core.order import Rest
from rosic.errors import NotUnderstood

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterable, Sequence

    from rosic.app.gateway import Gateway
    from rosic.authoriser.directory import Directory
    from rosic.core.identity import Principal
    from rosic.core.robot import RobotId


class Operating:
    """One running gateway."""

    def __init__(self, gateway: Gateway) -> None:
        self._gateway = gateway

    def status(self, names: Sequence[str] = ()) -> tuple[str, ...]:
        """Return a line for each robot.

        Raises:
            NotUnderstood: There is no robot and no group of that name.
        """
        return tuple(self._status(robot) for robot in self._robots(names))

    def _status(self, robot: RobotId) -> str:
        rooms = self._gateway.rooms
        holder = rooms.organiser.holder(robot)
        stopped = rooms.board[robot]
        name_of = rooms.organiser.name_of
        by = (name_of(stopped.by) if stopped.by else "") if stopped.latched else None
        return words.status_line(
            rooms.profiles[robot],
            rooms.linker.presence(robot),
            holder=name_of(holder) if holder else "",
            stopped_by=by,
            waiting=rooms.linker.waiting(robot),
        )

    def _robots(self, names: Sequence[str]) -> tuple[RobotId, ...]:
        rooms = self._gateway.rooms
        if not names:
            return tuple(rooms.profiles)
        found: dict[RobotId, None] = {}
        for name in names:
            robot = rooms.vocabulary.robot(name)
            members = (robot.id,) if robot is not None else rooms.vocabulary.members(name)
            if not members:
                known = ", ".join(rooms.vocabulary.names)
                raise NotUnderstood(f"There is no robot called {name}. There are: {known}.")
            found.update(dict.fromkeys(members))
        return tuple(found)

    async def stop(self, names: Sequence[str] = ()) -> AsyncIterator[str]:
        """Stop robots at once; yield what was done, then what was measured.

        A name that nobody knows stops everything, as in a chat.
        """
        rooms = self._gateway.rooms
        misheard = ""
        try:
            robots = self._robots(names)
        except NotUnderstood as unknown:
            robots = tuple(rooms.profiles)
            misheard = f"{unknown} Everything is stopped.\n"
        halting = self._gateway.stop_lane.stop_robots(robots, OPERATOR)
        yield misheard + words.stopping([rooms.profiles[robot].shown for robot in robots])
        # Waiting is all that may be cut off when whoever asked goes away; the stop goes on.
        await asyncio.wait(halting.rests.values())
        found = [
            Rest(robot, confirmed=False, seconds=0.0) if rest.exception() else rest.result()
            for robot, rest in halting.rests.items()
        ]
        yield words.rests(rooms.profiles, found)
        if not await asyncio.shield(halting.latched):
            yield "This could not be written down: after a restart, look before you move anything."

    def people(self) -> tuple[str, ...]:
        """Return a line for everybody who is known."""
        return people_lines(self._gateway.rooms.authoriser.directory)

    async def revoke(self, name: str) -> str:
        """Take somebody's access back, at once and for ever. Return what was done.

        Raises:
            NotUnderstood: Nobody, or more than one, is called so.
            StoreFault: Not written; they still have access.
        """
        person = the_one(self._gateway.rooms.authoriser.directory, name)
        if not await self._gateway.revoke(person.id, OPERATOR):
            return f"{clean(person.name)} has no access already. Nothing was changed."
        return revoked(person)


def revoked(person: Principal) -> str:
    """Return what is said of somebody whose access has just ended."""
    return f"{clean(person.name)} has no access any more, also after a restart."


def people_lines(directory: Directory) -> tuple[str, ...]:
    """Return a line for everybody: name, roles, addresses, and whether they still have access."""
    people = sorted(directory.people(), key=lambda person: person.name.casefold())
    return tuple(_person(directory, person) for person in people) or ("Nobody is known yet.",)


def _person(directory: Directory, person: Principal) -> str:
    key = directory.key_of(person.id)
    ended = key is None or key.revoked_ns is not None
    access = "access ended" if ended else f"as {_list(person.roles)}"
    return f"{clean(person.name)}: {access} · {_list(map(str, person.addresses))} · {person.id}"


def _list(texts: Iterable[str]) -> str:
    return ", ".join(clean(text) for text in texts) or "nothing"


def the_one(directory: Directory, name: str) -> Principal:
    """Return the person who is called so, or who has that id.

    Raises:
        NotUnderstood: Nobody, or more than one.
    """
    by_id = directory.person(name)
    found = (by_id,) if by_id is not None else directory.named(name)
    if len(found) == 1:
        return found[0]
    if found:
        ids = ", ".join(person.id for person in found)
        raise NotUnderstood(f"Several people are called {name}. Say which by its id: {ids}.")
    known = ", ".join(sorted(clean(person.name) for person in directory.people()))
    raise NotUnderstood(f"Nobody is called {name}. There are: {known or 'nobody yet'}.")
