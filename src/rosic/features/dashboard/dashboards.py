"""Every chat's live card: shown, kept up to date at a bearable pace, and over when it has to be.

Nothing here is called for each order. While there are cards, robots are looked at once a second;
what changed is said by an edit when the chat may have one.
"""

from __future__ import annotations

import asyncio
import logging
from contextlib import suppress
from typing import TYPE_CHECKING, Final

import msgspec
from msgspec.structs import replace

from rosic.contracts.messenger import pictures_of, retract_of, turn_of
from rosic.core.i18n import in_language
from rosic.core.message import ChatKind, SendPriority
from rosic.core.time_units import SECOND_NS
from rosic.errors import MessageGone, MessengerFault, RecordUnavailable, TooManyRequests
from rosic.features.dashboard import messages as words
from rosic.features.dashboard.dashboard import (
    KIND,
    Dashboard,
    PreviewedCamera,
    chat_of,
    pace_of,
    read_fact,
)
from rosic.features.dashboard.rendering import ROBOTS_AT_MOST, DashboardRendering, in_order
from rosic.gateway.chat_dashboards import key_of

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Chat, Outbound
    from rosic.core.records import Fact
    from rosic.core.robot.profile import RobotId
    from rosic.features.dashboard.dashboard import RobotSnapshots
    from rosic.features.dashboard.rendering import DashboardQueries
    from rosic.gateway.chat_dashboards import CameraPreview, ChatDashboard
    from rosic.gateway.transactions import Transactions

LOOK_S: Final = 1.0
CARDS_AT_MOST: Final = 1_000
CARDS_A_PERSON: Final = 20
TRIES_TO_LEAVE: Final = 8

log = logging.getLogger("rosic.dashboards")


