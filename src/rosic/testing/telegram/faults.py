"""Faults on demand: what a network, a proxy or Telegram itself does to a call.

The outcomes of https://core.telegram.org/bots/api#making-requests that a client must survive;
Telegram's docs are silent on failures below HTTP, these are the ones of every network.
"""

from __future__ import annotations

from typing import Literal, TypeAlias

import msgspec

FaultKind: TypeAlias = Literal[
    "too_many_requests",
    "bad_gateway",
    "error",
    "truncated",
    "hang",
    "hang_after",
    "reset",
    "drop_answer",
]
"""What happens, and whether the call has taken effect:

- too_many_requests: 429 with `retry_after_s`; no effect
- bad_gateway: 502 with a page of HTML; no effect
- error: `code` and `description` as given; no effect
- hang: no answer for `seconds`, then the connection ends; no effect
- reset: the connection is reset; no effect
- truncated: half of the JSON answer; the effect has happened
- hang_after: as hang; the effect has happened
- drop_answer: the connection is reset; the effect has happened
"""

AFTER = frozenset({"truncated", "hang_after", "drop_answer"})
BAD_GATEWAY = (
    b"<html>\r\n<head><title>502 Bad Gateway</title></head>\r\n<body>\r\n"
    b"<center><h1>502 Bad Gateway</h1></center>\r\n<hr><center>nginx</center>\r\n"
    b"</body>\r\n</html>\r\n"
)


class ServerFault(msgspec.Struct, kw_only=True, forbid_unknown_fields=True):
    """One order to fail.

    Attributes:
        method: Name of a method, or "*" for every one.
        times: How many calls more.
        chat_id: Only calls to this chat.
        seconds: How long a hang lasts.
    """

    kind: FaultKind
    method: str = "*"
    times: int = 1
    chat_id: int | None = None
    retry_after_s: int = 1
    seconds: float = 60.0
    code: int = 500
    description: str = "Internal Server Error"

    def fits(self, method: str, chat_id: object) -> bool:
        """Say whether this call is to fail."""
        named = self.method == "*" or self.method.lower() == method.lower()
        return named and (self.chat_id is None or str(self.chat_id) == str(chat_id))

    def spend(self) -> bool:
        """Count one call that fails; return whether it was the last."""
        self.times -= 1
        return self.times <= 0


class ServerFaults:
    """The orders in force.

    Attributes:
        latency_s: Added to every call, half before and half after it takes effect.
        bits_per_s: How fast a body goes up and down beside that; 0 is at once.
        orders: The first that fits is used.
    """

    def __init__(self) -> None:
        self.latency_s = 0.0
        self.bits_per_s = 0.0
        self.orders: list[ServerFault] = []

    def slow_down(self, latency_s: float, bits_per_s: float = 0.0) -> None:
        """Let every call go over such a network from now on."""
        self.latency_s = latency_s
        self.bits_per_s = bits_per_s

    def way_s(self, size: int) -> float:
        """Return how long a body of so many bytes is on its way, there or back."""
        sending_s = size * 8 / self.bits_per_s if self.bits_per_s > 0 else 0.0
        return self.latency_s / 2 + sending_s

    def next_for(self, method: str, chat_id: object) -> ServerFault | None:
        """Return the fault for this call and count it."""
        fault = next((order for order in self.orders if order.fits(method, chat_id)), None)
        if fault is not None and fault.spend():
            self.orders.remove(fault)
        return fault

    def clear(self) -> None:
        """End all faults and the latency."""
        self.slow_down(0.0)
        self.orders.clear()
