"""Stops of callers, given at once; of a flood of them one each 50 ms, for all that came before it.

None is refused, and none is given earlier than it was asked for: one that joins others is given
after it came, so that no robot is resumed between the two.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from typing import TYPE_CHECKING, Final

from rosic.contracts.background_tasks import BackgroundTasks

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.api.callers import ApiCaller
    from rosic.api.schemas import StopOut
    from rosic.core.identity import Address

EVERY_S: Final = 0.05
REMEMBERED: Final = 1_000
"""Callers whose last stop is remembered; one that is forgotten is served at once."""

EVERYTHING: Final[frozenset[str]] = frozenset()


class _JoinedStop:
    """A stop that waits for its turn, for everybody who has asked since the last one.

    Attributes:
        robots: Of which robots; empty: of all.
    """

    def __init__(self, caller: ApiCaller, robots: frozenset[str]) -> None:
        self.caller, self.robots = caller, robots
        self.given: asyncio.Future[StopOut] = asyncio.get_running_loop().create_future()
        self.given.add_done_callback(_looked_at)

    def join(self, robots: frozenset[str]) -> None:
        """Stop these as well."""
        self.robots = self.robots | robots if self.robots and robots else EVERYTHING


class CallerStops:
    """Gives them.

    Args:
        give: Gives one, and returns what became of it.
    """

    def __init__(self, give: Callable[[ApiCaller, frozenset[str]], Awaitable[StopOut]]) -> None:
        self._give = give
        self._last_s: OrderedDict[Address, float] = OrderedDict()
        self._joined: dict[Address, _JoinedStop] = {}
        self._giving: BackgroundTasks[None] = BackgroundTasks()

    async def close(self) -> None:
        """Follow nothing any more; what was given stays given."""
        giving = tuple(self._giving)
        for task in giving:
            task.cancel()
        await asyncio.gather(*giving, return_exceptions=True)

    def give(self, caller: ApiCaller, robots: frozenset[str]) -> asyncio.Future[StopOut]:
        """Give a stop; whoever waits for what is returned waits on a shield, as others do too.

        Args:
            caller: Who gives it.
            robots: Of which robots; empty: of all.
        """
        loop, address = asyncio.get_running_loop(), caller.address
        joined = self._joined.get(address)
        if joined is not None:
            joined.join(robots)
            return joined.given
        joined = _JoinedStop(caller, robots)
        wait_s = self._last_s.get(address, -EVERY_S) + EVERY_S - loop.time()
        if wait_s <= 0:
            self._begin(joined)
        else:
            self._joined[address] = joined
            loop.call_later(wait_s, self._begin, joined)
        return joined.given

    def _begin(self, stop: _JoinedStop) -> None:
        address = stop.caller.address
        self._joined.pop(address, None)
        self._last_s.pop(address, None)
        self._last_s[address] = asyncio.get_running_loop().time()
        if len(self._last_s) > REMEMBERED:
            self._last_s.popitem(last=False)
        self._giving.begin(self._follow(stop))

    async def _follow(self, stop: _JoinedStop) -> None:
        try:
            result = await self._give(stop.caller, stop.robots)
        except Exception as why:  # noqa: BLE001 - told to everybody who asked
            stop.given.set_exception(why)
        else:
            stop.given.set_result(result)
        finally:
            stop.given.cancel()


def _looked_at(given: asyncio.Future[StopOut]) -> None:
    """Say that what went wrong is known, though nobody may wait for it any more."""
    if not given.cancelled():
        given.exception()
