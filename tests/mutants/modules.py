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


PIPELINE = "tests/gateway"
STORES = "tests/stores"

RIGHTS = tuple(
    f"tests/core/policy/test_{name}.py"
    for name in ("answers", "decision", "exhaustive", "limits", "mistakes", "oracle", "rights")
)

MODULES = (
    Module(
        "gate",
        "core/order_gate.py",
        (
            "tests/core/test_order_gate.py",
            "tests/robots/test_common_start.py",
        ),
    ),
    Module(
        "stops",
        "core/stop_registry.py",
        (
            "tests/core/test_stop_registry.py",
            "tests/linker/test_linker.py",
            "tests/gateway/test_stopping.py",
            "tests/gateway/test_stops_meet.py",
            "tests/gateway/test_set_back.py",
            "tests/features/fleet/test_fleet.py",
        ),
    ),
    Module(
        "linker",
        "linker/linker.py",
        (
            "tests/linker/test_linker.py",
            "tests/linker/test_robot_queue.py",
            "tests/gateway/test_stopping.py",
            "tests/gateway/test_stops_meet.py",
            "tests/gateway/test_between.py",
            "tests/gateway/test_replacing.py",
            "tests/linker/test_pursuit.py",
            "tests/gateway/test_stop_pursued.py",
        ),
    ),
    Module(
        "stop pursuit",
        "linker/pursuit.py",
        (
            "tests/linker/test_pursuit.py",
            "tests/gateway/test_stop_pursued.py",
        ),
    ),
    Module(
        "queue of a robot",
        "linker/robot_queue.py",
        (
            "tests/linker/test_robot_queue.py",
            "tests/linker/test_linker.py",
            "tests/gateway/test_waited.py",
            "tests/gateway/test_replacing.py",
        ),
    ),
    Module(
        "latch",
        "stores/stop_latch.py",
        (
            "tests/stores/test_stop_latch.py",
            "tests/stores/test_latch_places.py",
            "tests/stores/test_overwritten.py",
            "tests/conformance/test_stores.py",
            "tests/linker/test_linker.py",
        ),
    ),
    Module("stop file", "stores/slots.py", ("tests/stores/test_stop_latch.py",)),
    Module(
        "write thread",
        "stores/write_thread.py",
        (
            "tests/stores/test_write_thread.py",
            "tests/stores/test_errors.py",
            "tests/stores/test_stop_latch.py",
        ),
    ),
    Module(
        "writer",
        "stores/writer.py",
        (
            "tests/stores/test_reconnecting.py",
            "tests/stores/test_lost_record.py",
            "tests/stores/test_errors.py",
            "tests/stores/test_opening.py",
            "tests/stores/test_decisions.py",
            "tests/stores/test_encryption.py",
            "tests/stores/test_overwritten.py",
            "tests/stores/test_parts_of_records.py",
            "tests/conformance/test_stores.py",
            "tests/app/test_retention.py",
        ),
    ),
    Module(
        "waits for the record",
        "container/bounded_writes.py",
        (
            "tests/container/test_bounded_writes.py",
            "tests/gateway/test_hung.py",
        ),
    ),
    Module(
        "root key",
        "stores/root_key.py",
        (
            "tests/stores/test_root_key.py",
            "tests/stores/test_opening.py",
        ),
    ),
    Module(
        "samples of live control",
        "core/sample_gate.py",
        (
            "tests/core/test_sample_gate.py",
            "tests/gateway/test_live_control.py",
        ),
    ),
    Module("rights", "core/policy/permissions.py", RIGHTS),
    Module("decision", "core/policy/evaluate.py", RIGHTS),
    Module("limits", "core/policy/limits.py", RIGHTS),
    Module("tables of rights", "core/policy/compiled.py", RIGHTS),
    Module(
        "confirmation",
        "gateway/confirmation.py",
        (
            "tests/gateway/test_second_person.py",
            "tests/gateway/test_rights.py",
            "tests/gateway/test_turned_away.py",
            "tests/gateway/test_agreed_acts.py",
            "tests/gateway/test_withdrawing.py",
            "tests/gateway/test_programs.py",
            "tests/gateway/test_meant_in_groups.py",
            "tests/gateway/test_live_control.py",
        ),
    ),
    Module(
        "agreements",
        "gateway/agreement.py",
        (
            "tests/gateway/test_agreements.py",
            "tests/gateway/test_agreed_acts.py",
            "tests/gateway/test_second_person.py",
            "tests/gateway/test_end_buttons.py",
        ),
    ),
    Module(
        "buttons",
        "authoriser/button_tokens.py",
        (
            "tests/authoriser/test_button_tokens.py",
            "tests/gateway/test_buttons.py",
            "tests/authoriser/test_authoriser.py",
            "tests/gateway/test_redaction.py",
            "tests/gateway/test_end_buttons.py",
        ),
    ),
    Module("enrolment", "authoriser/enrolment.py", ("tests/authoriser",)),
    Module(
        "guessing",
        "authoriser/guessing.py",
        (
            "tests/authoriser/test_guess_limits.py",
            "tests/authoriser/test_guessing.py",
        ),
    ),
    Module(
        "Telegram listener",
        "messengers/telegram/polling.py",
        (
            "tests/messengers/test_polling.py",
            "tests/messengers/test_polling_errors.py",
            "tests/messengers/test_reading.py",
        ),
    ),
    Module(
        "Telegram handing over",
        "messengers/telegram/update_window.py",
        (
            "tests/messengers/test_update_window.py",
            "tests/messengers/test_alike_lines.py",
            "tests/messengers/test_polling.py",
            "tests/messengers/test_reading.py",
        ),
    ),
    Module(
        "Telegram reading",
        "messengers/telegram/reading.py",
        (
            "tests/messengers/test_polling.py",
            "tests/messengers/test_polling_errors.py",
            "tests/messengers/test_reading.py",
        ),
    ),
    Module(
        "Telegram listening",
        "messengers/telegram/polling_gap.py",
        ("tests/messengers/test_polling_gap.py",),
    ),
)
