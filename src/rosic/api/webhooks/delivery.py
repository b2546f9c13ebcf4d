"""Posts events to one webhook: in order per robot, and again until they are taken.

What waits is in memory and bounded: when there is too much, the oldest goes, and the next that is
taken says how many are missing. A restart loses what waits; whoever needs all of it reads the
history. Nothing waits for a webhook.

A name is looked up once for each post, and what is posted goes to the address that was checked: a
name cannot show a public address first and lead into the private network afterwards.
"""

from __future__ import annotations

import asyncio
import logging
import random
from collections import deque
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import httpx
import msgspec

from rosic.api.webhooks.addresses import RefusedAddress, addresses_of, shown
from rosic.api.webhooks.settings import key_of, signed
from rosic.contracts.background_tasks import BackgroundTasks
from rosic.core.i18n import plain
from rosic.core.signal import Signal
from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from rosic.api.webhooks.settings import WebhookSettings
    from rosic.contracts.clock import Clock

WAITING_AT_MOST: Final = 1_000
AT_ONCE: Final = 4
WITHIN_S: Final = 10.0
FIRST_PAUSE_S: Final = 1.0
LONGEST_PAUSE_S: Final = 900.0
TRIED_FOR_S: Final = 86_400.0
TOLD_AFTER_S: Final = 600.0
"""So long nothing is taken before somebody is asked to look."""
USER_AGENT: Final = "ROSIC-Webhook"

log = logging.getLogger("rosic.webhooks")


class WebhookEvent(msgspec.Struct, frozen=True):
    """What is posted.

    Attributes:
        type: ``order.accepted``, ``robot.stopped`` ...
        timestamp: When it happened; RFC 3339, UTC.
        data: What happened.
        lost: Events before it that were given up, because there were too many or for too long.
    """

    type: str
    timestamp: str
    data: dict[str, Any]
    lost: int = 0


class _Waiting(NamedTuple):
    id: str
    event: WebhookEvent
    since_ns: int


class NotTaken(Exception):
    """It was not taken; the sentence says why. It may have been taken all the same."""


