"""Puts robots among themselves together: who speaks, what they share, who reads along."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.app.documents.shape import Finding
from rosic.contracts.among import Fellow
from rosic.core.identity import ROBOT
from rosic.errors import ConfigurationError
from rosic.pipeline.among.board import Board
from rosic.pipeline.among.clerks import AmongClerk
from rosic.pipeline.among.digests import Digests
from rosic.pipeline.among.fellowship import Circle, Fellowship
from rosic.pipeline.among.guard import Guard
from rosic.pipeline.among.helpdesk import HelpDesk
from rosic.pipeline.among.parts import Around
from rosic.pipeline.among.post import Post
from rosic.pipeline.among.rights import FellowRights
from rosic.pipeline.among.strategies import Strategies
from rosic.pipeline.fleet.assisting import Assisting

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rosic.app.documents.config_file import ConfigFile
    from rosic.app.gateway import Gateway, Parts
    from rosic.core.record import Memory
    from rosic.core.robot import Profile
    from rosic.pipeline.telling import Teller


def fellowship_of(gateway: Gateway, parts: Parts, teller: Teller, memory: Memory) -> Fellowship:
    """Make it for a gateway whose rooms are furnished, and have its robots meet.

    Raises:
        ConfigurationError: A messenger speaks for robots, so anybody there could be one.
    """
    if any(messenger.platform == ROBOT for messenger in parts.messengers):
        raise ConfigurationError(f"No messenger may be called {ROBOT!r}: robots' addresses are.")
    rooms, changes, reach = gateway.rooms, gateway.access.changes, gateway.furnishing.reach
    clock, entropy = parts.clock, parts.entropy
    rights, guard = FellowRights(rooms), Guard()
    board = Board(clock.wall_ns)
    post = Post(rights, board, guard, clock)
    fleet = gateway.furnishing.fleet
    book = fleet.help_book
    around = Around(rights, rooms, changes, reach, post, parts.store, clock, entropy)
    circle = Circle(
        around,
        board,
        guard,
        HelpDesk(book, around),
        Strategies(around),
        Digests(post, rights, rooms.authoriser, teller, reach.messengers),
    )
    fellowship = Fellowship(circle)
    fellowship.restore(memory.facts)
    AmongClerk(fellowship, rooms).employ(gateway.pipeline.reception.office)
    circle.desk.tasks = Assisting(rooms, fleet.dispatching, fleet.watching)
    gateway.holding.also_ends.append(post.end_all)
    gateway.holding.also_ended.append(fleet.dispatching.ended)
    for robot, adapter in gateway.robots.items():
        if isinstance(adapter, Fellow):
            fellowship.join(robot, adapter)
    return fellowship


def robot_findings(file: ConfigFile, robots: Iterable[Profile]) -> Iterator[Finding]:
    """Find principals that are robots which are not there."""
    known = {profile.id for profile in robots}
    for index, person in enumerate(file.principal):
        for address in (person.address, *person.addresses):
            platform, _, robot = address.partition(":")
            if platform == ROBOT and robot not in known:
                yield Finding(
                    ("principal", index),
                    f"{person.name} is to be the robot {robot}, and there is no such [[robot]].",
                    f"There are: {', '.join(sorted(known)) or 'none'}.",
                )
