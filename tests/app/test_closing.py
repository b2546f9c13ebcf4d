"""What is said of robots that could not be waited for."""

from __future__ import annotations

from rosic.app.closing import left_behind


def test_it_is_one_sentence_that_names_them() -> None:
    assert left_behind(["cf1"], kept=True) == (
        "cf1 is still coming to rest, as it was told, and stays stopped until somebody resumes it."
    )
    assert left_behind(["cf1", "cf2", "omni"], kept=True) == (
        "cf1, cf2 and omni are still coming to rest, as they were told, and stay stopped until "
        "somebody resumes them."
    )


def test_a_hold_that_is_not_on_disk_is_not_called_one() -> None:
    assert left_behind(["cf1"], kept=False) == (
        "cf1 is still coming to rest, as it was told, and this could not be written down: after a "
        "restart, look before you move anything."
    )
