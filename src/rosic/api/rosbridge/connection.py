"""One client of rosbridge, from its first message to its last."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple, assert_never

from rosic.api.callers import NO_KEY
from rosic.api.connections import frame_of
from rosic.api.rosbridge.drive import TopicDriver
from rosic.api.rosbridge.messages import (
    LEVELS,
    Advertise,
    Authenticate,
    CallService,
    CancelActionGoal,
    Publish,
    RefusedMessage,
    SendActionGoal,
    SetLevel,
    StatusMessage,
    SubscribeTopic,
    Unadvertise,
    Unsubscribe,
    about,
    read,
    written,
)
from rosic.api.rosbridge.shared import RefusalPace
from rosic.api.rosbridge.subscriptions import (
    COMPRESSIONS,
    SubscriptionSettings,
    TopicSubscriptions,
)
from rosic.api.rosbridge.topics import PublishingRight, absolute, no_topic
from rosic.contracts.background_tasks import BackgroundTasks
from rosic.core.i18n import said
from rosic.errors import (
    Fault,
    NotPermitted,
    NotUnderstood,
    RosicError,
    TooManyRequests,
    Unrecognised,
)
from rosic.gateway.send_queue import SendQueue

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    from rosic.api.callers import ApiCaller
    from rosic.api.rosbridge.calls import ClientCalls
    from rosic.api.rosbridge.messages import Heard, HeardOfKnown, Id, Told
    from rosic.api.rosbridge.shared import RosbridgeParts
    from rosic.api.rosbridge.subscriptions import ClientQueue
    from rosic.contracts.graph_topics import OpenedPublisher
    from rosic.core.robot.profile import RobotId

TOPICS_AT_MOST: Final = 128
"""Of one client."""
TASKS_AT_MOST: Final = 128
QUEUE_MOST: Final = 1_000
TRIES: Final = 3
UNKNOWN_BYTES: Final = 4_096
"""Of a message from whoever is not known yet: a key is shorter."""
NO_FRAGMENTS: Final = said("Fragments are not put together here. Send each message whole.")
NO_SERVERS: Final = said("Nobody offers services or actions from here.")
NOT_DONE: Final = said("There is no such op here.")
TOO_MANY_TOPICS: Final = said("You use too many topics already.")
TOO_MUCH: Final = said("Too much of yours is under way. Wait for an answer first.")
STOP_GIVEN: Final = said("The stop was given. Too much of yours is under way to answer it.")
NOT_READABLE: Final = said("That topic is not read from here.")
FRAGMENTS_OUT: Final = said("Messages are sent whole here, whatever their size.")
KNOWN: Final = said("You are known by that key now.")
OTHER_KEY: Final = said("You are known by another key here. Open a connection for each key.")
_SERVING: Final = frozenset(
    {
        "advertise_service",
        "unadvertise_service",
        "service_response",
        "advertise_action",
        "unadvertise_action",
        "action_feedback",
        "action_result",
    }
)


class _Publishing:
    """A topic that this client publishes to, and may as long as its right holds.

    What comes in one step of the loop is sent together after it. A message that is sent by itself
    wakes its subscribers and a thread of DDS, which takes longer than all the rest of its way.

    Args:
        right: Asked before each message.
        publisher: By which it is sent.
        refuse: Tells why a message was not sent.
    """

    def __init__(
        self,
        right: PublishingRight,
        publisher: OpenedPublisher,
        refuse: Callable[[RosicError, Publish], None],
    ) -> None:
        self._right, self._publisher, self._refuse = right, publisher, refuse
        self._waiting: list[tuple[bytes, Publish]] = []

    async def put(self, heard: Publish) -> None:
        """Check a message, and send it after this step of the loop.

        Raises:
            RosicError: It does not fit; nothing was sent.
        """
        content = await self._publisher.packed(heard.msg)
        if not self._waiting:
            asyncio.get_running_loop().call_soon(self.send)
        self._waiting.append((content, heard))

    def send(self) -> None:
        """Send what waits."""
        waiting, self._waiting = self._waiting, []
        for content, heard in waiting:
            try:
                self._right.check()
                self._publisher.send(content)
            except RosicError as why:
                self._refuse(why, heard)


class _Subscription(NamedTuple):
    """A topic that this client is told of, as long as it may see that robot."""

    robot: RobotId
    queue: TopicSubscriptions


class RosbridgeConnection:
    """One client.

    Args:
        parts: What all clients share.
        caller: Who it is; None: nobody yet.

    Attributes:
        caller: Who it is by now.
        queue: What it is yet to be told.
        rejected: It has shown too many keys that are none.
    """

    def __init__(self, parts: RosbridgeParts, caller: ApiCaller | None) -> None:
        self._parts, self.caller = parts, caller
        self.queue: ClientQueue = SendQueue()
        self.rejected = False
        self._level = LEVELS.index("error")
        self._tries = 0
        self._subscriptions: dict[str, _Subscription] = {}
        self._publishing: dict[str, _Publishing | TopicDriver] = {}
        self._calls: ClientCalls | None = None
        self._refusals = RefusalPace()
        self._tasks: BackgroundTasks[None] = BackgroundTasks()
        self._subscribing = asyncio.Lock()

    async def close(self) -> None:
        """The client is gone: nothing of it goes on, and what it drove comes to rest."""
        for used in self._publishing.values():
            if isinstance(used, TopicDriver):
                used.close()
        tasks = tuple(self._tasks)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        for topic, used in self._publishing.items():
            if not isinstance(used, TopicDriver):
                used.send()
                await self._parts.hub.release(topic)
        for topic, (_, queue) in self._subscriptions.items():
            queue.close()
            await self._parts.hub.leave(topic, queue)

    # ---- what it says ----

    async def hear(self, text: str | None) -> None:
        """Follow one message; whatever is wrong with it is told."""
        if text is None or (self.caller is None and len(text) > UNKNOWN_BYTES):
            text = ""
        heard = read(text)
        used = self._publishing.get(absolute(heard.topic)) if isinstance(heard, Publish) else None
        if isinstance(heard, Publish) and used is not None:
            try:
                await self._publish(used, heard)
            except RosicError as why:
                self._refuse_heard(why, heard)
            return
        try:
            await self._follow(heard)
        except RosicError as why:
            self._refuse_heard(why, heard)

    async def _follow(self, heard: Heard | RefusedMessage) -> None:
        if isinstance(heard, RefusedMessage):
            raise NotUnderstood(heard.why or _not_done(heard.op))
        if isinstance(heard, SetLevel):
            if heard.level in LEVELS:
                self._level = LEVELS.index(heard.level)
            return
        if isinstance(heard, Authenticate):
            self._authenticate(heard)
            return
        if self.caller is None:
            raise Unrecognised(NO_KEY)
        await self._done(heard, self.caller)

    async def _done(self, heard: HeardOfKnown, caller: ApiCaller) -> None:
        if isinstance(heard, Publish):
            used = await self._opened(caller, heard.topic, "")
            await self._publish(used, heard)
        elif isinstance(heard, Advertise):
            await self._opened(caller, heard.topic, heard.type)
        elif isinstance(heard, Unadvertise):
            await self._unadvertise(heard)
        elif isinstance(heard, SubscribeTopic):
            self._begin(self._subscribe(caller, heard), heard)
        elif isinstance(heard, Unsubscribe):
            self._begin(self._unsubscribe(heard), heard)
        elif isinstance(heard, CallService | SendActionGoal | CancelActionGoal):
            self._call(heard, caller)
        else:
            assert_never(heard)

    def _authenticate(self, heard: Authenticate) -> None:
        self._tries += 1
        try:
            shown = f"Bearer {heard.key or heard.mac}"
            caller = self._parts.context.callers.identify(shown, "")
        except Unrecognised:
            self.rejected = self._tries >= TRIES
            raise
        if self.caller is not None and self.caller.secret != caller.secret:
            raise NotPermitted(OTHER_KEY)  # what the first one opened would stay open
        self.caller = caller
        self._status("info", KNOWN, heard.id)

    # ---- publishing ----

    async def _publish(self, used: _Publishing | TopicDriver, heard: Publish) -> None:
        if isinstance(used, TopicDriver):
            used.put(heard.msg)
        else:
            await used.put(heard)

    async def _opened(
        self, caller: ApiCaller, topic: str, type_name: str
    ) -> _Publishing | TopicDriver:
        """Return what this client publishes to a topic by.

        Raises:
            RosicError: It may not, or cannot.
        """
        parts, name = self._parts, absolute(topic)
        access = parts.directory.find(caller, name, type_name)
        used = self._publishing.get(name)
        if used is None:
            if len(self._publishing) >= TOPICS_AT_MOST:
                raise TooManyRequests(TOO_MANY_TOPICS, retry_after_s=1.0)
            if access.live is not None:
                refuse = partial(self._refuse_driving, name)
                used = TopicDriver(parts.driven, caller, access.live, self._status, refuse)
            elif not access.right:
                raise NotPermitted(parts.directory.why_closed(access))
            else:
                right = PublishingRight(parts.context, caller, access)
                right.check()
                used = _Publishing(right, await parts.hub.publisher(access), self._refuse_heard)
            self._publishing[name] = used
        return used

    async def _unadvertise(self, heard: Unadvertise) -> None:
        name = absolute(heard.topic)
        used = self._publishing.pop(name, None)
        if used is None:
            self._status("warning", said("You publish to no {topic}.", topic=name), heard.id)
        elif isinstance(used, TopicDriver):
            used.close()
        else:
            used.send()
            await self._parts.hub.release(name)

    # ---- subscribing ----

    async def _subscribe(self, caller: ApiCaller, heard: SubscribeTopic) -> None:
        form = heard.compression or "none"
        if form not in COMPRESSIONS:
            raise NotUnderstood(
                said("{form} is not sent here. There are: none, png, cbor.", form=form[:40])
            )
        access = self._parts.directory.find(caller, heard.topic, heard.type or "")
        if not access.reads:
            raise NotPermitted(NOT_READABLE)
        if heard.fragment_size is not None:
            self._status("warning", FRAGMENTS_OUT, heard.id)
        terms = SubscriptionSettings(
            (heard.throttle_rate or 0) / 1_000, min(heard.queue_length or 0, QUEUE_MOST), form
        )
        async with self._subscribing:
            known = self._subscriptions.get(access.topic)
            if known is None:
                if len(self._subscriptions) >= TOPICS_AT_MOST:
                    raise TooManyRequests(TOO_MANY_TOPICS, retry_after_s=1.0)
                known = _Subscription(access.robot, TopicSubscriptions(access.topic, self.queue))
                known.queue.subscribe(heard.id, terms)
                await self._parts.hub.listen(access, known.queue)
                self._subscriptions[access.topic] = known
            known.queue.subscribe(heard.id, terms)

    async def _unsubscribe(self, heard: Unsubscribe) -> None:
        name = absolute(heard.topic)
        async with self._subscribing:
            known = self._subscriptions.get(name)
            if known is not None and known.queue.unsubscribe(heard.id):
                del self._subscriptions[name]
                await self._parts.hub.leave(name, known.queue)

    def check_sight(self) -> None:
        """End the subscriptions to robots that the client may not see any more, and say so."""
        if self.caller is None or not self._subscriptions:
            return
        seen = self._parts.directory.robots(self.caller)
        gone = [topic for topic, one in self._subscriptions.items() if one.robot not in seen]
        for topic in gone[: TASKS_AT_MOST - len(self._tasks)]:  # the rest at the next look
            over = Unsubscribe(topic)
            self._refuse(no_topic(topic), None, *about(over))
            self._begin(self._unsubscribe(over), over)

    # ---- services and actions ----

    def _call(
        self, heard: CallService | SendActionGoal | CancelActionGoal, caller: ApiCaller
    ) -> None:
        calls = self._calls
        if calls is None:
            calls = self._calls = self._parts.calls_of(caller, self.say)
        if len(self._tasks) >= TASKS_AT_MOST:
            given = isinstance(heard, CallService) and calls.gives_stop(heard)
            raise TooManyRequests(STOP_GIVEN if given else TOO_MUCH, retry_after_s=1.0)
        if isinstance(heard, CallService):
            self._begin(self._noted(calls.call(heard), heard), heard)
        elif isinstance(heard, SendActionGoal):
            self._begin(self._noted(calls.send_goal(heard), heard), heard)
        else:
            self._begin(calls.cancel_goal(heard), heard)

    async def _noted(self, call: Coroutine[Any, Any, RosicError | None], heard: Heard) -> None:
        """Have a refusal written down that was answered already."""
        why = await call
        if why is not None:
            self._note(why, *about(heard))

    def _begin(self, work: Coroutine[Any, Any, None], heard: Heard) -> None:
        if len(self._tasks) >= TASKS_AT_MOST:
            work.close()
            raise TooManyRequests(TOO_MUCH, retry_after_s=1.0)
        self._tasks.begin(self._told(work, heard))

    async def _told(self, work: Coroutine[Any, Any, None], heard: Heard) -> None:
        try:
            await work
        except RosicError as why:
            self._refuse_heard(why, heard)

    # ---- what it is told ----

    def say(self, told: Told) -> None:
        """Tell the client something."""
        frame = frame_of(written(told), text=True)
        self.queue.say(lambda: frame, len(frame))

    def _status(self, level: str, sentence: str, known: Id = None) -> None:
        if LEVELS.index(level) <= self._level:
            text = self._parts.context.callers.read_by(sentence, self.caller)
            self.say(StatusMessage(level, text, known))

    def _refuse(self, why: RosicError, known: Id, op: str, name: str, level: str = "error") -> None:
        """Tell of a refusal, and have it counted; the same at most once a second.

        What has an id is told each time, unless it was published: that comes by the hundred.
        """
        if self._note(why, op, name) or (known is not None and op != "publish"):
            self._status(level, why.sentence, known)

    def _refuse_heard(self, why: RosicError, heard: Heard | RefusedMessage) -> None:
        self._refuse(why, heard.id, *about(heard))

    def _refuse_driving(self, topic: str, why: RosicError, level: str) -> None:
        self._refuse(why, None, "publish", topic, level)

    def _note(self, why: RosicError, op: str, name: str) -> bool:
        """Have a refusal counted and written down. Return whether it is told."""
        now_s = asyncio.get_running_loop().time()
        told, written = self._refusals.meet((op, name, str(why.sentence)[:80]), now_s)
        if told and self.caller is not None and not isinstance(why, Fault):
            asked = f"{op} {name}".rstrip()
            self._parts.refusals.note(self.caller, why, asked, written=written)
        return told


def _not_done(op: str) -> str:
    if op in {"fragment", "png"}:
        return NO_FRAGMENTS
    return NO_SERVERS if op in _SERVING else NOT_DONE
