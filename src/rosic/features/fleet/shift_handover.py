"""``/handover``: a shift ends, and somebody else looks after the tasks and the robots from now on.

Offered by one, accepted by the other; nothing moves because of it. What runs goes on to the end of
its step under the rights of whoever began it; the next step wants the rights of the other.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from msgspec.structs import replace

from rosic.contracts.clock import ClockReading, passed_ns, reading
from rosic.core.fleet import events as e
from rosic.core.message import ChatKind
from rosic.core.records import Decided
from rosic.core.time_units import MINUTE_NS
from rosic.errors import NotPermitted, NotUnderstood
from rosic.features.fleet import shift_handover_messages as words
from rosic.gateway.commands import Reply
from rosic.gateway.person_argument import BY_ID, which_person

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.core.fleet.task import Task
    from rosic.core.identity import Principal, PrincipalId
    from rosic.core.records import Fact
    from rosic.core.robot.profile import RobotId
    from rosic.features.fleet.dispatch_state import TaskText
    from rosic.features.fleet.dispatcher import TaskDispatcher
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.notifier import Notifier

GOOD_FOR_NS: Final = 10 * MINUTE_NS
OPEN_AT_MOST: Final = 100


class HandoverOffer(NamedTuple):
    """Somebody wants to hand over."""

    giver: PrincipalId
    taker: PrincipalId
    made: ClockReading


class ShiftHandoverCommands:
    """The handler of shifts."""

    def __init__(
        self, rooms: Components, dispatching: TaskDispatcher, reach: Notifier, clock: Clock
    ) -> None:
        self._rooms = rooms
        self._dispatching = dispatching
        self._reach = reach
        self._clock = clock
        self._offers: dict[str, HandoverOffer] = {}
        self._count = 0

    def register(self, commands: CommandRegistry) -> None:
        """Take these commands."""
        commands.register("handover", self.handover)

    async def handover(self, asked: CommandContext) -> Reply:
        """Offer everything one looks after to somebody, or answer such an offer.

        Raises:
            NotUnderstood: Nobody is called so, there is nothing, or the offer is over.
            NotPermitted: They could do nothing with it.
        """
        said = asked.rest.split()
        if len(said) == 2 and said[0].casefold() in {"accept", "decline"}:  # noqa: PLR2004 - and its number
            offer = self._taken(asked, said[1])
            if said[0].casefold() == "decline":
                return self._declined(asked, offer)
            return await self._accept(asked, offer)
        found = self._whom(asked, said)
        return found if isinstance(found, Reply) else self._offer(asked, found)

    def _whom(self, asked: CommandContext, said: list[str]) -> Principal | Reply:
        """Return to whom, or the question which of several.

        Raises:
            NotUnderstood: Nobody is called so; or several are, and others read along.
        """
        name = " ".join(said[1:] if said[:1] == ["to"] else said)
        if not name:
            raise NotUnderstood(words.HOW_TO)
        giver, directory = asked.caller.principal, self._rooms.authoriser.directory
        by_id = directory.person(name)
        if by_id is not None and asked.act == BY_ID and by_id.id != giver:
            return by_id
        # Somebody may be called "To Bo", and another Bo.
        called = {p.id: p for n in (" ".join(said), name) for p in directory.called(n)}
        people = [person for person in called.values() if person.id != giver]
        if not people:
            raise NotUnderstood(words.nobody(name))
        if len(people) == 1:
            return people[0]
        return which_person(asked, name, [(one, f"/handover {one.id}", "") for one in people])

    def _offer(self, asked: CommandContext, to: Principal) -> Reply:
        giver, taker = asked.caller.principal, to.id
        tasks, robots = self._tasks(giver), self._idle(giver)
        if not tasks and not robots:
            raise NotUnderstood(words.NOTHING)
        in_vain = [t for t in tasks if not any(self._moves(taker, r) for r in t.among)]
        if in_vain or (not tasks and not any(self._moves(taker, r) for r in robots)):
            raise NotPermitted(words.in_vain(to.name, [task.id for task in in_vain]))
        self._count += 1
        offers = {
            k: o for k, o in self._offers.items() if passed_ns(self._clock, o.made) < GOOD_FOR_NS
        }
        self._offers = dict(list(offers.items())[-OPEN_AT_MOST:])
        self._offers[str(self._count)] = HandoverOffer(giver, taker, reading(self._clock))
        text = words.offered(asked.caller.name, len(tasks), len(robots))
        reached = self._reach.tell((taker,), text, words.choices(str(self._count)))
        if not reached:
            raise NotUnderstood(words.not_reached(to.name))
        return Reply(words.asked(to.name))

    def _taken(self, asked: CommandContext, number: str) -> HandoverOffer:
        offer = self._offers.get(number)
        late = offer is None or passed_ns(self._clock, offer.made) > GOOD_FOR_NS
        if offer is None or late or offer.taker != asked.caller.principal:
            raise NotUnderstood(words.OVER)
        del self._offers[number]
        return offer

    def _declined(self, asked: CommandContext, offer: HandoverOffer) -> Reply:
        self._reach.tell((offer.giver,), words.declined(asked.caller.name))
        return Reply(words.STAYS)

    async def _accept(self, asked: CommandContext, offer: HandoverOffer) -> Reply:
        """Let everything be theirs: tasks, and robots that only idle in the other's hands."""
        organiser, letters = self._rooms.organiser, self._dispatching.letters
        tasks, now_ns = self._tasks(offer.giver), organiser.wall_ns()
        for task in tasks:
            text = letters.get(task.id)
            again = () if text is None else (self._letter(asked, task, text),)
            decided = Decided(
                act="handover", by=offer.giver, about=task.id, at_ns=now_ns, digest=asked.cid
            )
            await self._dispatching.feed(e.TaskHanded(task.id, offer.taker), decided, *again)
        robots = [r for r in self._idle(offer.giver) if self._moves(offer.taker, r)]
        for robot in robots:
            organiser.release(robot)
            organiser.yielded(robot, offer.taker)
        name = organiser.name_of(offer.giver)
        self._reach.tell((offer.giver,), words.accepted(asked.caller.name, len(tasks), len(robots)))
        return Reply(words.yours(name, len(tasks), len(robots)))

    def _letter(self, asked: CommandContext, task: Task, text: TaskText) -> Fact:
        """Return what was said for a task, as theirs who take it over.

        What was given in private is shown to them from now on; what was given in a group, there.
        """
        taker, private = asked.caller.principal, self._reach.chats(asked.caller.principal)
        if text.chat.kind is ChatKind.PRIVATE and private:
            here = [place for place in private if place[0] is asked.messenger]
            messenger, chat = (here or private)[0]
            text = replace(text, messenger=messenger.name, chat=chat)
        return self._dispatching.letters.fact(task.id, taker, text)

    def _tasks(self, who: PrincipalId) -> list[Task]:
        return [task for task in self._dispatching.fleet.open() if task.author == who]

    def _idle(self, who: PrincipalId) -> list[RobotId]:
        """Return the robots that somebody has and lets do nothing now."""
        organiser = self._rooms.organiser
        held = organiser.held_by(who)
        return [robot for robot in held if not organiser.lease(robot).active]

    def _moves(self, who: PrincipalId, robot: RobotId) -> bool:
        return self._rooms.organiser.why_not_move(who, robot) is None
