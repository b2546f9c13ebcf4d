"""Guards of rosbridge: who comes in, what is published, and what drives on by itself."""

from __future__ import annotations

from tests.planted.faults import Fault

API = "tests/api/test_rosbridge.py"
PORT = "tests/api/test_rosbridge_port.py"
FLOODS = "tests/api/test_floods.py"
ORDERS = "tests/api/test_orders.py"
QUEUE = "tests/gateway/test_send_queue.py"
STOOD_STILL = "test_what_waited_while_the_gateway_stood_still_moves_nothing_and_a_stop_stops"

REAL = "tests/real/ros2/test_rosbridge.py"

OF_ROSBRIDGE = (
    Fault(
        name="what is published is sent after a stop",
        file="api/rosbridge/connection.py",
        guard="                self._right.check()\n",
        without="                pass\n",
        caught_by=(f"{REAL}::test_after_a_stop_nothing_is_published",),
    ),
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
        guard="if self._is_named_page(scope, headers) or _is_keyed(scope):",
        without="if False:",
        caught_by=(f"{PORT}::test_a_cookie_is_worth_nothing_to_a_page_elsewhere",),
    ),
    Fault(
        name="a head without its body keeps its place",
        file="api/connections.py",
        guard="        if self.parser.should_upgrade():\n",
        without="        if True:\n",
        caught_by=(f"{FLOODS}::test_heads_without_their_bodies_keep_nobody_from_stopping",),
    ),
    Fault(
        name="every stop of a flood is given by itself",
        file="api/stops.py",
        guard="if wait_s <= 0:",
        without="if True:",
        caught_by=(
            f"{FLOODS}::test_a_flood_of_stops_of_one_caller_is_given_as_few_and_none_is_lost",
        ),
    ),
    Fault(
        name="what goes on publishing after a stop drives on",
        file="api/rosbridge/drive.py",
        guard="if self._driven.held(*self._key) > self._rested:",
        without="if False:",
        caught_by=(f"{API}::test_zeros_of_another_connection_let_nobody_drive_on_after_a_stop",),
    ),
    Fault(
        name="a second key takes over what the first has opened",
        file="api/rosbridge/connection.py",
        guard="if self.caller is not None and self.caller.secret != caller.secret:",
        without="if False:",
        caught_by=(f"{API}::test_a_connection_is_of_one_key",),
    ),
    Fault(
        name="what waited while the gateway stood still counts as new",
        file="messengers/program/messenger.py",
        guard="sent_ns=now_ns - self.waited_ns(),",
        without="sent_ns=now_ns,",
        caught_by=(f"{ORDERS}::{STOOD_STILL}",),
    ),
    Fault(
        name="I15 what waits for a slow client grows old",
        file="gateway/send_queue.py",
        guard="if now_s - oldest_s > FRESH_S:",
        without="if False:",
        caught_by=(
            f"{QUEUE}::test_what_is_told_was_never_older_than_a_moment_however_slowly_it_is_taken",
            f"{QUEUE}::test_a_client_that_takes_nothing_is_kept_one_message_of_each_topic",
        ),
    ),
    Fault(
        name="I15 bytes that wait for a slow client are not counted",
        file="gateway/send_queue.py",
        guard="while self._older_bytes > OLDER_BYTES_AT_MOST:",
        without="while False:",
        caught_by=(f"{QUEUE}::test_the_topic_that_has_most_gives_way_and_not_the_others",),
    ),
)
