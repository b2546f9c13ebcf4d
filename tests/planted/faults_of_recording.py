"""The guards around recordings, and around robots that are shown live."""

from __future__ import annotations

from tests.planted.faults import Fault

OBSERVATION = "gateway/observation.py"
COMMANDS = "features/recording/commands.py"
KEEPER = "features/recording/keeper.py"
FEED = "gateway/observation_feed.py"
RECORDING = "tests/features/recording/test_recording.py::"
SHOWN = "tests/gateway/test_observation_feed.py::"

OF_RECORDING = (
    Fault(
        name="a recording holds the words of others",
        file=OBSERVATION,
        guard="        if asker == self._rights.principal or self._rights.oversees(robot):\n",
        without="        if True:\n",
        caught_by=(
            RECORDING
            + "test_what_others_ask_is_in_it_without_their_words_unless_one_may_read_them",
            SHOWN + "test_whose_access_ends_sees_nothing_from_that_moment",
        ),
    ),
    Fault(
        name="a robot is recorded for whoever may not see it any more",
        file=OBSERVATION,
        guard="            if not self._rights.sees(robot):\n                self.robots.pop",
        without="            if False:\n                self.robots.pop",
        caught_by=(RECORDING + "test_a_right_that_ends_ends_it_and_nothing_later_is_in_it",),
    ),
    Fault(
        name="whoever is locked is sent what was recorded",
        file=COMMANDS,
        guard="if who in self._kernel.rooms.organiser.locked or not self._is_known(who):",
        without="if not self._is_known(who):",
        caught_by=(RECORDING + "test_whoever_is_locked_gets_nothing",),
    ),
    Fault(
        name="whose access was taken back is sent what was recorded",
        file=COMMANDS,
        guard="if who in self._kernel.rooms.organiser.locked or not self._is_known(who):",
        without="if who in self._kernel.rooms.organiser.locked:",
        caught_by=(RECORDING + "test_whose_access_is_taken_back_gets_nothing",),
    ),
    Fault(
        name="others read along a recording",
        file=COMMANDS,
        guard="        check_private(asked)\n",
        without="",
        caught_by=(RECORDING + "test_nobody_reads_along",),
    ),
    Fault(
        name="a recording that a restart cut off is left lying",
        file=KEEPER,
        guard="self._containers.files.unfinished(recorded=True):\n",
        without="():\n",
        caught_by=(RECORDING + "test_a_restart_keeps_what_was_written_and_says_so",),
    ),
    Fault(
        name="what is shown live waits for whoever is slow",
        file=FEED,
        guard='            self._seen.show(("presence", seen.robot), seen, STEP_BYTES)\n',
        without="            self._seen.say(seen, STEP_BYTES)\n",
        caught_by=(SHOWN + "test_a_slow_reader_gets_the_newest_and_keeps_nobody_up",),
    ),
    Fault(
        name="a camera is looked at though nobody looks any more",
        file=FEED,
        guard="            self._shows.pop(gone).cancel()\n",
        without="            pass\n",
        caught_by=(SHOWN + "test_a_camera_is_looked_at_while_somebody_wants_to_see_it",),
    ),
)
