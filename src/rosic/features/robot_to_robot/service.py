"""Hears robots, does what they may, and answers them. One robot's words never wait for another's.

It has queues and a pace of its own, and shares nothing with the way of an order or of a stop but
the event loop, of which it takes little: see `Inbox`.
"""

from __future__ import annotations

import asyncio
import logging
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import msgspec

from rosic.contracts.background_tasks import BackgroundTasks
from rosic.contracts.robot import UTTERANCE_BYTES, PeerRobot
from rosic.core.identity import REQUEST_ID_BYTES, PrincipalId
from rosic.core.message import Button
from rosic.core.messages import no_robot
from rosic.core.policy.scope import ASK, READ, SHARE
from rosic.core.records import Decided, Fact
from rosic.core.robot import dialogue_protocol as said_by
from rosic.core.robot.dialogue_protocol import Shared, Utterance, mark_of, read_utterance
from rosic.core.time_units import HOUR_S, SECOND_NS
from rosic.errors import NotPermitted, NotUnderstood, Refusal, TooManyRequests
from rosic.features.robot_to_robot import messages as words
from rosic.features.robot_to_robot.digest import EVERY_S as DIGEST_EVERY_S
from rosic.features.robot_to_robot.help_requests import KIND as HELPS
from rosic.features.robot_to_robot.inbox import CUT_NS, HOPS_AT_MOST, Inbox
from rosic.features.robot_to_robot.shared_state import KIND as SHARED
from rosic.features.robot_to_robot.strategies import KIND as STRATEGIES
from rosic.features.robot_to_robot.subscriptions import KIND as EARS
from rosic.features.robot_to_robot.subscriptions import Subscriber, described
from rosic.organiser.calendar_messages import length

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from rosic.core.identity import Caller
    from rosic.core.robot.profile import RobotId
    from rosic.features.robot_to_robot.context import RobotToRobotContext
    from rosic.features.robot_to_robot.digest import ConversationDigests
    from rosic.features.robot_to_robot.help_service import HelpService
    from rosic.features.robot_to_robot.inbox import LoopGuard
    from rosic.features.robot_to_robot.shared_state import SharedState
    from rosic.features.robot_to_robot.strategies import Strategies
    from rosic.gateway.robot_registry import AddedRobot

    Answer = Mapping[str, object]
    Do = Callable[[Caller, RobotId, Any], Awaitable[Answer]]

QUIET: Final = "robot-quiet"
LOOK_EVERY_S: Final = 0.5
SAVE_EVERY_S: Final = 5.0
NOTICE_LIVES_S: Final = float(HOUR_S)

log = logging.getLogger("rosic.robot_to_robot")


class SilencedRobot(msgspec.Struct, frozen=True, array_like=True):
    """Until when nobody hears a robot, wall clock, and who did that."""

    until_ns: int
    by: PrincipalId


_encode = msgspec.msgpack.Encoder().encode
_read_quiet = msgspec.msgpack.Decoder(SilencedRobot).decode


class PeerGroup(NamedTuple):
    """What robot messaging is made of."""

    around: RobotToRobotContext
    shared_state: SharedState
    guard: LoopGuard
    helping: HelpService
    strategies: Strategies
    digests: ConversationDigests


