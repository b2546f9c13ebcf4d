"""The guards of live cards, each taken out."""

from __future__ import annotations

from tests.planted.faults import Fault

CARDS = "tests/features/dashboard/test_dashboards.py"
OWNED = "tests/features/dashboard/test_dashboards_owned.py"

OF_CARDS = (
    Fault(
        name="I11 words on their way show a robot that is none of their reader's any more",
        file="features/dashboard/dashboards.py",
        guard="forbidden = not dashboard.shows.keys() <= set(robots)",
        without="forbidden = False",
        caught_by=(f"{OWNED}::test_words_that_wait_for_their_turn_are_taken_back_with_the_right",),
    ),
    Fault(
        name="I11 a card goes on for somebody who is locked",
        file="features/dashboard/__init__.py",
        guard="if principal in organiser.locked or kernel.access.keys.current(principal) is None:",
        without="if False:",
        caught_by=(f"{OWNED}::test_a_lock_and_a_revocation_end_it_at_once",),
    ),
    Fault(
        name="I11 a card repeats what somebody wrote to a robot",
        file="features/dashboard/dashboard.py",
        guard="if any(parameter.text for parameter in skill.parameters.values()):",
        without="if False:",
        caught_by=(f"{OWNED}::test_what_somebody_says_to_a_robot_is_not_repeated_to_others",),
    ),
    Fault(
        name="a card is edited whenever something changes",
        file="features/dashboard/dashboards.py",
        guard="rested = now_ns >= dashboard.settled_ns + int(pace.between_s * SECOND_NS)",
        without="rested = True",
        caught_by=(f"{CARDS}::test_however_much_changes_there_are_few_edits",),
    ),
    Fault(
        name="a card on which nothing changes becomes older than it says",
        file="features/dashboard/dashboards.py",
        guard="now_ns >= old_ns",
        without="now_ns < 0",
        caught_by=(f"{CARDS}::test_what_is_shown_is_never_older_than_it_says",),
    ),
    Fault(
        name="a card that was deleted comes again",
        file="features/dashboard/dashboards.py",
        guard="        except MessageGone:\n            await self._gone(dashboard)\n",
        without=(
            "        except MessageGone:\n"
            '            dashboard.message, dashboard.stamped_ns = "", 0\n'
        ),
        caught_by=(f"{CARDS}::test_whose_message_was_deleted_is_over",),
    ),
    Fault(
        name="a card is not written down",
        file="features/dashboard/dashboards.py",
        guard="        if first:\n            await self._write(dashboard)\n",
        without="",
        caught_by=(f"{CARDS}::test_it_goes_on_in_the_same_message_after_a_restart",),
    ),
)
