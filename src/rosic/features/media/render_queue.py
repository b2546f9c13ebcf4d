"""Where pictures are made: one at a time for each robot, a few at once, off the event loop.

A picture is held until it was sent, so that what waits to be sent is bounded by what may be made.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import msgspec

from rosic.core.i18n import in_language
from rosic.core.message import Attachment, Button, Outbound
from rosic.core.rate_limit import Bucket, RateLimit
from rosic.core.robot.view import Subject
from rosic.errors import MessengerFault, NothingToSee, NotPermitted, Refusal, TooManyRequests
from rosic.features.media import messages as words
from rosic.gateway.delivery.sender import OutgoingMessage
from rosic.gateway.delivery.translation import translated
from rosic.gateway.replies import reply_id

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.contracts.renderer import Renderer
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.view import Drawing
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.delivery.sender import ChatSender

AT_ONCE = 4
DRAWN_AT_ONCE = 2
LIMIT = RateLimit(burst=10.0, per_s=0.2)
SEND_WITHIN_S = 90.0
SOON_S = 2.0
ENDINGS = {"image/jpeg": "jpg", "image/png": "png", "image/gif": "gif"}

log = logging.getLogger("rosic.media")


class RenderJob(msgspec.Struct, frozen=True):
    """Something to be drawn and shown.

    Attributes:
        caption: Asked when it is drawn, so that its age is true then.
        name: Of the file, without ending.
        deliver: Takes it, where it is no message of its own.
    """

    subject: Subject
    caption: Callable[[], str]
    name: str
    low: bool = False
    buttons: tuple[tuple[Button, ...], ...] = ()
    deliver: Callable[[Outbound], Awaitable[None]] | None = None


class RenderQueue:
    """Makes pictures and sends them to whoever asked."""

    def __init__(
        self,
        renderer: Renderer | None,
        chat_sender: ChatSender,
        clock: Clock,
        *,
        may_see: Callable[[PrincipalId, RobotId], bool],
        issue: Callable[[Button, PrincipalId, str], Button],
        shown: Callable[[RobotId], str],
    ) -> None:
        self._renderer = renderer
        self._chat_sender = chat_sender
        self._clock = clock
        self._may_see = may_see
        self._issue = issue
        self._shown = shown
        self._buckets: dict[PrincipalId, Bucket] = {}
        self._tasks: dict[str, asyncio.Task[Any]] = {}
        self._drawing = asyncio.Semaphore(DRAWN_AT_ONCE)

    @property
    def works(self) -> bool:
        """Whether anything can be drawn at all."""
        return self._renderer is not None

    @property
    def quiet(self) -> bool:
        """Whether no picture is being made."""
        return not self._tasks

    def begin(
        self,
        asked: CommandContext,
        robot: RobotId,
        cost: float,
        take: Callable[[], Awaitable[RenderJob]],
        *,
        kept: str = "",
        unasked: bool = False,
    ) -> None:
        """Make a picture in a task of its own: looking takes seconds, and nobody waits for it.

        Args:
            asked: By whom, where.
            robot: Of which robot.
            cost: In pictures.
            take: Looks.
            kept: What is drawn from memory, so that the robot is not looked at.
            unasked: Nobody has asked for just this one: it leaves half of the places to others, and
                if it comes to nothing, nothing is said.

        Raises:
            NothingToSee: Pictures cannot be drawn or sent here.
            TooManyRequests: Not now. Nothing was begun.
        """
        if self._renderer is not None and asked.messenger.file_bytes <= 0:
            raise NothingToSee(words.NO_FILES)
        key = f"{robot} {kept}"
        self._check_room(key, robot, AT_ONCE // 2 if unasked else AT_ONCE)
        self._charge(asked.caller.principal, cost)
        say = _nothing if unasked else self._say
        self._follow(key, asyncio.create_task(self._make(asked, robot, take, say)))

    async def drawn(
        self,
        who: PrincipalId,
        robot: RobotId,
        cost: float,
        take: Callable[[], Awaitable[RenderJob]],
    ) -> Drawing:
        """Make a picture for somebody who waits for it, and is sent no message.

        Raises:
            NothingToSee: Nothing is shown, or pictures cannot be drawn here.
            TooManyRequests: Not now. Nothing was begun.
            NotPermitted: They may not see that robot any more.
        """
        key = f"{robot} "
        self._check_room(key, robot, AT_ONCE)
        self._charge(who, cost)
        task = asyncio.create_task(self._drawn(who, take))
        self._follow(key, task)
        drawing = await task
        if not self._may_see(who, robot):  # seconds have passed since it was asked
            raise NotPermitted(words.GONE)
        return drawing

    def _check_room(self, key: str, robot: RobotId, most: int) -> None:
        if self._renderer is None:
            raise NothingToSee(words.NO_RENDERER)
        if key in self._tasks:
            sentence = words.somebody_looks(self._shown(robot))
            raise TooManyRequests(sentence, retry_after_s=SOON_S)
        if len(self._tasks) >= most:
            raise TooManyRequests(words.too_many_look(), retry_after_s=SOON_S)

    def _follow(self, key: str, task: asyncio.Task[Any]) -> None:
        self._tasks[key] = task
        task.add_done_callback(lambda _: self._tasks.pop(key, None))

    async def _drawn(self, who: PrincipalId, take: Callable[[], Awaitable[RenderJob]]) -> Drawing:
        return await self._draw(await take(), who)

    async def _draw(self, shot: RenderJob, who: PrincipalId) -> Drawing:
        renderer = self._renderer
        assert renderer is not None  # noqa: S101 - nothing is begun without one
        async with self._drawing:
            say = partial(in_language, catalogue=self._chat_sender.languages.of(who))
            return await asyncio.to_thread(renderer, shot.subject, low=shot.low, say=say)

    def _charge(self, principal: PrincipalId, cost: float) -> None:
        now_ns = self._clock.monotonic_ns()
        bucket = self._buckets.get(principal)
        if bucket is None:
            bucket = self._buckets[principal] = Bucket(LIMIT, now_ns)
        wait_s = bucket.take(now_ns, cost)
        if wait_s:
            raise TooManyRequests(words.too_often(wait_s), retry_after_s=wait_s)

    async def _make(
        self,
        asked: CommandContext,
        robot: RobotId,
        take: Callable[[], Awaitable[RenderJob]],
        tell: Callable[[CommandContext, str], None],
    ) -> None:
        try:
            shot = await take()
            drawing = await self._draw(shot, asked.caller.principal)
            await self._send(asked, robot, shot, drawing)
        except Refusal as refusal:
            tell(asked, refusal.sentence)
        except (MessengerFault, TimeoutError) as fault:
            log.warning("a picture was not sent: %s", fault)
            tell(asked, words.NOT_SENT)
        except Exception:
            log.exception("a picture could not be made")
            tell(asked, words.BROKEN)

    async def _send(
        self, asked: CommandContext, robot: RobotId, shot: RenderJob, drawing: Drawing
    ) -> None:
        principal, inbound = asked.caller.principal, asked.inbound
        if not self._may_see(principal, robot):  # seconds have passed since it was asked
            raise NotPermitted(words.GONE)
        bound = tuple(
            tuple(self._issue(button, principal, inbound.chat.id) for button in row)
            for row in shot.buttons
        )
        name = f"{shot.name}.{ENDINGS[drawing.media_type]}"
        outbound = Outbound(
            chat=inbound.chat,
            text=shot.caption(),
            reply_to=reply_id(inbound),
            buttons=bound,
            attachment=Attachment(name, drawing.media_type, drawing.content),
        )
        async with asyncio.timeout(SEND_WITHIN_S):
            readers = self._chat_sender.languages
            plain = translated(outbound, readers.of(principal))
            await (shot.deliver or asked.messenger.send)(plain)

    def _say(self, asked: CommandContext, text: str) -> None:
        inbound = asked.inbound
        outbound = Outbound(chat=inbound.chat, text=text, reply_to=reply_id(inbound))
        who = asked.caller.principal
        plain = translated(outbound, self._chat_sender.languages.of(who))
        self._chat_sender.say(OutgoingMessage(asked.messenger, plain, asker=who))

    async def close(self) -> None:
        """Make no more; what is being looked at is let go."""
        tasks = tuple(self._tasks.values())
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


def _nothing(_asked: CommandContext, _text: str) -> None:
    """Say nothing to whoever has not asked."""
