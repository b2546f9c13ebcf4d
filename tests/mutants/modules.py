"""Which source is mutated, and which tests can see it."""

from __future__ import annotations

import msgspec


class Module(msgspec.Struct, frozen=True):
    """One module of safety code.

    Attributes:
        about: As the table calls it.
        file: Below ``src/rosic``.
        tests: Files and folders that are looked into for tests that reach a changed line.
    """

    about: str
    file: str
    tests: tuple[str, ...]


PIPELINE = "tests/rooms/pipeline"
STORES = "tests/rooms/stores"

RIGHTS = tuple(
    f"tests/core/rights/test_{name}.py"
    for name in ("answers", "decision", "exhaustive", "limits", "mistakes", "oracle", "rights")
)

MODULES = (
    Module("gate", "core/gate.py", (
        "tests/core/test_gate.py", "tests/rooms/robots/test_common_start.py",
    )),
    Module("stop board", "core/stopboard.py", (
        "tests/core/test_stopboard.py", "tests/rooms/test_linker.py",
        f"{PIPELINE}/test_stopping.py", f"{PIPELINE}/test_stops_meet.py",
        f"{PIPELINE}/test_set_back.py", f"{PIPELINE}/test_fleet.py",
    )),
    Module("linker", "linker/linker.py", (
        "tests/rooms/test_linker.py", "tests/rooms/test_mailbox.py",
        f"{PIPELINE}/test_stopping.py", f"{PIPELINE}/test_stops_meet.py",
        f"{PIPELINE}/test_between.py", f"{PIPELINE}/test_replacing.py",
        "tests/rooms/test_pursuit.py", f"{PIPELINE}/test_stop_pursued.py",
    )),
    Module("stop pursuit", "linker/pursuit.py", (
        "tests/rooms/test_pursuit.py", f"{PIPELINE}/test_stop_pursued.py",
    )),
    Module("mailbox", "linker/mailbox.py", (
        "tests/rooms/test_mailbox.py", "tests/rooms/test_linker.py",
        f"{PIPELINE}/test_waited.py",
        f"{PIPELINE}/test_replacing.py",
    )),
    Module("latch", "stores/latch.py", (
        f"{STORES}/test_latch.py", f"{STORES}/test_latch_places.py",
        f"{STORES}/test_overwritten.py", "tests/conformance/test_stores.py",
        "tests/rooms/test_linker.py",
    )),
    Module("stop file", "stores/slots.py", (f"{STORES}/test_latch.py",)),
    Module("write thread", "stores/lane.py", (
        f"{STORES}/test_lane.py", f"{STORES}/test_trouble.py", f"{STORES}/test_latch.py",
    )),
    Module("writer", "stores/writer.py", (
        f"{STORES}/test_reconnecting.py", f"{STORES}/test_lost_record.py",
        f"{STORES}/test_trouble.py", f"{STORES}/test_opening.py", f"{STORES}/test_decisions.py",
        f"{STORES}/test_sealing.py", f"{STORES}/test_overwritten.py",
        f"{STORES}/test_parts_of_records.py", "tests/conformance/test_stores.py",
        "tests/app/test_retention.py",
    )),
    Module("root key", "stores/rootkey.py", (
        f"{STORES}/test_rootkey.py", f"{STORES}/test_opening.py",
    )),
    Module("rights", "core/rights.py", RIGHTS),
    Module("decision", "core/decision.py", RIGHTS),
    Module("limits", "core/limits.py", RIGHTS),
    Module("tables of rights", "core/tables.py", RIGHTS),
    Module("consent", "pipeline/consent.py", (
        f"{PIPELINE}/test_second_person.py", f"{PIPELINE}/test_rights.py",
        f"{PIPELINE}/test_turned_away.py", f"{PIPELINE}/test_agreed_acts.py",
        f"{PIPELINE}/test_withdrawing.py",
    )),
    Module("agreements", "pipeline/agreement.py", (
        f"{PIPELINE}/test_agreements.py", f"{PIPELINE}/test_agreed_acts.py",
        f"{PIPELINE}/test_second_person.py", f"{PIPELINE}/test_end_buttons.py",
    )),
    Module("buttons", "authoriser/buttons.py", (
        "tests/rooms/authoriser/test_buttons.py", f"{PIPELINE}/test_buttons.py",
        "tests/rooms/test_authoriser.py",
        f"{PIPELINE}/test_retracting.py", f"{PIPELINE}/test_end_buttons.py",
    )),
    Module("enrolment", "authoriser/enrolment.py", ("tests/rooms/authoriser",)),
    Module("guessing", "authoriser/guessing.py", (
        "tests/rooms/authoriser/test_guess_limits.py", "tests/rooms/authoriser/test_guessing.py",
    )),
    Module("Telegram listener", "messengers/telegram/listener.py", (
        "tests/rooms/messengers/test_listener.py",
        "tests/rooms/messengers/test_listener_trouble.py",
        "tests/rooms/messengers/test_reading.py",
    )),
    Module("Telegram reading", "messengers/telegram/reading.py", (
        "tests/rooms/messengers/test_listener.py",
        "tests/rooms/messengers/test_listener_trouble.py",
        "tests/rooms/messengers/test_reading.py",
    )),
    Module("Telegram listening", "messengers/telegram/listening.py", (
        "tests/rooms/messengers/test_listening.py",
    )),
)  # fmt: skip
