"""How many calls one order costs: `python -m tests.order_cost`, with `--names` which they are.

Counted is every time that a function of ROSIC is entered, a coroutine also where it goes on: from
the moment at which the pipeline receives a message of one order until its author was told how it
ended. It is an order of `rosic bench pipeline` in memory, one at a time, in words that were read
before; what the bench itself does is left out. It is a count, so it is the same on every machine.
"""

from __future__ import annotations

import asyncio
import sys
from collections import Counter
from itertools import pairwise
from typing import NamedTuple

from rosic.bench.orders import OrderLoad, run
from tests.tracing import Tracer

RECEIVE = ("rosic.gateway.pipeline", "Pipeline.receive")
BENCH = "rosic.bench"
ORDERS = 40
LOAD = OrderLoad(name="one order", orders=ORDERS, in_flight=1)


class OrderCost(NamedTuple):
    """What most of some orders entered, in order: module and function."""

    entered: tuple[tuple[str, str], ...]

    @property
    def calls(self) -> int:
        """How many times a function was entered."""
        return len(self.entered)

    @property
    def modules(self) -> list[str]:
        """The modules they are in."""
        return sorted({module for module, _ in self.entered})


def cost() -> OrderCost:
    """Let a gateway in memory carry out orders, and return what the usual one enters."""
    tracer = Tracer()
    tracer.start()
    try:
        asyncio.run(run(LOAD))
    finally:
        tracer.stop()
    return usual(tracer)


def usual(tracer: Tracer) -> OrderCost:
    """Return what is entered by most of the last orders, each up to the next."""
    began = [n for n, (name, begun) in enumerate(tracer.entered) if begun and name == RECEIVE]
    last = began[-ORDERS:]
    orders = Counter(
        tuple(name for name, _ in tracer.entered[here:there] if not name[0].startswith(BENCH))
        for here, there in pairwise(last)
    )
    return OrderCost(orders.most_common(1)[0][0])


def main(arguments: list[str]) -> int:
    """Print it; return the exit status."""
    found = cost()
    lines = [f"one order: {found.calls} calls in {len(found.modules)} modules"]
    if "--names" in arguments:
        lines += [f"  {module}.{name}" for module, name in found.entered]
    sys.stdout.write("\n".join(lines) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