class RobotMessaging:
    """The robots of one gateway among themselves.

    Attributes:
        circle: Its parts.
        around: What they share.
        inboxes: What waits of each robot's words.
    """

    def __init__(self, circle: PeerGroup) -> None:
        self.circle = circle
        self.around = circle.around
        self.inboxes: dict[RobotId, Inbox] = {}
        self._quiet: dict[RobotId, SilencedRobot] = {}
        self._peopled = asyncio.Event()
        self._do: dict[type, Do] = {
            said_by.Share: self._share,
            said_by.Get: self._get,
            said_by.Follow: self._follow,
            said_by.Unfollow: self._unfollow,
            said_by.AskForHelp: self._ask,
            said_by.Accept: self._accept,
            said_by.Over: self._over,
            said_by.TellRobot: self._tell,
            said_by.Adjust: self._adjust,
        }
        self._warnings: BackgroundTasks[None] = BackgroundTasks()

    # ---- beginning and going on ----

    def restore(self, facts: Mapping[str, tuple[Fact, ...]]) -> None:
        """Take over what earlier runs wrote, and keep what is written from now on."""
        circle, around = self.circle, self.around
        changes = around.changes
        circle.shared_state.restore(facts.get(SHARED, ()))
        for kind, apply in (
            (EARS, around.post.apply),
            (HELPS, circle.helping.book.apply),
            (STRATEGIES, circle.strategies.apply),
            (QUIET, self._apply_quiet),
        ):
            for fact in facts.get(kind, ()):
                apply(fact)
            changes.keep(kind, apply)
        changes.watch(Decided, self._decided)

    def _decided(self, decided: Decided) -> None:
        """Forget what was in a container that is erased."""
        if decided.act == "erase" and decided.about in self.inboxes:
            self.circle.shared_state.forget(decided.about)
            self.circle.helping.book.forget(decided.about)

    def stand_by(self, robot: RobotId, peer: PeerRobot) -> None:
        """Let one that is opened before it takes part say nothing until it does: `join`."""

        def speak(words: bytes, left_out: int) -> None:
            if (inbox := self.inboxes.get(robot)) is not None:
                inbox.put(words, left_out)

        peer.meet(speak)

    def join(self, robot: RobotId, peer: PeerRobot) -> None:
        """Let a robot take part; before it is opened."""
        self.around.post.peers[robot] = peer
        self.inboxes[robot] = Inbox(
            self.around.clock, partial(self._take, robot), partial(self._flooded, robot)
        )
        peer.meet(self.inboxes[robot].put)
        if self.around.rights.principal(robot):
            self._peopled.set()

    def robot_added(self, newcomer: AddedRobot) -> None:
        """Let one more robot take part, if it can."""
        if isinstance(newcomer.robot, PeerRobot):
            self.join(newcomer.profile.id, newcomer.robot)

    async def run(self) -> None:
        """Bring what is late, say digests and write down, until cancelled.

        As long as no robot is a principal none can say anything, and nothing is done.
        """
        circle, around, looks = self.circle, self.around, 0
        try:
            if not any(around.rights.robots()):
                await self._peopled.wait()  # robots become principals at the start, or as they join
            while True:
                await around.clock.sleep(LOOK_EVERY_S)
                looks += 1
                try:
                    await self._look(looks)
                except Exception:
                    log.exception("robots among themselves were not looked after")
        finally:
            for inbox in self.inboxes.values():
                inbox.close()
            for warning in self._warnings:
                warning.cancel()
            circle.strategies.close()
            self._save()

    async def _look(self, looks: int) -> None:
        circle, around = self.circle, self.around
        around.post.catch_up()
        if looks % round(DIGEST_EVERY_S / LOOK_EVERY_S) == 0:
            circle.digests.say()
        if looks % round(SAVE_EVERY_S / LOOK_EVERY_S) == 0:
            self._save()
        try:
            await circle.helping.look(around.clock.wall_ns())
        except Refusal as unwritten:
            log.warning("a request for help could not be ended: %s", unwritten)

    def _save(self) -> None:
        due = self.circle.shared_state.due()
        if due:
            self.around.store.note(*due)

    # ---- hearing ----

    async def _take(self, robot: RobotId, words_: bytes) -> None:
        """Take one utterance: who is it, may they, what does it say, do it."""
        ref = ""
        try:
            utterance = read_utterance(words_, UTTERANCE_BYTES)
            ref = utterance.ref
            answer = await self._heed(robot, utterance)
        except Refusal as refusal:
            ref = ref or mark_of(words_)
            self._answer(robot, ref, {"ok": False, "code": refusal.code, "why": refusal.sentence})
            return
        if ref or answer:
            self._answer(robot, ref, {"ok": True, **answer})

    async def _heed(self, robot: RobotId, utterance: Utterance) -> Answer:
        """Do what a robot says, if it may. Whoever was told how to work may say that it does."""
        if isinstance(utterance, said_by.Acknowledge):
            ident, why, ok = utterance.id, utterance.why, utterance.ok
            self.circle.strategies.acknowledged(robot, ident, why, ok=ok)
            return {}
        caller = self.around.rights.caller(robot)
        if self.quiet(robot) is not None:
            raise NotPermitted(words.silent_until())
        return await self._do[type(utterance)](caller, robot, utterance)

    def _answer(self, robot: RobotId, ref: str, answer: Mapping[str, object]) -> None:
        said = {name: str(v) if isinstance(v, str) else v for name, v in answer.items()}
        self.around.post.send(robot, {"kind": "result", "ref": ref, **said})

    def _new_id(self) -> str:
        return self.around.entropy.token(REQUEST_ID_BYTES).hex()

    # ---- shareData, getSharedData ----

    async def _share(self, caller: Caller, robot: RobotId, said: said_by.Share) -> Answer:
        circle, around = self.circle, self.around
        around.rights.check(caller, robot, SHARE)
        now_ns, hops = around.clock.wall_ns(), circle.guard.hops(said.re)
        cause = circle.guard.cause(said.re)
        if cause is not None and hops > HOPS_AT_MOST:
            await self._cut(robot, cause.robot)
            raise TooManyRequests(words.is_cut(around.rights.shown(cause.robot)), retry_after_s=0.0)
        until_ns = now_ns + int(said.keep_s * 1e9)
        data, ident = bytes(said.data), self._new_id()
        shared = Shared(robot, said.topic, now_ns, until_ns, data, ident, hops)
        circle.shared_state.put(shared)
        circle.guard.remember(ident, robot, hops)
        around.post.bring(shared)
        text = words.shares(around.rights.shown(robot), said.topic, data)
        circle.digests.note(robot, said.topic, text)
        return {"id": ident} if said.ref else {}

    async def _get(self, caller: Caller, _robot: RobotId, said: said_by.Get) -> Answer:
        self.around.rights.check(caller, said.robot, READ)
        shared = self.circle.shared_state.get(said.robot, said.topic)
        if shared is None:
            return {"found": False, "from": said.robot, "topic": said.topic}
        return {"found": True, **described(shared, self.around.clock.wall_ns())}

    async def _follow(self, caller: Caller, robot: RobotId, said: said_by.Follow) -> Answer:
        _circle, around = self.circle, self.around
        around.rights.check(caller, said.robot, READ)
        async with around.changes.turn() as turn:
            fact = around.post.follow(Subscriber(said.robot, said.topic, robot))
            await turn.write(() if fact is None else (fact,))
        return {}

    async def _unfollow(self, _caller: Caller, robot: RobotId, said: said_by.Unfollow) -> Answer:
        _circle, around = self.circle, self.around
        async with around.changes.turn() as turn:
            fact = around.post.unfollow(Subscriber(said.robot, said.topic, robot))
            await turn.write(() if fact is None else (fact,))
        return {}

    # ---- speaking to one another ----

    async def _tell(self, caller: Caller, robot: RobotId, said: said_by.TellRobot) -> Answer:
        circle, around = self.circle, self.around
        now_ns = around.clock.monotonic_ns()
        cause = circle.guard.cause(said.re)
        if cause is None or cause.robot != said.to:  # whoever spoke to it may be answered
            around.rights.check(caller, said.to, ASK)
        if said.to == robot:
            raise NotUnderstood(no_robot(said.to))
        shown, other = around.rights.shown(robot), around.rights.shown(said.to)
        if circle.guard.is_cut(robot, said.to, now_ns):
            raise TooManyRequests(words.is_cut(other), retry_after_s=CUT_NS / 1e9)
        hops = circle.guard.hops(said.re)
        if not circle.guard.passes(robot, said.to, hops, now_ns):
            await self._cut(robot, said.to)
            raise TooManyRequests(words.is_cut(other), retry_after_s=CUT_NS / 1e9)
        ident = self._new_id()
        circle.guard.remember(ident, robot, hops)
        heard = around.post.send(
            said.to,
            {
                "kind": "told",
                "from": robot,
                "data": said.data,
                "id": ident,
                "re": said.re,
                "hops": hops,
            },
        )
        text = words.says_to(shown, other, bytes(said.data))
        circle.digests.note(robot, "", text)
        return {"id": ident, "heard": heard} if said.ref else {}

    async def _cut(self, robot: RobotId, other: RobotId) -> None:
        circle, around = self.circle, self.around
        if not circle.guard.cut(robot, other, around.clock.monotonic_ns()):
            return
        shown, shown_other = around.rights.shown(robot), around.rights.shown(other)
        text = words.cut(shown, shown_other, length(CUT_NS // SECOND_NS))
        await self._warn(text, robot, other)

    def _flooded(self, robot: RobotId) -> None:
        warning = self._warn(words.flood(self.around.rights.shown(robot)), robot)
        self._warnings.begin(warning)

    async def _warn(self, text: str, *robots: RobotId) -> None:
        """Tell those who operate a robot what it does, with what silences it."""
        _circle, around = self.circle, self.around
        log.warning("%s", text)
        async for who in around.rights.operators(*robots):
            row = tuple(
                Button(words.quiet_label(around.rights.shown(robot)), f"/quiet {robot}")
                for robot in robots
                if around.rights.operates(who, robot)
            )
            around.reach.tell((who,), text, (row,), lifetime_s=NOTICE_LIVES_S, still=True)

    # ---- help ----

    async def _ask(self, caller: Caller, robot: RobotId, said: said_by.AskForHelp) -> Answer:
        made = await self.circle.helping.ask(caller, robot, said.what, said.for_s)
        shown = self.around.rights.shown(robot)
        self.circle.digests.note(robot, "", words.open_help(made.id, shown, made.what))
        return {"id": made.id}

    async def _accept(self, caller: Caller, robot: RobotId, said: said_by.Accept) -> Answer:
        text = await self.circle.helping.accept(caller, said.id, robot)
        return {"id": said.id, "text": text}

    async def _over(self, caller: Caller, _robot: RobotId, said: said_by.Over) -> Answer:
        return {"id": said.id, "text": await self.circle.helping.end(caller, said.id)}

    # ---- adjustStrategy ----

    async def _adjust(self, caller: Caller, _robot: RobotId, said: said_by.Adjust) -> Answer:
        text = await self.circle.strategies.change(
            caller, said.robot, said.strategy, said.values, idle=said.when == "idle"
        )
        return {"text": text}

    # ---- silence ----

    def quiet(self, robot: RobotId) -> SilencedRobot | None:
        """Return until when nobody hears a robot, and by whom; None if it is heard."""
        quiet = self._quiet.get(robot)
        return quiet if quiet is not None and self.around.clock.wall_ns() < quiet.until_ns else None

    async def silence(self, robot: RobotId, by: PrincipalId, until_ns: int) -> None:
        """Let nobody hear a robot until a time; with one that is over, it is heard again.

        At once, and written down as soon as it can be: it takes something away.
        """
        now_ns = self.around.clock.wall_ns()
        body = _encode(SilencedRobot(until_ns, by)) if until_ns > now_ns else b""
        decided = Decided(act="robot-quiet", by=by, about=robot, at_ns=now_ns)
        async with self.around.changes.turn() as turn:
            await turn.act((decided, Fact(kind=QUIET, key=robot, body=body)))

    def _apply_quiet(self, fact: Fact) -> None:
        self._quiet.pop(fact.key, None)
        if fact.body:
            try:
                self._quiet[fact.key] = _read_quiet(fact.body)
            except msgspec.MsgspecError:
                log.warning("whether %s is silenced cannot be read", fact.key)
