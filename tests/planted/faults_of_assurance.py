"""Faults in what is done of what nobody can be sure of, and in what a chat is worth."""

from __future__ import annotations

from tests.planted.faults import Fault

UNVERIFIED = "tests/gateway/test_unverified_messages.py"

OF_ASSURANCE = (
    Fault(
        name="I17 what nobody can be sure of is followed like anything else",
        file="gateway/pipeline.py",
        guard="self._chat if inbound.standing is FRESH else self._unverified",
        without="self._chat",
        caught_by=(f"{UNVERIFIED}::test_it_changes_nothing",),
    ),
    Fault(
        name="I17 a tap that nobody can be sure of uses a button up",
        file="gateway/unverified_messages.py",
        guard="if command is not None and not self._only_shows(caller, command):",
        without="if False:",
        caught_by=(f"{UNVERIFIED}::test_a_tap_that_nobody_is_sure_of_leaves_the_button_good",),
    ),
    Fault(
        name="every message is worth what its messenger is",
        file="contracts/chats.py",
        guard="if inbound.assurance is None else inbound.assurance",
        without="",
        caught_by=(f"{UNVERIFIED}::test_each_message_is_worth_what_its_messenger_says_of_it",),
    ),
)
