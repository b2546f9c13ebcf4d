"""When an interpreter is asked, for whom, how often; and what becomes of its answer."""

from __future__ import annotations

import logging
from collections import Counter, OrderedDict
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.container.preferences import OFF, TOLD
from rosic.contracts.background_tasks import BackgroundTasks
from rosic.contracts.interpreter import AnswerKind
from rosic.core.language.stop_detection import speaks_of_stop
from rosic.core.message import Button, ChatKind
from rosic.core.rate_limit import Bucket, RateLimit
from rosic.core.time_units import MINUTE_NS
from rosic.errors import Refusal
from rosic.features.interpreter import messages as words
from rosic.features.interpreter.prompt import instructions_for, is_withheld, without_names
from rosic.gateway.commands import Reply, asks_first
from rosic.gateway.replies import LEAVE, LEAVE_IT
from rosic.gateway.requests import is_missed

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Iterator

    from rosic.container.preferences import PreferenceBook
    from rosic.contracts.clock import Clock
    from rosic.contracts.interpreter import Interpreter
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Inbound
    from rosic.core.robot.profile import RobotId
    from rosic.features.interpreter.proposals import ProposalReader
    from rosic.gateway.components import Components
    from rosic.gateway.message_context import MessageContext
    from rosic.gateway.pipeline import Pipeline
    from rosic.gateway.transactions import Transactions

AT_ONCE: Final = 4
"""So many are asked about at once, of everybody together; of one person, one."""
RATE: Final = RateLimit(burst=3.0, per_s=0.2)
"""Of one person."""
PEOPLE_AT_MOST: Final = 10_000
PENDING_NS: Final = 5 * MINUTE_NS
"""So long a line waits for its author to say whether it may be shown."""
ON_COMMAND, OFF_COMMAND = "/interpreter on", "/interpreter off"

log = logging.getLogger("rosic.interpreter")


class InterpreterParts(NamedTuple):
    """What whoever asks an interpreter is made from.

    Attributes:
        rooms: What can be said, and by whom.
        pipeline: Hands over what was proposed.
        proposals: Reads what comes back.
        preferences: Who has said no.
        changes: Writes down who was told.
        codes_in: Returns the invitation codes that a text shows.
        clock: Of the gateway.
    """

    rooms: Components
    pipeline: Pipeline
    proposals: ProposalReader
    preferences: PreferenceBook
    changes: Transactions
    codes_in: Callable[[str], tuple[str, ...]]
    clock: Clock


