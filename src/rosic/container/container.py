"""The paper's container: PROCESSCOMMAND of Algorithm 1, and the durable claim.

Parameters are completed, converted to SI and bounded; then the order is written down; only then
may anything move (I1, I9).
"""

from __future__ import annotations

from collections import OrderedDict
from hashlib import blake2b
from typing import TYPE_CHECKING

import msgspec

from rosic.container import letters
from rosic.container.unit import PersonContainer, RobotContainer
from rosic.core.language import bind, show
from rosic.core.order import Order, Outcome, Permit, Request, Spoken
from rosic.core.record import (
    Claimed,
    Concluded,
    Letter,
    Placed,
    Refused,
    Resumed,
    Selected,
    Told,
)
from rosic.core.skill import Argument
from rosic.errors import RecordUnavailable, Refusal, Repeated, StoreFault

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rosic.contracts.clock import Clock
    from rosic.contracts.store import Store
    from rosic.core.identity import Caller, CommandId, PrincipalId
    from rosic.core.language import Vocabulary
    from rosic.core.message import Chat
    from rosic.core.robot import RobotId

DIGEST_BYTES = 16
COMPLETED_KEPT = 8_192
UNWRITTEN_KEPT = 10_000
_digest_form = msgspec.json.Encoder(order="sorted").encode


class Completed(msgspec.Struct, frozen=True, gc=False):
    """What a request comes to: values in SI that nobody changes, how it reads, and a digest."""

    arguments: dict[str, Argument]
    words: str
    digest: bytes


