"""Guards of Matrix: whose a message is, and that none counts twice."""

from __future__ import annotations

from tests.planted.faults import Fault

TRUST = "tests/messengers/test_matrix_trust.py"
GUARD = "tests/messengers/test_matrix_replay_guard.py"

INCOMING = "tests/messengers/test_matrix_incoming.py"

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
        guard="INSERT OR IGNORE INTO decrypted",
        without="INSERT OR REPLACE INTO decrypted",
        caught_by=(f"{GUARD}::test_the_first_event_keeps_its_place",),
    ),
)
