"""Guards of rosbridge: who comes in, what is published, and what drives on by itself."""

from __future__ import annotations

from tests.planted.faults import Fault

API = "tests/api/test_rosbridge.py"
PORT = "tests/api/test_rosbridge_port.py"

OF_ROSBRIDGE = (
    Fault(
        name="I8 somebody is asked in vain to agree to what is driven",
        file="api/rosbridge/drive.py",
        guard="if self._agreed_first():",
        without="if False:",
        caught_by=(
            f"{API}::test_whoever_needs_somebody_to_agree_is_told_how_and_nobody_is_asked_in_vain",
        ),
    ),
    Fault(
        name="a field that no skill has is left out of a goal",
        file="api/rosbridge/orders.py",
        guard="            _check_literal(field, 0, value)\n",
        without="            pass\n",
        caught_by=(f"{API}::test_a_goal_that_cannot_be_is_refused_in_a_sentence",),
    ),
    Fault(
        name="any page may be a client of rosbridge",
        file="api/access_checks.py",
        guard='and headers.get(b"origin") in self._origins',
        without='and b"origin" in headers',
        caught_by=(
            f"{API}::test_a_page_of_another_site_is_turned_away",
            f"{PORT}::test_pages_elsewhere_are_let_in_by_name_alone",
        ),
    ),
    Fault(
        name="a cookie counts for a page elsewhere",
        file="api/access_checks.py",
        guard="if self._is_named_page(scope, headers):",
        without="if False:",
        caught_by=(f"{PORT}::test_a_cookie_is_worth_nothing_to_a_page_elsewhere",),
    ),
)
