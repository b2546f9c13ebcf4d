"""The queue of updates, and who may read it (https://core.telegram.org/bots/api#getting-updates)."""

from __future__ import annotations

import asyncio
from math import inf
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from rosic.testing.telegram.refusals import (
    OTHER_POLLER,
    WEBHOOK_ACTIVE,
    WEBHOOK_SET,
    ControlError,
    conflict,
)
from rosic.testing.telegram.state import JsonObject, Pending, State

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.testing.telegram.journal import Journal
    from rosic.testing.telegram.settings import ServerClock, Settings

KINDS = (
    "message",
    "edited_message",
    "channel_post",
    "edited_channel_post",
    "business_connection",
    "business_message",
    "edited_business_message",
    "deleted_business_messages",
    "message_reaction",
    "message_reaction_count",
    "inline_query",
    "chosen_inline_result",
    "callback_query",
    "shipping_query",
    "pre_checkout_query",
    "purchased_paid_media",
    "poll",
    "poll_answer",
    "my_chat_member",
    "chat_member",
    "chat_join_request",
    "chat_boost",
    "removed_chat_boost",
    "managed_bot",
    "guest_message",
    "subscription",
    "stopped_message_generation",
)
"""https://core.telegram.org/bots/api#update"""

NOT_BY_DEFAULT = frozenset({"chat_member", "message_reaction", "message_reaction_count"})
"""https://core.telegram.org/bots/api#getupdates, `allowed_updates`: "except ... (default)"."""

FUTURE_OFFSET = 10
"""An offset further ahead is not believed, and the queue is given from its head.

The documentation is silent; the published server does so (TQueue), and it is what lets a client
with an old, high offset go on after Telegram chose a lower update_id
(https://core.telegram.org/bots/api#update).
"""


class Poll(NamedTuple):
    """One getUpdates request.

    Attributes:
        alive: Says whether somebody still listens for the answer.
    """

    offset: int
    limit: int
    timeout_s: float
    alive: Callable[[], bool]


class Waiter(NamedTuple):
    """The one poll that waits; its future ends with None, or with why it was thrown out."""

    poll: Poll
    done: asyncio.Future[str | None]


