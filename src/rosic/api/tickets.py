"""Tickets: shown once, within a minute, in the URL of a WebSocket in place of a key.

For clients that can set neither a header nor send a key: what stands in a URL is kept in logs and
histories, so that it must be worth nothing afterwards.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec
from litestar import post
from litestar.di import NamedDependency
from litestar.params import SkipValidation
from litestar.status_codes import HTTP_201_CREATED

from rosic.api.routes import Who
from rosic.core.i18n import said
from rosic.core.time_units import SECOND_NS
from rosic.errors import Unrecognised

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.api.callers import ApiCaller, CallerDirectory
    from rosic.contracts.clock import Clock
    from rosic.core.identity import PrincipalId

GOOD_FOR_S: Final = 60
OF_ONE_AT_MOST: Final = 16
"""Further ones make the oldest of the same caller void, and nobody else's."""
VOID: Final = said("That ticket is void: each is good once, for a minute.")


class _Ticket(NamedTuple):
    caller: ApiCaller
    until_ns: int


class TicketBook:
    """The tickets that are good now; in memory, none survives a restart.

    Args:
        callers: Whether whoever was given one is still known.
        clock: By which they end.
        token: Returns so many random bytes.
    """

    def __init__(
        self, callers: CallerDirectory, clock: Clock, token: Callable[[int], bytes]
    ) -> None:
        self._callers, self._clock, self._token = callers, clock, token
        self._tickets: dict[str, _Ticket] = {}
        self._of: dict[PrincipalId, deque[str]] = {}

    def issue(self, caller: ApiCaller) -> str:
        """Return a new ticket for somebody."""
        ticket = self._token(24).hex()
        until_ns = self._clock.monotonic_ns() + GOOD_FOR_S * SECOND_NS
        self._tickets[ticket] = _Ticket(caller, until_ns)
        own = self._of.setdefault(caller.principal, deque())
        own.append(ticket)
        if len(own) > OF_ONE_AT_MOST:
            self._tickets.pop(own.popleft(), None)
        return ticket

    def redeem(self, ticket: str) -> ApiCaller:
        """Return who was given a ticket; it is void from now on.

        Raises:
            Unrecognised: There is none like that any more, or nobody is known by it.
        """
        found = self._tickets.pop(ticket, None)
        if found is None or self._clock.monotonic_ns() > found.until_ns:
            raise Unrecognised(VOID)
        caller = found.caller
        return self._callers.known_by(caller.secret, by_cookie=caller.by_cookie)


# ---- its route ----

Tickets = NamedDependency[SkipValidation[TicketBook]]


class TicketOut(msgspec.Struct, frozen=True):
    """A ticket: ``/rosbridge?ticket=...``.

    Attributes:
        good_for_s: It is void after so many seconds, or once it was shown.
    """

    ticket: str
    good_for_s: int


@post(
    "/tickets",
    status_code=HTTP_201_CREATED,
    summary="A ticket for the URL of a WebSocket",
    tags=["sessions"],
)
async def new_ticket(tickets: Tickets, caller: Who) -> TicketOut:
    """Return a ticket that stands for the caller once, within a minute."""
    return TicketOut(tickets.issue(caller), GOOD_FOR_S)
