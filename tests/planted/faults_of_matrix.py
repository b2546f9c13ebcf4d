"""Guards of Matrix: whose a message is, and that none counts twice."""

from __future__ import annotations

from tests.planted.faults import Fault

TRUST = "tests/messengers/test_matrix_trust.py"
GUARD = "tests/messengers/test_matrix_replay_guard.py"

INCOMING = "tests/messengers/test_matrix_incoming.py"

WIRE = "tests/messengers/test_matrix_wire.py"

READERS = "tests/messengers/test_matrix_room_readers.py"

HOSTILE = "tests/messengers/test_matrix_hostile.py"

OF_MATRIX = (
    Fault(
        name="what stands beside a stop counts, whoever sent it",
        file="messengers/matrix/sync_window.py",
        guard="_stop_alone(one.inbound) if one.urgent",
        without="one.inbound if one.urgent",
        caught_by=(f"{HOSTILE}::test_beside_a_stop_that_nobody_looked_at_nothing_counts",),
    ),
    Fault(
        name="an edit whose relation was taken away is a new message",
        file="messengers/matrix/incoming.py",
        guard=' or "m.new_content" in content',
        without="",
        caught_by=(
            f"{INCOMING}::test_an_edit_whose_homeserver_hides_what_it_changes_is_nothing_new",
        ),
    ),
    Fault(
        name="a session may claim another fingerprint",
        file="messengers/matrix/trust.py",
        guard="if device.ed25519 != evidence.ed25519 and not evidence.forwarded:",
        without="if False:",
        caught_by=(f"{TRUST}::test_a_session_that_claims_another_fingerprint_is_forged",),
    ),
    Fault(
        name="a session that was handed on counts as its owner's",
        file="messengers/matrix/trust.py",
        guard="return SenderAssurance.ENCRYPTED_UNVERIFIED if evidence.forwarded else worth",
        without="return worth",
        caught_by=(f"{TRUST}::test_a_session_that_was_handed_on_is_hearsay",),
    ),
    Fault(
        name="a message is of whatever room it comes in",
        file="messengers/matrix/trust.py",
        guard="if evidence.stated_room != evidence.room or (device is None and others):",
        without="if device is None and others:",
        caught_by=(f"{TRUST}::test_a_message_of_another_room_is_forged",),
    ),
    Fault(
        name="another event takes the place of a message in its session",
        file="messengers/matrix/replay_guard.py",
        guard="same = known[0] == event",
        without="same = True",
        caught_by=(f"{GUARD}::test_another_run_knows_what_was_decrypted",),
    ),
    Fault(
        name="a message that was held back is as new as it says",
        file="messengers/matrix/replay_guard.py",
        guard="bounds = [received_ms, record.later_ms(index)]",
        without="bounds = [received_ms, None]",
        caught_by=(f"{GUARD}::test_what_comes_after_what_was_written_later_is_as_old_as_that",),
    ),
    Fault(
        name="an answer is taken apart in one piece",
        file="messengers/matrix/step_budget.py",
        guard="if perf_counter() - self._since_s >= STEP_S:",
        without="if False:",
        caught_by=(f"{WIRE}::test_no_answer_takes_the_event_loop_for_long",),
    ),
    Fault(
        name="stops wait for the keys beside them",
        file="messengers/matrix/sync.py",
        guard="if room in self._client.rooms and self._since:",
        without="if False:",
        caught_by=(
            f"{WIRE}::test_a_room_whose_messages_cannot_be_had_holds_up_no_stop_and_no_other_room",
        ),
    ),
    Fault(
        name="whoever the homeserver adds to a room is given its keys",
        file="messengers/matrix/room_readers.py",
        guard="known = [user for user in others if self._knows(user)] if self._strict else []",
        without="known: list[str] = []",
        caught_by=(f"{READERS}::test_a_stranger_whom_the_homeserver_adds_is_given_none",),
    ),
    Fault(
        name="a room is for everybody once the homeserver says that whoever was compared has left",
        file="messengers/matrix/cross_signing.py",
        guard="if self._book.is_confidential(room):",
        without="if False:",
        caught_by=(f"{READERS}::test_where_keys_were_compared_nobody_else_is_given_any",),
    ),
)
