"""Services: a question with an answer, or with an honest silence."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.robots.ros2.client.client_link import ClientLink
from rosic.robots.ros2.errors import NotSent
from rosic.robots.ros2.messages.encode import to_message

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.robots.ros2.client.connection import RosConnection
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.messages.encode import Values

# A service keeps 10 requests and loses what comes beyond, without a word to either side. Two
# gates of 4 stay below that: one for what can wait, one for what stops a robot.
MAX_CALLS = 4

_LOOK_AGAIN_S = 0.02


async def wait_until(ready: Callable[[], bool], what: str, timeout_s: float) -> None:
    """Wait for somebody to be there. Discovery takes up to two seconds after a start.

    Raises:
        NotSent: Nobody is, and the time is over.
    """
    try:
        async with asyncio.timeout(timeout_s):
            while not ready():  # noqa: ASYNC110 - discovery tells nobody
                await asyncio.sleep(_LOOK_AGAIN_S)
    except TimeoutError:
        raise NotSent(f"Nobody offers {what}; nothing was sent.") from None


class ServiceLink(ClientLink):
    """A client of one service."""

    def __init__(
        self,
        runtime: RosConnection,
        name: str,
        cls: RosObject,
        handle: RosObject,
        make: Callable[[], RosObject],
    ) -> None:
        """Make it; see `ClientLink`."""
        super().__init__(runtime, name, cls, handle, make)
        self._ordinary = asyncio.Semaphore(MAX_CALLS)
        self._urgent = asyncio.Semaphore(MAX_CALLS)

    async def call(
        self,
        values: Values,
        *,
        timeout_s: float,
        found_within_s: float = 0.0,
        urgent: bool = False,
        leave: Callable[[], object] | None = None,
    ) -> RosObject:
        """Call it and return the response, to be read with `reading.compile_path`.

        Args:
            values: Fields of the request.
            timeout_s: For the answer, once sent, and before that for a place among the calls
                under way.
            found_within_s: How long to look for somebody who offers it.
            urgent: Pass by the calls that wait; for what stops a robot.
            leave: Called immediately before it is sent, when everything that may take time is
                over. What it raises is raised here, and nothing was sent.

        Raises:
            BadValue: A value does not fit; nothing was sent.
            NotSent: Nobody offers it, too many calls are under way, or the link is closed.
            NoAnswer: It was sent, and nothing came in time. It may or may not have been done.
        """
        request = to_message(self._cls.Request, values)
        if not self.ready():
            await wait_until(self.sought, self.name, found_within_s)
        admission = self._urgent if urgent else self._ordinary
        try:
            async with asyncio.timeout(timeout_s):
                await admission.acquire()
        except TimeoutError:
            raise NotSent(f"Too many calls are under way; {self.name} was not called.") from None
        try:
            if leave is not None:
                leave()
            return await self._ask(request, timeout_s)
        finally:
            admission.release()

    async def _ask(self, request: RosObject, timeout_s: float) -> RosObject:
        self._unresolved += 1
        self._runtime.traffic.went()
        try:
            answer = await self._runtime.thread.ask(
                lambda: self._handle.call_async(request), self.name, timeout_s=timeout_s
            )
        finally:  # one that comes late is heard by nobody
            self._unresolved -= 1
        self._runtime.traffic.came()
        return answer

    def _sees(self, handle: RosObject) -> bool:
        return bool(handle.service_is_ready())

    def _ends(self, node: RosObject) -> Mapping[str, int]:
        return {"servers": node.count_services(self.name)}

    def _destroy(self, node: RosObject, handle: RosObject) -> None:
        node.destroy_client(handle)
