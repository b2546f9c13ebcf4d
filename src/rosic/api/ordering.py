"""How callers say things: orders, stops, whatever else a chat could say; and how they are answered.

Everything becomes a message that passes the four rooms. An order is known for ever by the key that
its caller gives it: the same again is the same order, and is answered with what became of it.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from rosic.api.lines import message_of_key
from rosic.api.order_feed import order_id
from rosic.api.problems import problem
from rosic.api.recorded_orders import recorded_answer, recorded_order
from rosic.api.schemas import AnswerOut, ChatIn, OrderOut, Problem, StopOut
from rosic.api.stops import EVERYTHING, CallerStops
from rosic.contracts.background_tasks import BackgroundTasks
from rosic.core.i18n import said
from rosic.core.identity import PAGE
from rosic.core.message import AnswerState
from rosic.errors import NotFound, NotUnderstood, Refusal, TooManyRequests
from rosic.gateway.requests import line_id

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.api.order_feed import OrderEntry
    from rosic.api.schemas import OrderIn, PageMessage, StopIn
    from rosic.core.message import Inbound, Outbound
    from rosic.messengers.program.calls import ToolCall

ACCEPTED_WITHIN_S: Final = 10.0
"""So long an order may wait for the rooms before its caller is told that nothing is known of it."""
AGREED_WITHIN_S: Final = 600.0
"""So long what somebody is asked about an order is followed: longer than any question stands."""
STOP_FOLLOWED_S: Final = 60.0
PLACED_KEPT: Final = 4_000
OTHER_ORDER: Final = said("That Idempotency-Key stands for another order. Nothing was done.")
NOBODY_AGREED: Final = said("Nobody has agreed in time. Nothing was done.")
ANSWERED_ELSEWHERE: Final = said(
    "Somebody else was asked, and their answer went to your own chat. What came of it is not "
    "known here."
)
NO_ANSWER: Final = said("It was said, and nothing was answered yet.")
LATE_ANSWER: Final = said(
    "It was said, and its answer is late. It may be done all the same: look before you say it "
    "again."
)
LATE: Final = said("Nothing is known of this order yet. Ask for it by its id; it may go on.")
STOP_GIVEN: Final = said(
    "The stop was given. Whether everything is at rest is not known here; please look."
)
ASKED: Final = "asked"
REFUSED: Final = "refused"
UNKNOWN: Final = "unknown"
_WAITS: Final = frozenset({AnswerState.ASKED.value, AnswerState.AGREED.value})
_SETTLES: Final = frozenset({AnswerState.FINAL.value, AnswerState.NOT_DONE.value})
_GOES_ON: Final = frozenset({AnswerState.GOES_ON, AnswerState.AGREED})


class RefusedOrder(Exception):
    """The rooms have refused it, or are late; the problem says which. No robot has moved by it."""

    def __init__(self, why: Problem) -> None:
        super().__init__(why.detail)
        self.problem = why


class PlacedOrder:
    """An order that a caller has placed in this run.

    Attributes:
        id: Under which it is found, whoever had to agree to it.
        caller: Who placed it.
        inbound: What says it.
        robot, skill: What it is for.
        asked: What somebody is asked before it is done; empty: nobody is.
        questions: Messages of the page that ask its author.
        elsewhere: Somebody else is asked, whose answer its author reads in their own chat.
        entry: The order, once it is accepted; kept when there are many newer ones.
        refused: Why it was refused.
        settled: It is accepted, asked about or refused.
        answered: It is accepted or refused.
    """

    def __init__(self, caller: ApiCaller, inbound: Inbound, robot: str, skill: str) -> None:
        self.id = order_id(line_id(inbound, 0))
        self.caller, self.inbound, self.robot, self.skill = caller, inbound, robot, skill
        self.asked = ""
        self.questions: set[str] = set()
        self.elsewhere = False
        self.entry: OrderEntry | None = None
        self.refused: Problem | None = None
        self.settled, self.answered = asyncio.Event(), asyncio.Event()
        self._until_s = asyncio.get_running_loop().time() + AGREED_WITHIN_S

    @property
    def line(self) -> tuple[str, str]:
        """Whose message it is, and its id."""
        return self.inbound.sender.account, self.inbound.message

    @property
    def met_limit(self) -> bool:
        """Whether it was refused for its time alone."""
        limited = self.refused is not None and self.refused.code == TooManyRequests.code
        return limited and self.entry is None

    def left_s(self) -> float:
        """Return for how many seconds more anybody could agree to it."""
        return max(0.0, self._until_s - asyncio.get_running_loop().time())

    def ask(self, what: str) -> None:
        """Take in that somebody is asked about it."""
        self.asked = what
        self.settled.set()

    def ask_elsewhere(self) -> None:
        """Take in that somebody else is asked, and answers its author elsewhere."""
        self.elsewhere = True

    def accept(self, entry: OrderEntry) -> None:
        """Take in that it is on disk."""
        self.entry = entry
        self.settled.set()
        self.answered.set()

    def refuse(self, why: Problem) -> None:
        """Take in that nothing comes of it."""
        self.refused = why
        self.settled.set()
        self.answered.set()


class CallerRequests:
    """Says what callers want, and waits for what becomes of it."""

    def __init__(self, context: ApiContext) -> None:
        self._context = context
        self._placed: OrderedDict[str, PlacedOrder] = OrderedDict()
        self._by_line: dict[tuple[str, str], PlacedOrder] = {}
        self._changed: dict[str, asyncio.Event] = {}
        self._following: BackgroundTasks[None] = BackgroundTasks()
        self._stops = CallerStops(self._follow_stop)
        context.feed.changed.connect(self._note)
        context.page.news.connect(self._asked_on_page)

    async def close(self) -> None:
        """Follow nothing any more."""
        following = tuple(self._following)
        for task in following:
            task.cancel()
        await asyncio.gather(*following, self._stops.close(), return_exceptions=True)

    # ---- orders ----

    async def place(self, caller: ApiCaller, robot: str, wanted: OrderIn, key: str) -> OrderOut:
        """Place an order, and return what became of it so far.

        Args:
            caller: Who gives it.
            robot: Of which robot.
            wanted: What.
            key: By which the caller knows it; the same again is the same order. Empty: it is new.

        Raises:
            Refusal: It cannot be said so. Nothing was done.
            RefusedOrder: The rooms have refused it.
            MessengerFault: Nobody listens. Nothing was done.
        """
        text = self._context.line(caller, robot, wanted.skill, wanted.arguments)
        placed = await self._begun(caller, robot, wanted, text, key)
        if isinstance(placed, OrderOut):
            return placed
        try:
            async with asyncio.timeout(ACCEPTED_WITHIN_S):
                await placed.settled.wait()
        except TimeoutError:
            return self._shown(placed)
        if placed.refused is not None and placed.entry is None:
            raise RefusedOrder(placed.refused)
        if wanted.wait_s:
            await self._over(placed, wanted.wait_s)
        return self._shown(placed)

    async def _begun(
        self, caller: ApiCaller, robot: str, wanted: OrderIn, text: str, key: str
    ) -> PlacedOrder | OrderOut:
        """Return the order that a key stands for, of this run or an earlier one; or begin it.

        What met a limit was not done, nor written down, and a limit passes: it is tried again.
        """
        message = message_of_key(key)
        inbound = self._context.messenger(caller).inbound(caller.address, text, message)
        order = order_id(line_id(inbound, 0))
        if key and order not in self._placed:  # perhaps it was, in an earlier run
            recorded = await recorded_answer(self._context, caller, order)
            if isinstance(recorded, Problem):
                raise RefusedOrder(recorded)
            if recorded is not None:
                return self._same(recorded, caller, robot, wanted)
        placed = self._placed.get(order)
        if placed is None:
            return self._begin(PlacedOrder(caller, inbound, robot, wanted.skill))
        if placed.inbound.text != text:
            raise self._other_order(caller)
        if placed.met_limit:
            return self._begin(PlacedOrder(caller, inbound, robot, wanted.skill))
        return placed

    def _same(self, recorded: OrderOut, caller: ApiCaller, robot: str, wanted: OrderIn) -> OrderOut:
        """Return an order of an earlier run, if it says the same as this one."""
        same = (recorded.robot, recorded.skill) == (robot, wanted.skill)
        if same and recorded.sent:
            with suppress(Refusal):  # it may be refused by now: then robot and skill must do
                said_now = self._context.check(caller, robot, wanted.skill, wanted.arguments).sent
                same = recorded.sent.endswith(said_now)
        if not same:
            raise self._other_order(caller)
        return recorded

    def _other_order(self, caller: ApiCaller) -> RefusedOrder:
        sentence = self._context.callers.read_by(OTHER_ORDER, caller)
        return RefusedOrder(problem("repeated", sentence))

    def _begin(self, placed: PlacedOrder) -> PlacedOrder:
        call = self._context.begin(placed.caller, placed.inbound, placed.robot)
        self._placed[placed.id] = self._by_line[placed.line] = placed
        if len(self._placed) > PLACED_KEPT:
            _, gone = self._placed.popitem(last=False)
            self._by_line.pop(gone.line, None)
        self._following.begin(self._follow(call, placed))
        return placed

    async def _follow(self, call: ToolCall, placed: PlacedOrder) -> None:
        """Follow an order until it is accepted or refused; or until a person has answered."""
        context, messenger = self._context, self._context.messenger(placed.caller)
        try:
            async with asyncio.timeout(AGREED_WITHIN_S):
                while context.feed[placed.id] is None:
                    message, outbound = await call.news()
                    if outbound.state is AnswerState.AGREED:
                        messenger.begin_agreed(call, message, outbound)
                    elif context.feed[placed.id] is not None:
                        break
                    elif self._is_settled(outbound, placed):
                        return
        except TimeoutError:
            return
        finally:
            placed.settled.set()
            messenger.calls.close(call)

    def _is_settled(self, outbound: Outbound, placed: PlacedOrder) -> bool:
        """Take in an answer of the rooms. Return whether nothing more will be said to a caller."""
        if outbound.state is AnswerState.NOT_DONE:
            code = outbound.code or "order-void"
            offers, again_s = outbound.offers, outbound.retry_after_s
            placed.refuse(problem(code, outbound.text, offers=offers, retry_after_s=again_s))
            return True
        if outbound.state in _GOES_ON:
            return False
        placed.ask(outbound.text)
        return placed.caller.address.platform == PAGE  # their answer is seen there

    def _asked_on_page(self, account: str, message: PageMessage) -> None:
        """Take in what a person is asked of an order in their conversation, and their answer."""
        placed = self._by_line.get((account, self._context.page.line_of(message.id)))
        if placed is None or placed.answered.is_set() or message.own:
            return
        if message.state in _WAITS and message.buttons:
            placed.questions.add(message.id)
        elif message.state == ASKED:
            placed.ask_elsewhere()
        elif message.state in _SETTLES and message.id in placed.questions:
            placed.refuse(problem(message.code or "order-void", message.text))

    def _note(self, entry: OrderEntry) -> None:
        placed = self._placed.get(entry.id)
        if placed is not None:
            placed.accept(entry)
        changed = self._changed.pop(entry.id, None)
        if changed is not None:
            changed.set()

    async def wait(self, entry: OrderEntry, seconds: float) -> None:
        """Wait until an order is over, at most so long."""
        try:
            async with asyncio.timeout(seconds):
                while not entry.is_over:
                    await self._changed.setdefault(entry.id, asyncio.Event()).wait()
        except TimeoutError:
            return

    async def order(self, caller: ApiCaller, order: str, wait_s: float) -> OrderOut:
        """Return an order, once it is over or after so many seconds; what is asked about, too.

        Raises:
            NotFound: There is none, as far as they may see.
        """
        placed = self._placed.get(order)
        if placed is not None and placed.caller.principal == caller.principal:
            self._context.profile(caller, placed.robot)
            await self._over(placed, wait_s)
            return self._shown(placed)
        try:
            entry = self._context.entry(caller, order)
        except NotFound:
            recorded = await recorded_order(self._context, caller, order)
            if recorded is None:
                raise
            return recorded
        if wait_s:
            await self.wait(entry, wait_s)
        return self._context.shown(entry, caller)

    def robot_of(self, caller: ApiCaller, order: str) -> str:
        """Return whose order it is.

        Raises:
            NotFound: There is none, as far as they may see.
        """
        placed = self._placed.get(order)
        if placed is not None and placed.caller.principal == caller.principal:
            return placed.robot
        return self._context.entry(caller, order).robot

    async def _over(self, placed: PlacedOrder, seconds: float) -> None:
        """Wait until nothing more comes of an order, at most so long."""
        try:
            async with asyncio.timeout(seconds):
                async with asyncio.timeout(placed.left_s()):
                    await placed.answered.wait()
                if placed.entry is not None:
                    await self.wait(placed.entry, seconds)
        except TimeoutError:
            return

    def _shown(self, placed: PlacedOrder) -> OrderOut:
        """Return an order as it is shown to whoever placed it."""
        context, caller = self._context, placed.caller
        entry = context.feed[placed.id] or placed.entry
        if entry is not None:
            return context.shown(entry, caller)
        late = bool(placed.asked) and not placed.left_s()
        if late and not placed.elsewhere and placed.refused is None:
            sentence = context.callers.read_by(NOBODY_AGREED, caller)
            placed.refuse(problem("expired", sentence))
        if (why := placed.refused) is not None:
            state, text, code = REFUSED, why.detail, why.code
        elif placed.asked and not late:
            state, text, code = ASKED, placed.asked, ""
        else:
            sentence = ANSWERED_ELSEWHERE if late else LATE
            state, text, code = UNKNOWN, context.callers.read_by(sentence, caller), ""
        return OrderOut(
            placed.id,
            placed.robot,
            placed.skill,
            state,
            over=late or why is not None,
            who=caller.name,
            code=code,
            text=text,
        )

    # ---- stops ----

    async def stop(self, caller: ApiCaller, wanted: StopIn) -> StopOut:
        """Stop robots; it overtakes, and nothing that the caller waits for counts against it.

        A name that is none of a robot that they may see stops all of them.

        Raises:
            MessengerFault: Nobody listens. Nothing was stopped.
        """
        try:
            async with asyncio.timeout(wanted.wait_s):
                return await asyncio.shield(self.give_stop(caller, wanted.robots))
        except TimeoutError:
            return StopOut(None, self._context.callers.read_by(STOP_GIVEN, caller))

    def give_stop(self, caller: ApiCaller, robots: Iterable[str]) -> asyncio.Future[StopOut]:
        """Give a stop, as `stop` does, and wait for nothing."""
        named, visible = frozenset(robots), self._context.visible(caller)
        return self._stops.give(caller, named if named <= visible else EVERYTHING)

    async def _follow_stop(self, caller: ApiCaller, robots: frozenset[str]) -> StopOut:
        messenger = self._context.messenger(caller)
        inbound = messenger.inbound(caller.address, " ".join(("stop", *sorted(robots))))
        call = messenger.begin(inbound)
        try:
            async with asyncio.timeout(STOP_FOLLOWED_S):
                while True:
                    _, outbound = await call.news()
                    if outbound.state is not AnswerState.GOES_ON:
                        return StopOut(outbound.state is AnswerState.DONE, outbound.text)
        except TimeoutError:
            return StopOut(None, self._context.callers.read_by(STOP_GIVEN, caller))
        finally:
            messenger.calls.close(call)

    # ---- whatever else a chat could say ----

    async def say(self, caller: ApiCaller, wanted: ChatIn) -> AnswerOut:
        """Say something as in a chat, or tap a button, and return the first answer.

        Raises:
            NotUnderstood: Nothing is said. Nothing was done.
            MessageGone: There is no such button. Nothing was done.
            MessengerFault: Nobody listens. Nothing was done.
        """
        return await self._answer(caller, wanted, frozenset())

    async def _answer(
        self, caller: ApiCaller, wanted: ChatIn, besides_these: frozenset[AnswerState]
    ) -> AnswerOut:
        """Say something, and return the first answer whose state is none of these."""
        call = self._said(caller, wanted)
        messenger = self._context.messenger(caller)
        try:
            async with asyncio.timeout(wanted.wait_s):
                while True:
                    message, outbound = await call.news()
                    if outbound.state is AnswerState.AGREED:
                        messenger.begin_agreed(call, message, outbound)
                        continue
                    if outbound.state in besides_these:
                        continue
                    besides = messenger.unsolicited.take(caller.address.account)
                    state, again_s = outbound.state.value, outbound.retry_after_s
                    return AnswerOut(outbound.text, state, outbound.code, besides, again_s)
        except TimeoutError:
            sentence = self._context.callers.read_by(NO_ANSWER, caller)
            return AnswerOut(sentence, AnswerState.GOES_ON.value)
        finally:
            messenger.calls.close(call)

    async def command(self, caller: ApiCaller, line: str) -> AnswerOut:
        """Say one line, and return its answer.

        Raises:
            RefusedOrder: It was refused; the problem says why. Nothing was changed by it.
            MessengerFault: Nobody listens. Nothing was done.
        """
        return _taken(await self.say(caller, ChatIn(text=line)))

    async def settled(self, caller: ApiCaller, line: str) -> AnswerOut:
        """Say one line, and return the answer after which nothing more is said of it.

        Raises:
            RefusedOrder: As of `command`; or that answer did not come in time (``late``), and it
                may be done all the same.
            MessengerFault: Nobody listens. Nothing was done.
        """
        answer = _taken(
            await self._answer(caller, ChatIn(text=line), frozenset({AnswerState.GOES_ON}))
        )
        if answer.state == AnswerState.GOES_ON.value:
            raise RefusedOrder(problem("late", self._context.callers.read_by(LATE_ANSWER, caller)))
        return answer

    def _said(self, caller: ApiCaller, wanted: ChatIn) -> ToolCall:
        context = self._context
        if wanted.button and caller.address.platform == PAGE:
            return context.page.tap(caller.address, wanted.message, wanted.button)
        if not wanted.text.strip():
            raise NotUnderstood(said("Nothing was said."))
        messenger = context.messenger(caller)
        return context.begin(caller, messenger.inbound(caller.address, wanted.text))


def _taken(answer: AnswerOut) -> AnswerOut:
    """Return an answer that is no refusal.

    Raises:
        RefusedOrder: It is one.
    """
    if answer.state == AnswerState.NOT_DONE.value:
        code, again_s = answer.code or "order-void", answer.retry_after_s
        raise RefusedOrder(problem(code, answer.text, retry_after_s=again_s))
    return answer
