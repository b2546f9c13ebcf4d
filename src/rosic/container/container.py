"""The paper's container: PROCESSCOMMAND of Algorithm 1, and the durable claim.

Parameters are completed, converted to SI and bounded; then the order is written down; only then
may anything move (I1, I9).
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from functools import partial
from hashlib import blake2b
from typing import TYPE_CHECKING, Final

import msgspec
from msgspec.structs import replace

from rosic.container import records
from rosic.container.bounded_writes import BoundedWriter
from rosic.core.i18n import said
from rosic.core.identity import DIGEST_BYTES
from rosic.core.language import bind, live_words, show
from rosic.core.order import NEVER_BEGUN, Order, OrderEnding, Outcome, Permit, Request, SpokenValue
from rosic.core.records import Claimed, Concluded, Letter, Placed, Refused, Resumed, Selected, Told
from rosic.core.robot.skill import Argument
from rosic.core.signal import Deferred
from rosic.errors import RecordUnavailable, Refusal, Repeated, StoreFault

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from rosic.contracts.clock import Clock
    from rosic.contracts.store import Store
    from rosic.core.identity import Caller, CommandId, PrincipalId
    from rosic.core.language import VocabularyHolder
    from rosic.core.message import Chat
    from rosic.core.robot.profile import RobotId


# ---- units that share nothing (I11) ----

CHATS_AT_MOST = 64
SHARED_BYTES: Final = 8
"""With so many begins what stands for any part of a chat."""


class ChatPeople:
    """Who chose something in a chat, or in parts of it, how often; by the chat, as a look-up."""

    __slots__ = ("_people",)

    def __init__(self) -> None:
        self._people: dict[bytes, dict[PrincipalId, int]] = {}

    def __contains__(self, chat: bytes) -> bool:
        return chat in self._people

    def come(self, chat: bytes, who: PrincipalId) -> None:
        """Count one more choice of somebody."""
        there = self._people.setdefault(chat, {})
        there[who] = there.get(who, 0) + 1

    def leave(self, chat: bytes, who: PrincipalId) -> None:
        """Count one less."""
        there = self._people[chat]
        there[who] -= 1
        if not there[who]:
            del there[who]
            if not there:
                del self._people[chat]

    def of(self, chat: bytes) -> frozenset[PrincipalId]:
        """Return who has made one there."""
        return frozenset(self._people.get(chat, ()))


class PersonContainer:
    """What belongs to one person: which robot they chose, chat by chat.

    Args:
        principal: They.
        there: Who chose something in which chat.
    """

    __slots__ = ("_selected", "_there", "principal")

    def __init__(self, principal: PrincipalId, there: ChatPeople) -> None:
        self.principal = principal
        self._there = there
        self._selected: OrderedDict[bytes, str] = OrderedDict()

    def select(self, chat: bytes, name: str) -> None:
        """Choose a robot or a group for a chat; an empty name undoes the choice."""
        if self._selected.pop(chat, None) is not None:
            self._leave(chat)
        if name:
            self._selected[chat] = name
            self._there.come(chat[:SHARED_BYTES], self.principal)
            if len(self._selected) > CHATS_AT_MOST:
                self._leave(self._selected.popitem(last=False)[0])

    def clear(self) -> None:
        """Undo every choice."""
        while self._selected:
            self._leave(self._selected.popitem()[0])

    def _leave(self, chat: bytes) -> None:
        self._there.leave(chat[:SHARED_BYTES], self.principal)

    def selected(self, chat: bytes) -> str:
        """Return the choice for a chat, empty for none."""
        return self._selected.get(chat, "") if self._selected else ""


class RobotContainer:
    """What belongs to one robot: the number of its last order."""

    __slots__ = ("n", "robot")

    def __init__(self, robot: RobotId, n: int) -> None:
        self.robot = robot
        self.n = n

    def next_number(self) -> int:
        """Return the next order number; numbers skipped by a failed claim stay skipped (I3)."""
        self.n += 1
        return self.n


# ---- PROCESSCOMMAND of Algorithm 1 ----

MET = "met"
MET_BYTES = b"met".ljust(DIGEST_BYTES - SHARED_BYTES, b"\0")
COMPLETED_KEPT = 8_192
UNWRITTEN_KEPT = 10_000
TOLD_TOGETHER = 500
TOO_LATE = said("This was written down too late to be begun. Nothing was done.")
# A member's own value is found by a method in Python, every time.
_NAMED = {ending: ending.value for ending in OrderEnding}
_digest_form = msgspec.json.Encoder(order="sorted").encode


class CompletedOrders(msgspec.Struct, frozen=True, gc=False):
    """What a request comes to: values in SI that nobody changes, how it reads, and a digest."""

    arguments: dict[str, Argument]
    words: str
    digest: bytes


class Containers:
    """One container per principal and per robot, and the record behind them.

    Attributes:
        usual: The robot that somebody means where they chose none.
        here: Returns the robot that a part of a chat is about; empty for none.
    """

    def __init__(
        self,
        vocabularies: VocabularyHolder,
        store: Store,
        clock: Clock,
        numbers: Mapping[RobotId, int],
        usual: Mapping[PrincipalId, str],
    ) -> None:
        self._vocabularies = vocabularies
        self._store = store
        self._bounded = BoundedWriter(store, clock)
        self._clock = clock
        self.here: Deferred[[Chat], str] = Deferred(_nowhere)
        self.usual = usual
        self._people: dict[PrincipalId, PersonContainer] = {}
        self._there = ChatPeople()
        self._unwritten: OrderedDict[CommandId, None] = OrderedDict()
        self._completed: dict[tuple[RobotId, str, tuple[SpokenValue, ...]], CompletedOrders] = {}
        vocabularies.replaced.connect(self._completed.clear)  # worked out with the one before
        self._robots = {robot: RobotContainer(robot, n) for robot, n in numbers.items()}

    def complete(self, request: Request) -> CompletedOrders:
        """Return every parameter of the skill in SI, within its bounds.

        Pure but for a bounded memory: people repeat themselves.

        Raises:
            NotUnderstood, OutOfBounds: With what would be accepted. Nothing was written.
        """
        robot, skill, spoken = request.robot, request.skill, request.spoken
        key = (robot, skill.id, spoken)
        completed = self._completed.get(key)
        if completed is None:
            arguments = bind(self._vocabularies.current, robot, skill, spoken, group=request.group)
            encoded = _digest_form((skill.id, arguments))
            completed = CompletedOrders(
                arguments,
                show(self._vocabularies.current, robot, skill, arguments),
                blake2b(encoded, digest_size=DIGEST_BYTES).digest(),
            )
            if len(self._completed) >= COMPLETED_KEPT:
                self._completed.clear()
            self._completed[key] = completed
        return completed

    async def prepare(
        self,
        permits: Sequence[Permit],
        requests: Sequence[Request],
        reply_to: records.ReplyTo,
    ) -> tuple[Order, ...]:
        """Turn permitted requests into orders and claim them: all on disk, or none exists.

        Raises:
            NotUnderstood, OutOfBounds: Nothing was written.
            Repeated: This message was claimed or refused before. Nothing was written.
            RecordUnavailable: The record cannot be written, or not in time; nothing may move. What
                is on disk later is disowned, and its message counts as refused.
        """
        accepted_ns = self._clock.wall_ns()
        orders: list[Order] = []
        claims: list[Claimed] = []
        for permit, request in zip(permits, requests, strict=True):
            if request.cid in self._unwritten:
                raise Repeated(said("This was already refused."))
            values = self.complete(request)
            n = self._robots[request.robot].next_number()
            orders.append(
                Order(
                    request.cid,
                    request.robot,
                    request.skill,
                    values.arguments,
                    n,
                    request.deadline_ns,
                    request.expires_ns,
                    permit,
                    None,
                    request.sequel,
                    live_words(request.skill) if request.live else values.words,
                    request.live,
                )
            )
            told = records.encode(replace(reply_to, values=values.arguments, live=request.live))
            letter = Letter(permits[0].principal, told)
            claims.append(_claim(request, permit, n, values.digest, accepted_ns, letter))
        try:
            await self._bounded.write(claims, partial(self._disown_late, orders))
        except asyncio.CancelledError as cancelled:
            if cancelled.__cause__ is None:  # claimed, and nobody is left to carry it out
                self._disown(orders, NEVER_BEGUN)
            raise
        except StoreFault as fault:
            raise RecordUnavailable(
                said(
                    "I cannot write down what is decided, so nothing may move. Stop still works. "
                    "The operator has to look at the disk."
                )
            ) from fault
        return tuple(orders)

    def _disown_late(self, orders: Sequence[Order]) -> None:
        """Settle what is on disk too late: its author knows already that nothing was done."""
        self._disown(orders, TOO_LATE)
        self.told(*(order.cid for order in orders))

    def _disown(self, orders: Sequence[Order], why: str) -> None:
        at_ns = self._clock.wall_ns()
        for order in orders:
            letter = Letter(order.permit.principal, why.encode())
            self._store.note(
                Concluded(
                    cid=order.cid, ending=OrderEnding.REFUSED.value, at_ns=at_ns, letter=letter
                )
            )

    async def refuse(
        self, cid: bytes, caller: Caller, refusal: Refusal, answer: records.KeptAnswer
    ) -> None:
        """Write a refusal down before it is told, so that a resend does not get another answer.

        Raises:
            Repeated: It was told before, or carried out.
        """
        letter = Letter(caller.principal, records.encode(answer))
        refused = Refused(
            cid=cid,
            principal=caller.principal,
            code=refusal.code,
            at_ns=self._clock.wall_ns(),
            letter=letter,
        )
        try:
            await self._bounded.write((refused,), _as_said)
        except StoreFault:
            # It stands and is told: the same message must not move anything when the disk is back.
            self._keep_refused(cid)

    def _keep_refused(self, cid: bytes) -> None:
        self._unwritten[cid] = None
        if len(self._unwritten) > UNWRITTEN_KEPT:
            self._unwritten.popitem(last=False)

    def conclude(
        self, order: Order, outcome: Outcome, words: str, at_ns: int, then: Callable[[], None]
    ) -> None:
        """Write an outcome down; then, whether it is on disk or cannot be, call ``then``.

        Args:
            order: Which ended.
            outcome: How.
            words: How that reads.
            at_ns: When, wall clock.
            then: What may be done from then on.
        """
        letter = Letter(order.permit.principal, words.encode("utf-8", "replace"))
        self._store.keep(
            Concluded(cid=order.cid, ending=_NAMED[outcome.ending], at_ns=at_ns, letter=letter),
            then,
        )

    async def place(self, cids: Sequence[bytes], principal: PrincipalId, message: str) -> None:
        """Write down which message shows some lives, before that message says how one ended."""
        try:
            letter = Letter(principal, message.encode("utf-8", "replace"))
            await self._store.write(*(Placed(cid=cid, letter=letter) for cid in cids))
        except StoreFault:
            return  # a later run would say it in a new message

    def note_place(self, cids: Sequence[bytes], principal: PrincipalId, message: str) -> None:
        """Write it down before whatever is written later: before how any of them ends."""
        letter = Letter(principal, message.encode("utf-8", "replace"))
        for cid in cids:  # mostly one
            self._store.note(Placed(cid=cid, letter=letter))

    async def resume(self, cid: bytes, caller: Caller, robot: RobotId, generation: int) -> None:
        """Write a resume down before its effect.

        Raises:
            Repeated: This message resumed before.
            RecordUnavailable: Not written, or not in time: the robot stays stopped, and what is on
                disk later says so.
        """
        try:
            resumed = Resumed(
                cid=cid,
                robot=robot,
                generation=generation,
                principal=caller.principal,
                at_ns=self._clock.wall_ns(),
            )
            await self._bounded.write((resumed,), partial(self.stays_stopped, cid))
        except StoreFault as fault:
            raise RecordUnavailable(
                said("I cannot write this down, so {robot} stays stopped.", robot=robot)
            ) from fault

    def stays_stopped(self, cid: bytes) -> None:
        """Note that a resume which is on disk let no robot go on."""
        at_ns = self._clock.wall_ns()
        self._store.note(Concluded(cid=cid, ending=OrderEnding.REFUSED.value, at_ns=at_ns))

    def told(self, *cids: bytes) -> None:
        """Note that the author knows how these ended; of a card's, all or none are on disk."""
        at_ns = self._clock.wall_ns()
        if len(cids) == 1:
            self._store.note(Told(cids[0], at_ns))
        else:
            for first in range(0, len(cids), TOLD_TOGETHER):
                self._store.note(*[Told(cid, at_ns) for cid in cids[first : first + TOLD_TOGETHER]])

    def selected(self, principal: PrincipalId, chat: Chat) -> str:
        """Return the robot or group that a person chose in a chat, empty for none."""
        container = self._people.get(principal)
        chosen = container.selected(chat_digest(chat)) if container is not None else ""
        chosen = chosen or (self.here(chat) if chat.topic else "")
        return chosen or self.usual.get(principal, "")

    def forget(self, principal: PrincipalId) -> None:
        """Let somebody's choices go: they are erased."""
        if (unit := self._people.pop(principal, None)) is not None:
            unit.clear()

    def select(self, principal: PrincipalId, chat: Chat, name: str) -> None:
        """Choose a robot or a group for a person in a chat."""
        digest = chat_digest(chat)
        self.restore_selection(principal, digest, name)
        self._store.note(Selected(principal=principal, chat=digest, robot=name))

    def serves(self, chat: Chat) -> bool:
        """Whether somebody was recognised or chose a robot in a chat; a look-up."""
        return chat_digest(chat)[:SHARED_BYTES] in self._there

    def company(self, chat: Chat) -> frozenset[PrincipalId]:
        """Return who was recognised or chose a robot in a chat; known after a restart, too."""
        return self._there.of(chat_digest(chat)[:SHARED_BYTES])

    def meet(self, principal: PrincipalId, chat: Chat) -> None:
        """Remember that somebody was recognised in a chat of many, over restarts too."""
        digest, container = met_digest(chat), self._people.get(principal)
        if container is None or not container.selected(digest):
            self._choose(principal, digest, MET)

    def part(self, principal: PrincipalId, chat: Chat) -> None:
        """Forget it, and what they chose there: they have left."""
        for digest in (met_digest(chat), chat_digest(chat)):
            container = self._people.get(principal)
            if container is not None and container.selected(digest):
                self._choose(principal, digest, "")

    def _choose(self, principal: PrincipalId, digest: bytes, name: str) -> None:
        self.restore_selection(principal, digest, name)
        self._store.note(Selected(principal=principal, chat=digest, robot=name))

    def moved(self, old: Chat, new: Chat) -> None:
        """Let what people chose in a chat hold under its new id."""
        there = self.company(old)
        for principal in there:
            self.meet(principal, new)
        before, after = chat_digest(old), chat_digest(new)
        for principal in there:
            if chosen := self._people[principal].selected(before):
                self.restore_selection(principal, after, chosen)
                self._store.note(Selected(principal=principal, chat=after, robot=chosen))

    def restore_selection(self, principal: PrincipalId, chat: bytes, name: str) -> None:
        """Take over a choice from the record."""
        container = self._people.get(principal)
        if container is None:
            container = self._people[principal] = PersonContainer(principal, self._there)
        container.select(chat, name)

    def add_robot(self, robot: RobotId, n: int) -> None:
        """Have a container for one more robot, from the highest number it was given (I3)."""
        self._robots[robot] = RobotContainer(robot, n)


