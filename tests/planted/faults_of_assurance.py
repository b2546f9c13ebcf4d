"""Faults in what is done of what nobody can be sure of, and in what a chat is worth."""

from __future__ import annotations

from tests.planted.faults import Fault

VERIFYING = "tests/features/verification/test_verification.py"
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
    Fault(
        name="emoji are shown in a chat that the homeserver can write in",
        file="features/verification/service.py",
        guard="return private and chat_assurance_of(messenger, chat) >= Assurance.E2EE_VERIFIED",
        without="return private",
        caught_by=(f"{VERIFYING}::test_somebody_asks_and_an_admin_compares_on_another_messenger",),
    ),
    Fault(
        name="whoever runs the homeserver says that emoji match",
        file="features/verification/commands.py",
        guard="assurance_of(asked.messenger, asked.inbound) < Assurance.E2EE_VERIFIED",
        without="not asked.inbound",
        caught_by=(
            f"{VERIFYING}::test_a_chat_whose_keys_were_compared_is_as_good_as_another_messenger",
        ),
    ),
    Fault(
        name="emoji that were shown elsewhere are said to match",
        file="features/verification/commands.py",
        guard="if where not in pending.shown_in:",
        without="if False:",
        caught_by=(f"{VERIFYING}::test_only_where_they_were_shown",),
    ),
    Fault(
        name="anybody compares emoji",
        file="features/verification/commands.py",
        guard="if asked.caller.is_program or not self._organiser.rights.holds(",
        without="if asked.caller.is_program and not self._organiser.rights.holds(",
        caught_by=(f"{VERIFYING}::test_nobody_else_compares",),
    ),
    Fault(
        name="I9 somebody is verified though it cannot be written down",
        file="features/verification/service.py",
        guard="await turn.write((decided,))",
        without="await turn.act((decided,))",
        caught_by=(f"{VERIFYING}::test_what_cannot_be_written_down_is_not_verified",),
    ),
)