class Containers:
    """One container per principal and per robot, and the record behind them."""

    def __init__(
        self,
        vocabulary: Vocabulary,
        store: Store,
        clock: Clock,
        numbers: Mapping[RobotId, int],
    ) -> None:
        self._vocabulary = vocabulary
        self._store = store
        self._clock = clock
        self._people: dict[PrincipalId, PersonContainer] = {}
        self._unwritten: OrderedDict[CommandId, None] = OrderedDict()
        self._completed: dict[tuple[RobotId, str, tuple[Spoken, ...]], Completed] = {}
        self._robots = {robot: RobotContainer(robot, n) for robot, n in numbers.items()}

    def complete(self, request: Request) -> Completed:
        """Return every parameter of the skill in SI, within its bounds.

        Pure but for a bounded memory: people repeat themselves.

        Raises:
            NotUnderstood, OutOfBounds: With what would be accepted. Nothing was written.
        """
        robot, skill, spoken = request.robot, request.skill, request.spoken
        key = (robot, skill.id, spoken)
        completed = self._completed.get(key)
        if completed is None:
            arguments = bind(self._vocabulary, robot, skill, spoken, group=request.group)
            said = _digest_form((skill.id, arguments))
            completed = Completed(
                arguments,
                show(self._vocabulary, robot, skill, arguments),
                blake2b(said, digest_size=DIGEST_BYTES).digest(),
            )
            if len(self._completed) >= COMPLETED_KEPT:
                self._completed.clear()
            self._completed[key] = completed
        return completed

    async def prepare(
        self,
        permits: Sequence[Permit],
        requests: Sequence[Request],
        reply_to: letters.ReplyTo,
        *,
        start_ns: int | None = None,
    ) -> tuple[Order, ...]:
        """Turn permitted requests into orders and claim them: all on disk, or none exists.

        Raises:
            NotUnderstood, OutOfBounds: Nothing was written.
            Repeated: This message was claimed or refused before. Nothing was written.
            RecordUnavailable: The record cannot be written; nothing may move.
        """
        if any(request.cid in self._unwritten for request in requests):
            raise Repeated("This was already refused.")
        completed = [self.complete(request) for request in requests]
        letter = Letter(permits[0].principal, letters.encode(reply_to))
        accepted_ns = self._clock.wall_ns()
        orders: list[Order] = []
        claims: list[Claimed] = []
        for permit, request, values in zip(permits, requests, completed, strict=True):
            robot = request.robot
            n = self._robots[robot].next_number()
            orders.append(
                Order(
                    request.cid, robot, request.skill, values.arguments, n, request.deadline_ns,
                    permit, start_ns, request.sequel, values.words,
                )
            )  # fmt: skip
            claims.append(_claim(request, permit, n, values.digest, accepted_ns, letter))
        try:
            await self._store.write(*claims)
        except StoreFault as fault:
            raise RecordUnavailable(
                "I cannot write down what is decided, so nothing may move. Stop still works. "
                "The operator has to look at the disk."
            ) from fault
        return tuple(orders)

    async def refuse(
        self, cid: bytes, caller: Caller, refusal: Refusal, answer: letters.Answer
    ) -> None:
        """Write a refusal down before it is told, so that a resend does not get another answer.

        Raises:
            Repeated: It was told before, or carried out.
        """
        letter = Letter(caller.principal, letters.encode(answer))
        refused = Refused(
            cid=cid, principal=caller.principal, code=refusal.code,
            at_ns=self._clock.wall_ns(), letter=letter,
        )  # fmt: skip
        try:
            await self._store.write(refused)
        except StoreFault:
            # It stands and is told: the same message must not move anything when the disk is back.
            self._unwritten[cid] = None
            if len(self._unwritten) > UNWRITTEN_KEPT:
                self._unwritten.popitem(last=False)

    async def conclude(self, order: Order, outcome: Outcome, words: str) -> bool:
        """Write an outcome down before it is told. Return whether it is on disk."""
        concluded = Concluded(
            cid=order.cid, ending=outcome.ending.value, at_ns=self._clock.wall_ns(),
            letter=Letter(order.permit.principal, words.encode("utf-8", "replace")),
        )  # fmt: skip
        try:
            await self._store.write(concluded)
        except StoreFault:
            self._store.note(concluded)  # as soon as it can be: before it counts as told
            return False
        return True

    async def place(self, cid: bytes, principal: PrincipalId, shown: letters.Shown) -> None:
        """Write down which message shows a life, before that message says how it ended."""
        try:
            await self._store.write(
                Placed(cid=cid, letter=Letter(principal, letters.encode(shown)))
            )
        except StoreFault:
            return  # a later run would say it in a new message

    async def resume(self, cid: bytes, caller: Caller, robot: RobotId, generation: int) -> None:
        """Write a resume down before its effect.

        Raises:
            Repeated: This message resumed before.
            RecordUnavailable: Not written; the robot stays stopped.
        """
        try:
            await self._store.write(
                Resumed(
                    cid=cid, robot=robot, generation=generation, principal=caller.principal,
                    at_ns=self._clock.wall_ns(),
                )
            )  # fmt: skip
        except StoreFault as fault:
            raise RecordUnavailable(
                f"I cannot write this down, so {robot} stays stopped."
            ) from fault

    def told(self, *cids: bytes) -> None:
        """Note that the author knows how these ended; all of them, or none, is on disk."""
        at_ns = self._clock.wall_ns()
        self._store.note(*[Told(cid=cid, at_ns=at_ns) for cid in cids])

    def selected(self, principal: PrincipalId, chat: Chat) -> str:
        """Return the robot or group that a person chose in a chat, empty for none."""
        container = self._people.get(principal)
        return container.selected(chat_digest(chat)) if container is not None else ""

    def select(self, principal: PrincipalId, chat: Chat, name: str) -> None:
        """Choose a robot or a group for a person in a chat."""
        digest = chat_digest(chat)
        self.restore_selection(principal, digest, name)
        self._store.note(Selected(principal=principal, chat=digest, robot=name))

    def company(self, chat: Chat) -> frozenset[PrincipalId]:
        """Return who chose a robot in a chat; known after a restart, too."""
        digest = chat_digest(chat)
        return frozenset(p for p, unit in self._people.items() if unit.selected(digest))

    def restore_selection(self, principal: PrincipalId, chat: bytes, name: str) -> None:
        """Take over a choice from the record."""
        container = self._people.get(principal)
        if container is None:
            container = self._people[principal] = PersonContainer(principal)
        container.select(chat, name)


def chat_digest(chat: Chat) -> bytes:
    """Return what stands for a chat in the open part of the record."""
    return blake2b(f"{chat.platform}:{chat.id}".encode(), digest_size=DIGEST_BYTES).digest()


def _claim(
    request: Request, permit: Permit, n: int, digest: bytes, accepted_ns: int, letter: Letter
) -> Claimed:
    skill = request.skill
    return Claimed(
        cid=request.cid, principal=permit.principal, key=permit.key, robot=request.robot,
        skill=skill.id, n=n, fence=permit.fence, new_fence=permit.new_fence,
        stop_generation=permit.stop_generation, epoch=permit.epoch, digest=digest,
        accepted_ns=accepted_ns, expires_ns=request.sent_ns + int(skill.order_lifetime_s * 1e9),
        letter=letter,
    )  # fmt: skip