class Dashboards:
    """All of them; at most one a chat.

    Args:
        snapshots: Looks at robots.
        changes: Through which cards are written down.
        messengers: Through which chats are reached.
        clock: Of the gateway.
        sides: What the rooms know.
        camera: Looks for pictures; None: no card offers any.

    Attributes:
        kind: Of the facts of these cards.
    """

    kind = KIND

    def __init__(
        self,
        snapshots: RobotSnapshots,
        changes: Transactions,
        messengers: Iterable[Messenger],
        clock: Clock,
        sides: DashboardQueries,
        camera: CameraPreview | None,
    ) -> None:
        self.drawing = DashboardRendering(snapshots, sides, clock, camera)
        self._snapshots = snapshots
        self._changes = changes
        self._messengers = {messenger.name: messenger for messenger in messengers}
        self._clock = clock
        self._sides = sides
        self._cards: dict[str, Dashboard] = {}
        self._leaving: dict[Dashboard, None] = {}
        self._watching: asyncio.Task[None] | None = None
        self._running = False
        changes.keep(self.kind, self.apply)
        changes.after(self.look)

    def __len__(self) -> int:
        return len(self._cards)

    # ---- what is written down ----

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote; they go on in the same messages once this runs."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. One that cannot be read is no card."""
        known = self._cards.get(fact.key)
        try:
            found = read_fact(fact)
            chat = None if found is None else chat_of(found[1])
        except (msgspec.MsgspecError, ValueError):
            log.warning("a card cannot be read; it is over")
            found = chat = None
        if found is None or chat is None:
            if known is not None:
                self._leave(known, words.ENDED)
            return
        body, place = found
        messenger = self._messengers.get(place.messenger)
        if known is None and messenger is not None:
            dashboard = self._cards[fact.key] = Dashboard(
                messenger, chat, body.owner, body.robots, self.kind
            )
            dashboard.message, dashboard.pinned = place.message, body.pinned
            dashboard.wanted_pinned = body.pinned
            if body.picture_of:
                dashboard.picture = PreviewedCamera(body.picture_of, body.picture_ns)

    def end_all(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what ends every card of somebody."""
        return tuple(c.no_fact() for c in self._cards.values() if c.owner == principal)

    # ---- what people do ----

    def of(self, messenger: Messenger, chat: Chat) -> Dashboard | None:
        """Return a chat's card."""
        return self._cards.get(key_of(messenger, chat))

    def in_channels(self) -> tuple[Dashboard, ...]:
        """Return the cards that anybody may read."""
        return tuple(c for c in self._cards.values() if c.chat.kind is ChatKind.CHANNEL)

    def begin(
        self,
        messenger: Messenger,
        chat: Chat,
        owner: PrincipalId,
        robots: tuple[RobotId, ...],
        *,
        pinned: bool,
    ) -> None:
        """Begin a card in a new message; an older one of this chat ends.

        Args:
            messenger: Through which the chat is reached; it can edit.
            chat: Where.
            owner: Whose rights say what it shows.
            robots: Which; none: every robot that the owner may see.
            pinned: Keep it in sight; what an older one was, it is too.

        Raises:
            TooManyRequests: There are too many cards, or too many of this owner's in other chats;
                nothing has changed.
        """
        old = self.of(messenger, chat)
        theirs = sum(c.owner == owner for c in self._cards.values() if c is not old)
        if theirs >= CARDS_A_PERSON:
            raise TooManyRequests(words.too_many_of_yours(theirs), retry_after_s=60.0)
        if old is None and len(self._cards) >= CARDS_AT_MOST:
            raise TooManyRequests(words.TOO_MANY, retry_after_s=60.0)
        dashboard = Dashboard(messenger, chat, owner, robots, self.kind)
        dashboard.wanted_pinned = pinned or (old is not None and old.wanted_pinned)
        if old is not None:
            self._leave(old, words.SUPERSEDED)
        self._cards[dashboard.key] = dashboard
        self.run()

    async def end(self, dashboard: ChatDashboard) -> None:
        """End a card because somebody said so.

        Raises:
            RecordUnavailable: It is not over.
        """
        async with self._changes.turn() as turn:
            await turn.write((dashboard.no_fact(),))

    def keep_in_sight(self, dashboard: Dashboard, *, pinned: bool) -> None:
        """Pin a card, or unpin it, with its next edit, which is made at once."""
        dashboard.keep_in_sight(pinned=pinned)
        self.run()

    def show_picture(self, dashboard: Dashboard, picture: PreviewedCamera) -> None:
        """Show a picture with the next edit of a card, which is made at once."""
        if self._cards.get(dashboard.key) is dashboard:
            dashboard.show_picture(picture)
            self.run()

    # ---- looking ----

    def run(self) -> None:
        """Look from now on, as long as there are cards."""
        self._running = True
        if self._watching is None and self._all():
            self._snapshots.begin()
            self._watching = asyncio.create_task(self._watch())
        self.look()

    async def _watch(self) -> None:
        while self._all():
            await self._clock.sleep(LOOK_S)
            self.look()
        self._snapshots.end()
        self._watching = None

    async def close(self) -> None:
        """Look no more. Cards stay as they are, and say by when they should have changed."""
        self._running = False
        tasks = [dashboard.task for dashboard in self._all() if dashboard.task is not None]
        tasks += [] if self._watching is None else [self._watching]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        self._watching = None

    def _all(self) -> tuple[Dashboard, ...]:
        return (*self._cards.values(), *self._leaving)

    def look(self) -> None:
        """Look at every robot on a card, and begin the edits that are due."""
        if not self._running or not self._all():
            return
        shown = {dashboard: self._robots(dashboard) for dashboard in self._cards.values()}
        self._snapshots.look({r for robots in shown.values() for r in robots[:ROBOTS_AT_MOST]})
        now_ns = self._clock.monotonic_ns()
        for dashboard, robots in shown.items():
            if not robots:
                self._leave(dashboard, words.SEES_NOTHING)
            elif dashboard.picture is not None and dashboard.picture.robot not in robots:
                self._without_picture(dashboard)
            else:
                self.drawing.picturing.renew(dashboard)
                self._look_at(dashboard, robots, now_ns)
        for dashboard in self._leaving:
            if dashboard.task is None and now_ns >= dashboard.again_ns:
                dashboard.begin_edit(self._bring(dashboard, SendPriority.QUESTION))

    def _robots(self, dashboard: Dashboard) -> tuple[RobotId, ...]:
        """Return what a card shows now: never what its owner may not see (I11)."""
        if not self._sides.reads(dashboard.owner, dashboard.chat):
            return ()
        sees = self._sides.sees(dashboard.owner)
        return (
            tuple(r for r in dashboard.robots if r in sees) if dashboard.robots else in_order(sees)
        )

    def _without_picture(self, dashboard: Dashboard) -> None:
        """Go on in a new message: what shows a picture shows one for good."""
        self._leave(dashboard, words.SEES_NOTHING)
        fresh = Dashboard(
            dashboard.messenger, dashboard.chat, dashboard.owner, dashboard.robots, self.kind
        )
        fresh.wanted_pinned = dashboard.wanted_pinned
        self._cards[fresh.key] = fresh

    def _look_at(self, dashboard: Dashboard, robots: tuple[RobotId, ...], now_ns: int) -> None:
        forbidden = not dashboard.shows.keys() <= set(robots)
        if dashboard.task is not None:
            # Words that wait for their turn may hold what has just become none of their reader's.
            if not (forbidden and dashboard.message):
                return
            dashboard.call_off_edit()
        if forbidden or self._is_due(dashboard, robots, now_ns):
            idle = bool(dashboard.message) and not forbidden
            weight = SendPriority.IDLE if idle else SendPriority.QUESTION
            dashboard.begin_edit(self._bring(dashboard, weight))

    def _is_due(self, dashboard: Dashboard, robots: tuple[RobotId, ...], now_ns: int) -> bool:
        pace = pace_of(dashboard.chat)
        if now_ns < dashboard.again_ns:
            return False
        old_ns = dashboard.stamped_ns + int(pace.refresh_s * SECOND_NS)
        if not dashboard.stamped_ns or now_ns >= old_ns:
            return True
        rested = now_ns >= dashboard.settled_ns + int(pace.between_s * SECOND_NS)
        return rested and (dashboard.pictured_anew or dashboard.shows != self.drawing.shows(robots))

    # ---- showing ----

    async def _bring(self, dashboard: Dashboard, weight: SendPriority) -> None:
        """Bring a chat up to date with its card, or the card to its end."""
        mine = asyncio.current_task()
        try:
            if dashboard.last:
                await self._say_last(dashboard)
            else:
                await self._show(dashboard, weight)
        except MessageGone:
            await self._gone(dashboard)
        except MessengerFault as fault:
            self._failed(dashboard, fault)
        except Exception:
            log.exception("a card could not be shown")
            self._failed(dashboard, MessengerFault("a fault of the messenger"))
        finally:
            dashboard.edit_over(mine)

    async def _show(self, dashboard: Dashboard, weight: SendPriority) -> None:
        first, turn = not dashboard.message, turn_of(dashboard.messenger)
        if turn is not None and not first:
            await turn(dashboard.chat, weight)  # what it says is chosen last
        robots = self._robots(dashboard)
        if not robots:
            return  # it is about to end
        self._snapshots.look(robots[:ROBOTS_AT_MOST])
        began_ns = self._clock.monotonic_ns()
        outbound = self.drawing.outbound(dashboard, robots, weight)
        shows, message = self.drawing.shows(robots), dashboard.message
        dashboard.may_show(shows)
        if first:
            message = await dashboard.messenger.send(replace(outbound, attachment=None))
        else:
            await self._change(dashboard, outbound)
        dashboard.brought(message, shows, began_ns, self._clock.monotonic_ns())
        if dashboard.last:
            return  # it has ended meanwhile, and is about to say so
        if first:
            await self._write(dashboard)
        if dashboard.wanted_pinned != dashboard.pinned:
            await self._pin(dashboard)

    async def _change(self, dashboard: Dashboard, outbound: Outbound) -> None:
        """Edit a card; once a picture is there, it is not kept here any longer."""
        put = pictures_of(dashboard.messenger)
        if outbound.attachment is None or put is None:
            await dashboard.messenger.edit(dashboard.message, replace(outbound, attachment=None))
            return
        await put(dashboard.message, outbound)
        dashboard.picture_shown(outbound.attachment)
        await self._write(dashboard)

    async def _pin(self, dashboard: Dashboard) -> None:
        pinned = dashboard.wanted_pinned
        try:
            await dashboard.messenger.pin(dashboard.chat, dashboard.message, pinned=pinned)
        except MessageGone:
            raise
        except MessengerFault as fault:
            dashboard.pinning_failed()
            text = in_language(fault.sentence, self._sides.catalogue(dashboard.owner))
            self._sides.tell(dashboard.messenger, dashboard.chat, text)
        else:
            dashboard.pinning_done(pinned=pinned)
            await self._write(dashboard)

    async def _write(self, dashboard: Dashboard) -> None:
        """Write down where a card is, unless it has ended meanwhile."""
        try:
            async with self._changes.turn() as turn:
                if self._cards.get(dashboard.key) is dashboard:
                    await turn.write((dashboard.fact(),))
        except RecordUnavailable:
            log.warning("a card could not be written down; it will not outlive this process")

    def _failed(self, dashboard: Dashboard, fault: MessengerFault) -> None:
        """Try again later, and ever more seldom."""
        dashboard.failed(self._clock.monotonic_ns())
        log.info("a card is not up to date: %s", fault)
        if dashboard.last and dashboard.failures >= TRIES_TO_LEAVE:
            self._leaving.pop(dashboard, None)

    # ---- ending ----

    def _leave(self, dashboard: Dashboard, last: str) -> None:
        """A card is over; its message is to say so."""
        if self._cards.get(dashboard.key) is dashboard:
            del self._cards[dashboard.key]
        dashboard.end(last)
        if dashboard.message or dashboard.task is not None:
            self._leaving[dashboard] = None

    async def _say_last(self, dashboard: Dashboard) -> None:
        retract = retract_of(dashboard.messenger)
        if (
            dashboard.picture is not None
            and dashboard.last == words.SEES_NOTHING
            and retract is not None
        ):
            with suppress(MessageGone):  # too old: then only its words go
                await retract(dashboard.chat, dashboard.message)
                await self._gone(dashboard)
                return
        if dashboard.message:
            await dashboard.messenger.edit(dashboard.message, self.drawing.last(dashboard))
        if dashboard.message and dashboard.pinned:
            try:
                await dashboard.messenger.pin(dashboard.chat, dashboard.message, pinned=False)
            except MessengerFault as fault:
                log.info("a card that is over stays pinned: %s", fault)
        await self._gone(dashboard)

    async def _gone(self, dashboard: Dashboard) -> None:
        """Nothing is left of a card: its message says so, or was deleted."""
        self._leaving.pop(dashboard, None)
        if self._cards.setdefault(dashboard.key, dashboard) is not dashboard:
            return  # a newer one has taken its place
        del self._cards[dashboard.key]
        async with self._changes.turn() as turn:
            await turn.act((dashboard.no_fact(),))