class UpdateQueue:
    """Updates that the bot has not confirmed yet.

    Args:
        state: Holds the queue itself.
        clock: Retention runs on it.
        journal: Told about confirmed updates.
        settings: Lifetimes and pauses.
    """

    def __init__(
        self, state: State, clock: ServerClock, journal: Journal, settings: Settings
    ) -> None:
        self._state = state
        self._clock = clock
        self._journal = journal
        self._settings = settings
        self._waiter: Waiter | None = None
        self._calm_at_s = 0.0
        self._last_poll: tuple[int, float] | None = None
        self._reverse_next = False
        self._duplicate_next = ""
        self._sweep_at_s = min((entry.expires_s for entry in state.queue), default=inf)

    def __len__(self) -> int:
        return len(self._state.queue)

    def put(self, kind: str, payload: JsonObject, expires_s: float) -> int | None:
        """Queue one update, unless its type is not wanted or it is too old already.

        Returns:
            Its update_id, or None when it was dropped.
        """
        if not self.wants(kind) or expires_s <= self._clock.now_s():
            return None
        update_id = self._state.take_update_id()
        self._sweep_at_s = min(self._sweep_at_s, expires_s)
        update = Pending(update_id=update_id, kind=kind, payload=payload, expires_s=expires_s)
        self._state.queue.append(update)
        again, self._duplicate_next = self._duplicate_next, ""
        if again:
            second = self._state.take_update_id() if again == "new" else update_id
            self._state.queue.append(msgspec.structs.replace(update, update_id=second))
        self._wake(None)
        return update_id

    def wants(self, kind: str) -> bool:
        """Say whether the bot asked for updates of this type."""
        allowed = self._state.allowed
        return kind not in NOT_BY_DEFAULT if allowed is None else kind in allowed

    def allow(self, kinds: list[str] | None) -> None:
        """Keep `allowed_updates` until it is given again; an empty list is the default selection.

        https://core.telegram.org/bots/api#getupdates: "If not specified, the previous setting will
        be used", and it does not affect updates made before.
        """
        if kinds is not None:
            self._state.allow(kinds)

    async def get(self, poll: Poll) -> list[JsonObject]:
        """Answer getUpdates.

        Raises:
            ApiError: 409, when a webhook is set, or another poll came while this one waited.
                Nothing was confirmed in the first case; what the offset confirmed stays confirmed
                otherwise.
        """
        if self._state.webhook.url:
            raise conflict(WEBHOOK_ACTIVE)
        poll = self._unhurried(poll)
        batch = self._take(poll)
        if not batch and poll.timeout_s > 0:
            await self._wait(poll)
            batch = self._take(poll)
        self._journal.add("delivered", update_ids=[entry["update_id"] for entry in batch])
        return batch

    def expel(self) -> None:
        """End the waiting poll because a webhook was set."""
        self._wake(WEBHOOK_SET)

    def release(self) -> None:
        """End the waiting poll with an empty answer."""
        self._wake(None)

    def clear(self) -> None:
        """Drop everything that waits (`drop_pending_updates`)."""
        self._state.queue.clear()

    def duplicate_next(self, *, new_id: bool) -> None:
        """Queue the next update twice, under one update_id or under two."""
        self._duplicate_next = "new" if new_id else "same"

    def reverse_next(self) -> None:
        """Give the next answer that has two or more updates in reversed order."""
        self._reverse_next = True

    def jump(self, next_update_id: int) -> None:
        """Choose the next update_id, as Telegram does after a week without updates.

        Raises:
            ControlError: It would be lower than that of an update which still waits.
        """
        if self._state.queue and next_update_id <= self._state.queue[-1].update_id:
            raise ControlError("an update still waits; Telegram starts anew only with none left")
        self._state.renumber(next_update_id)

    def _unhurried(self, poll: Poll) -> Poll:
        """Stretch a short poll that repeats itself, when the setting asks for it."""
        now_s, idle_s = self._clock.now_s(), self._settings.idle_poll_s
        last, self._last_poll = self._last_poll, (poll.offset, now_s)
        hurried = last is not None and last[0] == poll.offset and now_s < last[1] + idle_s
        return poll._replace(timeout_s=idle_s) if hurried and poll.timeout_s < idle_s else poll

    def _take(self, poll: Poll) -> list[JsonObject]:
        """Forget what the offset confirms and what is too old; return the next updates."""
        queue, now_s = self._state.queue, self._clock.now_s()
        if poll.offset < 0:
            del queue[: poll.offset]
        elif poll.offset <= self._state.next_update_id + FUTURE_OFFSET:
            self._confirm(poll.offset)
        if now_s >= self._sweep_at_s:
            queue[:] = [entry for entry in queue if entry.expires_s > now_s]
            self._sweep_at_s = min((entry.expires_s for entry in queue), default=inf)
        batch = queue[: poll.limit]
        if self._reverse_next and len(batch) > 1:
            self._reverse_next = False
            batch.reverse()
        return [{"update_id": entry.update_id, entry.kind: entry.payload} for entry in batch]

    def _confirm(self, offset: int) -> None:
        queue = self._state.queue
        confirmed = 0
        while confirmed < len(queue) and queue[confirmed].update_id < offset:
            confirmed += 1
        if confirmed:
            del queue[:confirmed]
            self._journal.add("confirmed", offset=offset, left=len(queue))

    async def _wait(self, poll: Poll) -> None:
        """Wait for an update; throw out the poll that waited before."""
        self._wake(OTHER_POLLER)
        mine = Waiter(poll, asyncio.get_running_loop().create_future())
        self._waiter = mine
        try:
            reason = await asyncio.wait_for(mine.done, poll.timeout_s)
        except TimeoutError:
            reason = None
        finally:
            if self._waiter is mine:
                self._waiter = None
        if reason is not None:
            await self._pause()
            raise conflict(reason)

    def _wake(self, reason: str | None) -> None:
        waiter, self._waiter = self._waiter, None
        if waiter is None or waiter.done.done():
            return
        waiter.done.set_result(reason if waiter.poll.alive() else None)

    async def _pause(self) -> None:
        """Answer the first conflict at once and further ones later, as the published server."""
        now_s, pause_s = self._clock.now_s(), self._settings.conflict_pause_s
        if now_s >= self._calm_at_s:
            self._calm_at_s = now_s + pause_s
        else:
            await asyncio.sleep(pause_s)
