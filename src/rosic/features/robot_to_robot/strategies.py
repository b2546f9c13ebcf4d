"""adjustStrategy: checked against the profile, applied at its moment, acknowledged, reversible."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.i18n import joined
from rosic.core.identity import REQUEST_ID_BYTES, PrincipalId
from rosic.core.language.arguments import checked, spoken
from rosic.core.language.keywords import parameter_typed
from rosic.core.policy.scope import STRATEGY
from rosic.core.records import Decided, Fact
from rosic.errors import NotUnderstood, Refusal, RobotTaken
from rosic.features.robot_to_robot import messages as words

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.identity import Caller
    from rosic.core.robot.profile import RobotId
    from rosic.features.robot_to_robot.context import RobotToRobotContext

KIND: Final = "strategy"
BACK: Final = "back"
LOOK_EVERY_S: Final = 0.2
IDLE_WITHIN_S: Final = 600.0
ANSWER_WITHIN_S: Final = 10.0

log = logging.getLogger("rosic.robot_to_robot")


class ChosenStrategy(msgspec.Struct, frozen=True, array_like=True):
    """A strategy and its values. An empty name: as the robot works without one."""

    name: str = ""
    values: dict[str, float | str] = {}


class StrategyState(msgspec.Struct, frozen=True, array_like=True):
    """What a robot has taken on, by its own word, and what came before.

    Attributes:
        known: False when it was told and has not answered: perhaps it has.
    """

    now: ChosenStrategy
    before: ChosenStrategy
    by: PrincipalId
    at_ns: int
    known: bool = True


class _Change:
    """One change on its way."""

    def __init__(self, caller: Caller, robot: RobotId, chosen: ChosenStrategy, ident: str) -> None:
        self.caller = caller
        self.robot = robot
        self.chosen = chosen
        self.ident = ident
        self.sent = False
        self.answer: asyncio.Future[tuple[bool, str]] = asyncio.get_running_loop().create_future()
        self.task: asyncio.Task[None] | None = None


_encode = msgspec.msgpack.Encoder().encode
_read = msgspec.msgpack.Decoder(StrategyState).decode


class Strategies:
    """Every robot's strategy. One change a robot is on its way; a further one takes its place."""

    def __init__(self, around: RobotToRobotContext) -> None:
        self._rights = around.rights
        self._rooms = around.rooms
        self._changes = around.changes
        self._reach = around.reach
        self._post = around.post
        self._clock = around.clock
        self._entropy = around.entropy
        self._standing: dict[RobotId, StrategyState] = {}
        self._changing: dict[RobotId, _Change] = {}

    # ---- asking ----

    def now(self, robot: RobotId) -> str:
        """Return what a robot's strategy is, and which there are."""
        shown, declared = self._rights.shown(robot), self._rooms.profiles[robot].strategies
        if not declared:
            return words.no_strategies(shown)
        standing = self._standing.get(robot)
        text = words.strategy_now(shown, self._said(robot, _last(standing)), sorted(declared))
        if standing is None or standing.known:
            return text
        told = words.strategy_unanswered(shown, self._said(robot, standing.now))
        return joined("\n", (text, told))

    async def change(
        self,
        caller: Caller,
        robot: RobotId,
        name: str,
        given: Mapping[str, float | str],
        *,
        idle: bool,
    ) -> str:
        """Have a robot take on another strategy, at its moment. Return what is going to happen.

        Raises:
            NotUnderstood, OutOfBounds: Its profile declares no such thing.
            NotPermitted: They may not adjust this robot.
            RobotTaken: Somebody else has it.
        """
        self._rights.check(caller, robot, STRATEGY)
        chosen = self._chosen(robot, name, given)
        self._check_free(caller, robot)
        before = self._changing.pop(robot, None)
        if before is not None and before.task is not None and not before.sent:
            before.task.cancel()
        made = _Change(caller, robot, chosen, self._entropy.token(REQUEST_ID_BYTES).hex())
        self._changing[robot] = made
        made.task = asyncio.create_task(self._carry_out(made, idle=idle))
        if before is not None and before.task is not None and not before.sent:
            await self._tell(before, words.strategy_replaced(*self._named(before)))
        shown, what = self._named(made)
        return words.strategy_when(shown, what, idle=idle)

    def _chosen(
        self, robot: RobotId, name: str, given: Mapping[str, float | str]
    ) -> ChosenStrategy:
        profile = self._rooms.profiles[robot]
        if name == BACK and BACK not in profile.strategies:
            standing = self._standing.get(robot)
            if standing is None:
                raise NotUnderstood(words.nothing_before(profile.shown))
            return standing.before
        declared = profile.strategies.get(name)
        if declared is None:
            if not profile.strategies:
                raise NotUnderstood(words.no_strategies(profile.shown))
            others = sorted(profile.strategies)
            raise NotUnderstood(words.no_such_strategy(profile.shown, name, others))
        known = declared.parameters
        meant = {parameter_typed(typed, known): value for typed, value in given.items()}
        return ChosenStrategy(name, checked(declared, meant, self._rooms.vocabulary.units))

    def _check_free(self, caller: Caller, robot: RobotId) -> None:
        holder = self._rooms.organiser.holder(robot)
        if holder is not None and holder != caller.principal:
            name = self._rights.name_for(caller, holder)
            raise RobotTaken(words.strategy_taken(self._rights.shown(robot), name))

    # ---- carrying out ----

    async def _carry_out(self, made: _Change, *, idle: bool) -> None:
        try:
            await self._at_its_moment(made, idle=idle)
        except Refusal as refusal:
            await self._tell(made, refusal.sentence)
        except Exception:
            log.exception("the strategy of %s could not be changed", made.robot)
        finally:
            if self._changing.get(made.robot) is made:
                del self._changing[made.robot]

    async def _at_its_moment(self, made: _Change, *, idle: bool) -> None:
        shown, what = self._named(made)
        if idle and not await self._is_idle(made.robot):
            await self._tell(made, words.strategy_late(shown, what))
            return
        self._rights.check(made.caller, made.robot, STRATEGY)  # it may have been long
        self._check_free(made.caller, made.robot)
        before = self._standing.get(made.robot)
        await self._stand(made, before)
        made.sent = True
        heard = self._post.send(
            made.robot,
            {
                "kind": "strategy",
                "id": made.ident,
                "name": made.chosen.name,
                "values": made.chosen.values,
            },
        )
        answered = await self._answered(made) if heard else None
        if not heard:
            await self._write(made.robot, before)
            await self._tell(made, words.strategy_unheard(shown, what))
        elif answered is None:  # what was written before it was sent stays: nobody knows
            await self._tell(made, words.strategy_unknown(shown, what))
        elif answered[0]:
            standing = self._standing[made.robot]
            await self._write(made.robot, msgspec.structs.replace(standing, known=True))
            await self._tell(made, words.strategy_acknowledged(shown, what))
        else:
            await self._write(made.robot, before)
            await self._tell(made, words.strategy_declined(shown, what, answered[1]))

    async def _is_idle(self, robot: RobotId) -> bool:
        end_ns = self._clock.monotonic_ns() + int(IDLE_WITHIN_S * 1e9)
        linker = self._rooms.linker
        while linker.presence(robot).doing or linker.waiting(robot):
            if self._clock.monotonic_ns() >= end_ns:
                return False
            await self._clock.sleep(LOOK_EVERY_S)
        return True

    async def _answered(self, made: _Change) -> tuple[bool, str] | None:
        end_ns = self._clock.monotonic_ns() + int(ANSWER_WITHIN_S * 1e9)
        while not made.answer.done() and self._clock.monotonic_ns() < end_ns:
            await self._clock.sleep(LOOK_EVERY_S)
        return made.answer.result() if made.answer.done() else None

    def acknowledged(self, robot: RobotId, ident: str, why: str, *, ok: bool) -> None:
        """The robot has answered. An answer to what was not asked changes nothing.

        Raises:
            NotUnderstood: It was not asked that.
        """
        made = self._changing.get(robot)
        if made is None or made.ident != ident or not made.sent or made.answer.done():
            raise NotUnderstood(words.not_asked())
        made.answer.set_result((ok, why))

    async def _stand(self, made: _Change, before: StrategyState | None) -> None:
        """Write down what the robot is told before it is: as something that nobody knows yet.

        Raises:
            RecordUnavailable: Not written; it is not told.
        """
        now_ns, by = self._clock.wall_ns(), made.caller.principal
        decided = Decided(
            act="strategy", by=by, about=made.robot, at_ns=now_ns, digest=made.ident.encode()
        )
        standing = StrategyState(made.chosen, _last(before), by, now_ns, known=False)
        async with self._changes.turn() as turn:
            fact = Fact(kind=KIND, key=made.robot, body=_encode(standing))
            await turn.write((decided, fact))

    async def _write(self, robot: RobotId, standing: StrategyState | None) -> None:
        body = b"" if standing is None else _encode(standing)
        async with self._changes.turn() as turn:
            await turn.act((Fact(kind=KIND, key=robot, body=body),))

    # ---- saying ----

    def _named(self, made: _Change) -> tuple[str, str]:
        return self._rights.shown(made.robot), self._said(made.robot, made.chosen)

    def _said(self, robot: RobotId, chosen: ChosenStrategy) -> str:
        declared = self._rooms.profiles[robot].strategies.get(chosen.name)
        if not chosen.name:
            return words.usual()
        title = chosen.name if declared is None or not declared.title else declared.title
        return words.described(title, spoken(chosen.values, declared))

    async def _tell(self, made: _Change, text: str) -> None:
        """Tell whoever asked; a robot that asked, and then the people who operate both."""
        asker = made.caller.address.account if made.caller.address.platform == "robot" else ""
        if not asker:
            self._reach.tell((made.caller.principal,), text)
            return
        self._post.send(asker, {"kind": "note", "about": made.robot, "text": str(text)})
        async for who in self._rights.operators(made.robot):
            self._reach.tell((who,), text)

    # ---- what is so ----

    def apply(self, fact: Fact) -> None:
        """Let a fact be so."""
        if not fact.body:
            self._standing.pop(fact.key, None)
            return
        try:
            self._standing[fact.key] = _read(fact.body)
        except msgspec.MsgspecError:
            log.warning("the strategy of %s cannot be read", fact.key)

    def close(self) -> None:
        """Carry out nothing more."""
        for made in self._changing.values():
            if made.task is not None:
                made.task.cancel()


def _last(standing: StrategyState | None) -> ChosenStrategy:
    """Return what a robot is known to have taken on last."""
    if standing is None:
        return ChosenStrategy()
    return standing.now if standing.known else standing.before