class WebhookDelivery:
    """Posts to one webhook.

    Args:
        settings: Where, and with which secret.
        clock: By which it waits, and dates what it says.
        run: Tells the ids of one run from those of another.
        within_s: So long one post may take.
        at_most: So many events wait; then the oldest goes.

    Attributes:
        waiting: How many events wait.
        news: Tells that nothing was taken for ten minutes (False), and that it is again (True).
    """

    def __init__(
        self,
        settings: WebhookSettings,
        clock: Clock,
        run: str,
        *,
        within_s: float = WITHIN_S,
        at_most: int = WAITING_AT_MOST,
    ) -> None:
        self.settings = settings
        self._key = key_of(settings.secret)
        self._clock, self._run, self._serial, self._lost = clock, run, 0, 0
        self._within_s, self._at_most = within_s, at_most
        self.news: Signal[[bool]] = Signal()
        self.waiting = 0
        self._failing_since_ns: int | None = None
        self._is_told = self._is_closed = False
        self._lanes: dict[str, deque[_Waiting]] = {}
        self._tasks: BackgroundTasks[None] = BackgroundTasks()
        self._turns = asyncio.Semaphore(AT_ONCE)
        self._http = httpx.AsyncClient(
            timeout=within_s,
            follow_redirects=False,
            trust_env=False,  # a proxy would look the name up by itself
            headers={"User-Agent": USER_AGENT},
        )

    @property
    def shown(self) -> str:
        """Where it goes, without what may be secret in its path."""
        return shown(self.settings)

    def put(self, lane: str, event: WebhookEvent) -> None:
        """Have something posted, after what waits in the same lane. Returns at once."""
        if self._is_closed:
            return
        if self.waiting >= self._at_most:
            longest = max(self._lanes.values(), key=len)
            del longest[1 if len(longest) > 1 else 0]
            self.waiting -= 1
            self._lost += 1
        self._serial += 1
        self.waiting += 1
        waits = _Waiting(f"msg_{self._run}_{self._serial}", event, self._clock.monotonic_ns())
        if lane in self._lanes:
            self._lanes[lane].append(waits)
        else:
            self._lanes[lane] = deque((waits,))
            self._tasks.begin(self._serve(lane))

    async def close(self) -> None:
        """Post nothing any more; what waits is lost, and that is logged."""
        self._is_closed = True
        if self.waiting:
            log.warning("%d events were not taken by %s", self.waiting, self.shown)
        for task in (tasks := tuple(self._tasks)):
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await self._http.aclose()

    async def _serve(self, lane: str) -> None:
        """Post what waits in a lane, one after another, until nothing does."""
        queue = self._lanes[lane]
        while queue:
            first = queue[0]
            await self._until_taken(first)
            if queue and queue[0] is first:
                queue.popleft()
                self.waiting -= 1
        del self._lanes[lane]

    async def _until_taken(self, waits: _Waiting) -> None:
        pause_s = FIRST_PAUSE_S
        while True:
            try:
                async with self._turns:
                    await self.post(waits.id, waits.event)
            except NotTaken as why:
                now_ns = self._clock.monotonic_ns()
                self._note_failure(now_ns, str(why))
                if (now_ns - waits.since_ns) / SECOND_NS >= TRIED_FOR_S:
                    log.warning("%s was given up for %s after a day", waits.event.type, self.shown)
                    self._lost += 1
                    return
                await self._clock.sleep(pause_s * random.uniform(0.75, 1.25))  # noqa: S311
                pause_s = min(pause_s * 2, LONGEST_PAUSE_S)
            else:
                self._note_success()
                return

    def _note_failure(self, now_ns: int, why: str) -> None:
        if self._failing_since_ns is None:
            self._failing_since_ns = now_ns
            log.warning("%s takes no events (%s); they are posted again", self.shown, why)
        failing_s = (now_ns - self._failing_since_ns) / SECOND_NS
        if failing_s >= TOLD_AFTER_S and not self._is_told:
            self._is_told = True
            self.news.emit(False)

    def _note_success(self) -> None:
        if self._failing_since_ns is not None:
            log.info("%s takes events again", self.shown)
        self._failing_since_ns = None
        if self._is_told:
            self._is_told = False
            self.news.emit(True)

    async def post(self, message: str, event: WebhookEvent) -> int:
        """Post once, and return the status with which it was taken.

        Raises:
            NotTaken: It was not, in the time that one post has.
        """
        lost, self._lost, taken = self._lost, 0, False
        body = msgspec.json.encode(msgspec.structs.replace(event, lost=lost), enc_hook=plain)
        try:
            status = await self._post(message, body)
            taken = True
        finally:
            self._lost += 0 if taken else lost
        return status

    async def _post(self, message: str, body: bytes) -> int:
        at_s = self._clock.wall_ns() // SECOND_NS
        headers = {"Content-Type": "application/json", **signed(self._key, message, at_s, body)}
        try:
            async with asyncio.timeout(self._within_s):
                status = await self._ask(await self._address(), headers, body)
        except TimeoutError:
            raise NotTaken(f"nothing was answered within {self._within_s:g} s") from None
        except (httpx.HTTPError, OSError, UnicodeError) as error:
            raise NotTaken(f"it cannot be reached ({type(error).__name__})") from error
        if not httpx.codes.is_success(status):
            moved = ", and is not followed elsewhere" if httpx.codes.is_redirect(status) else ""
            raise NotTaken(f"it answers {status}{moved}")
        return status

    async def _ask(self, address: str, headers: dict[str, str], body: bytes) -> int:
        """Post to this address under the name that is configured; what it says is not read."""
        url = httpx.URL(self.settings.url)
        asked = self._http.stream(
            "POST",
            url.copy_with(host=address),
            content=body,
            headers=headers | {"Host": url.netloc.decode("ascii")},
            extensions={"sni_hostname": url.raw_host.decode("ascii")},
        )
        async with asked as answer:
            return answer.status_code

    async def _address(self) -> str:
        """Look up where it is.

        Raises:
            NotTaken: One of its addresses is of this machine or of a private network.
            OSError: It has none.
        """
        try:
            addresses = await addresses_of(self.settings)
        except RefusedAddress as private:
            raise NotTaken(str(private)) from private
        return addresses[self._serial % len(addresses)]