def met_digest(chat: Chat) -> bytes:
    """Return what stands for having been recognised in a chat: as a part of it, which none is."""
    return chat_digest(replace(chat, topic=""))[:SHARED_BYTES] + MET_BYTES


def chat_digest(chat: Chat) -> bytes:
    """Return what stands for a chat, or for a part of it, in the open part of the record.

    The parts of a chat share the first half, so that whoever was in one of them was in the chat.
    """
    whole = blake2b(f"{chat.platform}:{chat.id}".encode(), digest_size=DIGEST_BYTES).digest()
    if not chat.topic:
        return whole
    part = blake2b(chat.topic.encode(), key=whole, digest_size=DIGEST_BYTES - SHARED_BYTES).digest()
    return whole[:SHARED_BYTES] + part


def _as_said() -> None:
    """It was told as it is on disk now."""


def _nowhere(_chat: Chat) -> str:
    """No part of a chat is about any robot."""
    return ""


def _claim(
    request: Request, permit: Permit, n: int, digest: bytes, accepted_ns: int, letter: Letter
) -> Claimed:
    skill = request.skill
    return Claimed(
        cid=request.cid,
        principal=permit.principal,
        key=permit.key,
        robot=request.robot,
        skill=skill.id,
        n=n,
        fence=permit.fence,
        new_fence=permit.new_fence,
        stop_generation=permit.stop_generation,
        epoch=permit.epoch,
        digest=digest,
        accepted_ns=accepted_ns,
        expires_ns=request.sent_ns + skill.order_lifetime_ns,
        letter=letter,
    )
