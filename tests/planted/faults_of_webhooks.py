"""Guards of webhooks: who is asked, what is kept, and in which order, each taken out."""

from __future__ import annotations

from tests.planted.faults import Fault

HOOKS = "tests/api/test_webhooks.py"

OF_WEBHOOKS = (
    Fault(
        name="a webhook is posted into the private network",
        file="api/webhooks/addresses.py",
        guard="if not settings.private and is_private(addresses):",
        without="if False:",
        caught_by=(f"{HOOKS}::test_this_machine_is_told_nothing_unless_that_is_said",),
    ),
    Fault(
        name="one public address of a name lets its private ones through",
        file="api/webhooks/settings.py",
        guard="return any(not _is_public(",
        without="return all(not _is_public(",
        caught_by=(f"{HOOKS}::test_which_addresses_are_private",),
    ),
    Fault(
        name="a post is signed without its time",
        file="api/webhooks/settings.py",
        guard='text = b".".join((message.encode(), str(at_s).encode(), body))',
        without='text = b".".join((message.encode(), body))',
        caught_by=(f"{HOOKS}::test_orders_and_stops_of_a_gateway_are_told_signed_and_in_order",),
    ),
    Fault(
        name="a redirect of a webhook is followed",
        file="api/webhooks/delivery.py",
        guard="follow_redirects=False",
        without="follow_redirects=True",
        caught_by=(
            f"{HOOKS}::test_what_is_not_taken_is_told_again_with_the_same_id_and_longer_pauses",
        ),
    ),
    Fault(
        name="I15 what waits for a webhook has no bound",
        file="api/webhooks/delivery.py",
        guard="if self.waiting >= self._at_most:",
        without="if False:",
        caught_by=(f"{HOOKS}::test_too_much_loses_the_oldest_and_says_how_much_is_missing",),
    ),
)
