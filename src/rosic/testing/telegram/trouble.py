"""Trouble, for tests: faults, latency, limits, time, and tricks with the queue."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.testing.telegram.faults import ServerFault, ServerFaults
from rosic.testing.telegram.refusals import ControlError
from rosic.testing.telegram.settings import Limits

if TYPE_CHECKING:
    from rosic.testing.telegram.state import JsonObject
    from rosic.testing.telegram.world import World


class Trouble:
    """The control side's switches. All are off at first, except the limits."""

    world: World
    faults: ServerFaults

    def fail(self, kind: str, method: str = "*", times: int = 1, **details: object) -> None:
        """Let the next `times` calls of a method fail; see `ServerFault` for kinds and details."""
        try:
            order = {"kind": kind, "method": method, "times": times, **details}
            self.faults.orders.append(msgspec.convert(order, ServerFault))
        except msgspec.ValidationError as error:
            raise ControlError(str(error)) from None

    def calm(self) -> None:
        """End all faults and the latency."""
        self.faults.clear()

    def set_latency(self, seconds: float) -> None:
        """Add this to every call, half before and half after it takes effect."""
        self.faults.latency_s = seconds

    def set_limits(self, limits: JsonObject | Limits | None) -> None:
        """Choose other flood limits, starting anew; None switches them off."""
        chosen = msgspec.convert(limits, Limits) if isinstance(limits, dict) else limits
        self.world.limiter.set(chosen)

    def advance(self, seconds: float) -> None:
        """Move the server's time; retention, limits and dates follow."""
        self.world.clock.advance(seconds)

    def shift_dates(self, seconds: float) -> None:
        """Put dates on new messages that are off by this much: a platform whose clock is wrong."""
        self.world.clock.date_shift_s = seconds

    def duplicate(self, *, new_id: bool = False) -> None:
        """Queue the next update twice, under the same update_id or a new one."""
        self.world.queue.duplicate_next(new_id=new_id)

    def reorder(self) -> None:
        """Give the next two or more updates in reversed order."""
        self.world.queue.reverse_next()

    def jump(self, next_update_id: int) -> None:
        """Choose the next update_id; lower ones too, while none waits."""
        self.world.queue.jump(next_update_id)

    def put_update(self, kind: str, payload: JsonObject) -> int | None:
        """Queue any update whatever, for what this server does not model (polls, payments)."""
        lifetime_s = self.world.settings.update_lifetime_s
        return self.world.queue.put(kind, payload, self.world.clock.now_s() + lifetime_s)

    def foreign_webhook(self, url: str) -> None:
        """Set a webhook as a thief of the token would, or remove it with ""."""
        if url:
            self.world.queue.expel()
        self.world.state.webhook.url = url
