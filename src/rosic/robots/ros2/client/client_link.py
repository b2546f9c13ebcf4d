"""What clients of services and of actions share: whether the other side is seen, and what if not.

rclpy's client is ready once each of its ends has met one of the other side: two of a service, eight
of an action. On a busy machine one of these meetings may get lost (Fast DDS), and nothing brings it
about later: the other side is on the graph, answers everybody else, and is never there for this
client. A client that is made anew meets it afresh.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final

from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.robots.ros2.client.connection import RosConnection
    from rosic.robots.ros2.client.rclpy_import import RosObject

_log = logging.getLogger(__name__)

UNSEEN_S: Final = 4.0
"""For so long an offer that is on the graph may be unseen: what gets lost in discovery is sent
again every 3 s (Fast DDS)."""
UNSEEN_AT_MOST_S: Final = 64.0
"""Each time that it was in vain twice as long, and no longer than this."""
FOUND_S: Final = 1.0
"""So much time the other side has to find a client that was made anew, before anything is sent: it
drops an answer to one that it has not found yet."""


class ClientLink:
    """A client of one service or action, kept open: finding it again would take longer than asking.

    Attributes:
        name: Absolute name.
        renewed: How often its client was made anew.
    """

    def __init__(
        self,
        runtime: RosConnection,
        name: str,
        cls: RosObject,
        handle: RosObject,
        make: Callable[[], RosObject],
    ) -> None:
        """Make it.

        Args:
            runtime: The link to the graph.
            name: Absolute name.
            cls: The type.
            handle: rclpy's client.
            make: Makes another; called on the ROS thread.
        """
        self.name = name
        self.renewed = 0
        self._runtime = runtime
        self._cls = cls
        self._handle = handle
        self._make = make
        # How much was sent over the handle of which it is not known how it ended: as long as there
        # is any, the handle stays, for only by it that can be heard, or called off.
        self._unresolved = 0
        self._renewal: asyncio.Task[None] | None = None
        self._unseen_ns: int | None = None
        self._patience_s = UNSEEN_S
        self._found_ns: int | None = None

    def ready(self) -> bool:
        """Tell whether somebody offers it now."""
        if not self._runtime.alive or not self._sees(self._handle):
            return False
        return self._found_ns is None or self._runtime.now_ns() >= self._found_ns

    def sought(self) -> bool:
        """Tell the same, for somebody who waits for it and has sent nothing yet.

        Where it is on the graph and unseen for long, the client is made anew meanwhile: more and
        more rarely, and never while it is not known how something ended that was sent over it.
        """
        if self.ready():
            self._unseen_ns, self._patience_s = None, UNSEEN_S
            return True
        now_ns = self._runtime.now_ns()
        if self._unseen_ns is None:
            self._unseen_ns = now_ns
        elif self._may_be_renewed() and now_ns - self._unseen_ns >= self._patience_s * SECOND_NS:
            self._renewal = asyncio.create_task(self._renew())
            self._renewal.add_done_callback(self._renewal_ended)
        return False

    async def close(self) -> None:
        """Leave it."""
        if self._renewal is not None:
            await asyncio.wait({self._renewal})
        handle = self._handle
        await self._runtime.discard(lambda node: self._destroy(node, handle))

    def _sees(self, handle: RosObject) -> bool:
        """Tell whether a client sees somebody who offers it."""
        raise NotImplementedError

    def _ends(self, node: RosObject) -> Mapping[str, int]:
        """Return how many there are on the graph of each end of the other side."""
        raise NotImplementedError

    def _destroy(self, node: RosObject, handle: RosObject) -> None:
        """Close a client; on the ROS thread."""
        raise NotImplementedError

    def _may_be_renewed(self) -> bool:
        return self._runtime.alive and not self._unresolved and self._renewal is None

    async def _renew(self) -> None:
        """Put another client in the place of this one, unless that is not needed any more."""
        runtime = self._runtime
        ends = await runtime.thread.run(lambda: self._ends(runtime.thread.node))
        if not any(ends.values()):
            self._unseen_ns = None  # nobody is there: that is no client's fault
            return
        self._unseen_ns = runtime.now_ns()
        self._patience_s = min(2 * self._patience_s, UNSEEN_AT_MOST_S)
        made = await runtime.opened(self._make)
        # It was waited for: what is in use now, or sees somebody by now, stays.
        if self._unresolved or self._sees(self._handle):
            unwanted = made
        else:
            unwanted, self._handle = self._handle, made
            self._found_ns = runtime.now_ns() + int(FOUND_S * SECOND_NS)
            self.renewed += 1
            _log.warning(
                "%s is on the graph (%s), and its client did not see it: made anew",
                self.name,
                ", ".join(f"{end} {number}" for end, number in ends.items()),
            )
        await runtime.discard(lambda node: self._destroy(node, unwanted))

    def _renewal_ended(self, renewal: asyncio.Task[None]) -> None:
        self._renewal = None
        if not renewal.cancelled() and (fault := renewal.exception()) is not None:
            _log.warning("the client of %s could not be made anew: %s", self.name, fault)
