"""Tickets for the address of a WebSocket: good once, for a minute, while its caller is known."""

from __future__ import annotations

import pytest

from rosic.api.tickets import TicketBook
from rosic.app.admin.api import AdminVerb
from rosic.core.time_units import SECOND_NS
from rosic.errors import Unrecognised
from tests.api.bridge_client import bridge, closed
from tests.api.served import served
from tests.gateway.place import ask_as_operator


async def test_a_ticket_is_void_after_a_minute_and_when_its_caller_is_known_no_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with served() as place:
        hal = await place.program("operator")

        async def refused(path: str) -> tuple[int, str]:
            async with bridge(place, path=path) as client:
                return await closed(client)

        tickets = [(await hal.post("/v1/tickets")).json()["ticket"] for _ in range(2)]
        clock = place.server.context.kernel.machine_clock
        with monkeypatch.context() as later:
            now_ns = clock.monotonic_ns
            later.setattr(clock, "monotonic_ns", lambda: now_ns() + 61 * SECOND_NS)
            assert (await refused(f"/rosbridge?ticket={tickets[0]}"))[0] == 4401
        await ask_as_operator(place.gateway, AdminVerb.REVOKE, "Hal")
        assert (await refused(f"/rosbridge?ticket={tickets[1]}"))[0] == 4401


async def test_a_ticket_is_void_at_once_when_its_key_has_ended() -> None:
    async with served() as place:
        context = place.server.context
        key = await place.key("operator")
        caller = context.callers.identify(f"Bearer {key}", "")
        book = TicketBook(
            context.callers, context.kernel.machine_clock, context.kernel.entropy.token
        )
        assert book.redeem(book.issue(caller)) == caller
        ticket = book.issue(caller)
        await ask_as_operator(place.gateway, AdminVerb.REVOKE, "Hal")
        with pytest.raises(Unrecognised):
            book.redeem(ticket)