class InterpreterClient:
    """Asks an interpreter about lines that were refused because they could not be read.

    Nobody waits for it: the refusal is told before. What it answers becomes buttons, or nothing.

    Attributes:
        counts: What came of asking, by its name; no text of anybody is in it.
    """

    def __init__(self, interpreter: Interpreter, parts: InterpreterParts) -> None:
        self.counts: Counter[str] = Counter()
        self._interpreter = interpreter
        self._parts = parts
        self._rooms = parts.rooms
        self._tasks: BackgroundTasks[None] = BackgroundTasks()
        self._engaged: set[PrincipalId] = set()
        self._buckets: OrderedDict[PrincipalId, Bucket] = OrderedDict()
        self._pending: OrderedDict[PrincipalId, tuple[MessageContext, int]] = OrderedDict()
        self._logged: Counter[str] = Counter()

    @property
    def where(self) -> str:
        """Whose machine reads what is shown; empty for this one."""
        return self._interpreter.where

    @property
    def quiet(self) -> bool:
        """Whether nothing is being asked."""
        return not self._tasks

    # ---- whether it is asked ----

    def hear(self, message: MessageContext) -> None:
        """Begin to ask what a line may mean, if that may be asked. Returns at once.

        Not where it speaks of stopping: its author is offered that alone.
        """
        vocabulary = self._rooms.vocabulary
        if not _is_meant(message.inbound) or speaks_of_stop(message.text, vocabulary.known):
            return
        who, parts = message.caller.principal, self._parts
        state = parts.preferences.of(who).interpreter
        if state == OFF or who in parts.preferences.damaged():
            return
        if is_withheld(message.text, vocabulary, vocabulary.commands, parts.codes_in):
            self.counts["withheld"] += 1
        elif state:
            self._begin(who, self._ask(message))
        elif message.inbound.chat.kind is ChatKind.PRIVATE:
            self._begin(who, self._tell(message))

    def allowed(self, who: PrincipalId) -> None:
        """Show the line that somebody was asked about, now that they have said yes."""
        message, until_ns = self._pending.pop(who, (None, 0))
        if message is not None and self._parts.clock.monotonic_ns() < until_ns:
            self._begin(who, self._ask(message))

    def forget(self, who: PrincipalId) -> None:
        """Forget the line that waits for somebody to say whether it may be shown."""
        self._pending.pop(who, None)

    async def erase(self, who: PrincipalId) -> None:
        """Forget whatever is remembered of somebody."""
        self.forget(who)
        self._buckets.pop(who, None)

    def _begin(self, who: PrincipalId, work: Coroutine[object, object, None]) -> None:
        """Do something for somebody, if not too much is being done; else it is dropped."""
        if who in self._engaged or len(self._tasks) >= AT_ONCE or self._is_too_often(who):
            work.close()
            self.counts["dropped"] += 1
            return
        self._engaged.add(who)
        task = self._tasks.begin(work)
        task.add_done_callback(lambda done: self._ended(who, done.cancelled() or done.exception()))

    def _ended(self, who: PrincipalId, fault: BaseException | bool | None) -> None:
        self._engaged.discard(who)
        if isinstance(fault, BaseException):
            # Its text may hold what was asked; its kind does not.
            log.error("asking the interpreter failed: %s", type(fault).__name__)
            self.counts["failed"] += 1

    def _is_too_often(self, who: PrincipalId) -> bool:
        now_ns = self._parts.clock.monotonic_ns()
        bucket = self._buckets.setdefault(who, Bucket(RATE, now_ns))
        self._buckets.move_to_end(who)
        if len(self._buckets) > PEOPLE_AT_MOST:
            self._buckets.popitem(last=False)
        return bucket.take(now_ns) > 0

    # ---- asking ----

    async def _tell(self, message: MessageContext) -> None:
        """Tell somebody, once, of the interpreter, before anything of theirs is shown to it."""
        who, parts = message.caller.principal, self._parts
        try:
            async with parts.changes.turn() as turn:
                if parts.preferences.of(who).interpreter:
                    return
                await turn.write(parts.preferences.set_interpreter(who, TOLD))
        except Refusal:
            self.counts["untold"] += 1  # so nothing of theirs is shown
            return
        self._pending[who] = message, parts.clock.monotonic_ns() + PENDING_NS
        if len(self._pending) > PEOPLE_AT_MOST:
            self._pending.popitem(last=False)
        row = (Button(words.SHOW_IT, ON_COMMAND), Button(words.NEVER, OFF_COMMAND))
        self._say(message, Reply(words.notice(self.where), (row,)))

    async def _ask(self, message: MessageContext) -> None:
        who, rooms = message.caller.principal, self._rooms
        vocabulary = rooms.vocabulary
        selected = self._selected(who, message)
        line = without_names(message.text, vocabulary, rooms.authoriser.directory.named)
        instructions = await instructions_for(
            vocabulary,
            self._likely(who, selected, line),
            selected,
            lambda robot, skill: rooms.organiser.rights.widest(
                who, robot, skill, rooms.organiser.wall_ns()
            ),
        )
        answer = await self._interpreter.ask(instructions, line)
        self.counts[answer.kind.value] += 1
        if answer.kind is not AnswerKind.ANSWERED or not self._may_be_told(who):
            return
        chat = message.inbound.chat
        buttons = await self._parts.proposals.read(answer.text, message.caller, chat)
        if not buttons:
            self.counts["nothing to propose"] += 1
            return
        self.counts["proposed"] += 1
        rows = (*((button,) for button in buttons), (Button(LEAVE_IT, LEAVE),))
        self._say(message, asks_first(words.proposed([b.label for b in buttons]), rows))

    def _selected(self, who: PrincipalId, message: MessageContext) -> str:
        """Return whom somebody means where they name none, if they see it still; else nothing."""
        chosen = self._rooms.container.selected(who, message.inbound.chat)
        called, visible = self._rooms.vocabulary.callees.get(chosen), self._rooms.organiser.visible
        seen = called is not None and any(each.id in visible(who) for each in called.robots)
        return chosen if seen else ""

    def _may_be_told(self, who: PrincipalId) -> bool:
        """Whether somebody is still here, and has not said no meanwhile."""
        rooms, kept = self._rooms, self._parts.preferences.of(who)
        known = rooms.authoriser.directory.has_good_key(who)
        return known and who not in rooms.organiser.locked and kept.interpreter not in {OFF, ""}

    def _likely(self, who: PrincipalId, selected: str, line: str) -> Iterator[RobotId]:
        """Yield the robots that somebody sees: first whom they chose, and whom the line names."""
        vocabulary, visible = self._rooms.vocabulary, self._rooms.organiser.visible(who)
        named = (vocabulary.callees.get(word) for word in (selected, *line.casefold().split()))
        first = dict.fromkeys(r.id for each in named if each for r in each.robots)
        yield from (robot for robot in first if robot in visible)
        yield from (r for r in vocabulary.profiles if r in visible and r not in first)

    def _say(self, message: MessageContext, reply: Reply) -> None:
        self._parts.pipeline.answer(message.messenger, message.inbound, message.caller, reply)

    # ---- by itself ----

    def note(self) -> None:
        """Log what came of asking since the last time, in numbers alone; forget what waits long."""
        now_ns = self._parts.clock.monotonic_ns()
        for who in [who for who, (_, until_ns) in self._pending.items() if until_ns <= now_ns]:
            self.forget(who)
        since = self.counts - self._logged
        if since:
            log.info("%s", ", ".join(f"{what}: {n}" for what, n in sorted(since.items())))
            self._logged = self.counts.copy()

    def close(self) -> None:
        """Cut off what is being asked; nobody is answered any more."""
        for task in tuple(self._tasks):
            task.cancel()
        self._pending.clear()


def _is_meant(inbound: Inbound) -> bool:
    """Whether a message is one that somebody just wrote to ROSIC, and nothing but words."""
    if inbound.nonce is not None or inbound.enclosed is not None or inbound.place is not None:
        return False
    private = inbound.chat.kind is ChatKind.PRIVATE
    return (private or inbound.addressed) and not inbound.links and not is_missed(inbound)
