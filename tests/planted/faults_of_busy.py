"""Guards of orders for robots at work, each taken out by one small change."""

from __future__ import annotations

from tests.planted.faults import Fault

BUSY = "tests/gateway/test_busy.py"
MAILBOX = "tests/linker/test_robot_queue.py"

OF_BUSY = (
    Fault(
        name="an order for a busy robot is claimed and accepted before it is refused",
        file="gateway/pipeline.py",
        guard="                self._busy.check(request, caller.principal, line.text)\n",
        without="                pass\n",
        caught_by=(f"{BUSY}::test_it_is_said_once_and_nothing_is_claimed",),
    ),
    Fault(
        name="a drone that is busy does not land",
        file="linker/robot_queue.py",
        guard="        if entry.order.skill.to_safety:\n",
        without="        if False:\n",
        caught_by=(f"{BUSY}::test_a_drone_may_always_land",),
    ),
    Fault(
        name="an order is lost that comes together with the one whose place it takes",
        file="linker/robot_queue.py",
        guard="        if self.gives_way:\n",
        without="        if False:\n",
        caught_by=(f"{MAILBOX}::test_what_is_replaced_before_it_was_relayed_never_begins",),
    ),
    Fault(
        name="stop, then this leaves what runs",
        file="gateway/busy.py",
        guard="                if order.robot in robots:\n",
        without="                if False:\n",
        caught_by=(f"{BUSY}::test_stop_then_this_ends_ones_own_and_latches_nothing",),
    ),
    Fault(
        name="stop, then this is offered for somebody else's order",
        file="gateway/busy.py",
        guard="        if whose != principal:\n",
        without="        if False:\n",
        caught_by=(f"{BUSY}::test_of_somebody_elses_it_says_whose_and_ends_nothing",),
    ),
)
