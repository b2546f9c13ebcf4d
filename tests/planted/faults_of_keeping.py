"""Guards of what has to be on disk, or gone from it, and of what a stop leaves behind."""

from __future__ import annotations

from tests.planted.faults import GATE, Fault

LINKER = "tests/linker/test_linker.py"
HUNG = "tests/gateway/test_hung.py"
LATCH = "tests/stores/test_stop_latch.py"
LANE = "tests/stores/test_write_thread.py"
ROOT_KEY = "tests/stores/test_root_key.py"
SECOND_PERSON = "tests/gateway/test_second_person.py"
OPENING = "tests/stores/test_opening.py"

LOST_RECORD = "tests/stores/test_lost_record.py"
PARTS = "tests/stores/test_parts_of_records.py"
OVERWRITTEN = "tests/stores/test_overwritten.py"

OF_KEEPING = (
    Fault(
        name="a resume that was written too late is said in the record to have had its effect",
        file="container/container.py",
        guard="(resumed,), partial(self.stays_stopped, cid)",
        without="(resumed,), _as_said",
        caught_by=(
            f"{HUNG}::test_a_resume_that_is_written_too_late_is_told_to_have_had_no_effect",
        ),
    ),
    Fault(
        name="I5 a resume that failed leaves the latch open on disk",
        file="linker/linker.py",
        guard="            await done_within(self._clock, KEPT_WITHIN_S, (holding,))\n",
        without="            holding.cancel()\n",
        caught_by=(
            f"{LINKER}::test_a_resume_that_failed_leaves_the_robot_stopped_on_disk_too",
            f"{LINKER}::test_a_resume_that_was_cut_off_leaves_the_robot_stopped_on_disk_too",
        ),
    ),
    Fault(
        name="L1 a resume does not notice that the stop file hangs",
        file="linker/linker.py",
        guard="        if not await done_within(self._clock, KEPT_WITHIN_S, (writing,)):\n",
        without="        if False:\n",
        caught_by=(
            f"{LINKER}::test_a_resume_whose_stop_file_hangs_ends_in_time_and_leaves_the_robot_stopped",
        ),
    ),
    Fault(
        name="I5 only a refusal of the robot's side keeps the latch closed on disk",
        file="linker/linker.py",
        guard="except BaseException:  # failed or cut off",
        without="except RosicError:  # failed or cut off",
        caught_by=(
            f"{LINKER}::test_a_resume_that_was_cut_off_leaves_the_robot_stopped_on_disk_too",
        ),
    ),
    Fault(
        name="I5 the generation is ignored by what goes on",
        file="core/order_gate.py",
        guard="return not self.latched and order.permit.stop_generation >= self.generation",
        without="return not self.latched",
        caught_by=(f"{GATE}::test_what_was_ordered_before_a_stop_does_not_go_on_after_the_resume",),
    ),
    Fault(
        name="I10 a stop is not waited for at the disk",
        file="stores/stop_latch.py",
        guard="            self._wait_for_disk(descriptor)\n",
        without="",
        caught_by=(f"{LATCH}::test_a_stop_is_kept_only_when_the_disk_has_confirmed_it",),
    ),
    Fault(
        name="I13 the name of a key is not waited for at the disk",
        file="stores/root_key.py",
        guard="        wait_for_disk(folder)\n",
        without="        pass\n",
        caught_by=(
            f"{ROOT_KEY}::test_a_key_is_on_disk_before_it_has_its_name_and_its_name_before_it_is_used",
        ),
    ),
    Fault(
        name="a key is not waited for at the disk before it has its name",
        file="stores/root_key.py",
        guard="            wait_for_disk(file.fileno())\n",
        without="",
        caught_by=(
            f"{ROOT_KEY}::test_a_key_is_on_disk_before_it_has_its_name_and_its_name_before_it_is_used",
        ),
    ),
    Fault(
        name="what is erased stays in the file",
        file="stores/sqlite.py",
        guard='        "secure_delete=ON",  # what is erased is overwritten\n',
        without="",
        caught_by=(f"{OPENING}::test_the_settings_really_hold",),
    ),
    Fault(
        name="a write that is cut off is not waited for",
        file="stores/write_thread.py",
        guard="            await job.decided()\n",
        without="",
        caught_by=(
            f"{LANE}::test_a_write_that_is_cut_off_is_waited_for_until_it_is_known_what_became_of_it",
        ),
    ),
    Fault(
        name="a write that is cut off as its end arrives is waited for without end",
        file="stores/write_thread.py",
        guard="        self.told = True\n",
        without="",
        caught_by=(
            f"{LANE}::test_a_write_cut_off_in_the_turn_in_which_its_end_arrives_is_not_waited_for_for_ever",
        ),
    ),
    Fault(
        name="I16 an agreement never expires",
        file="gateway/confirmation.py",
        guard=" or passed_ns(self._clock, request.asked) > int(ASKED_FOR_S * 1e9):",
        without=":",
        caught_by=(
            f"{SECOND_PERSON}::test_an_agreement_is_good_for_five_minutes_since_it_was_asked_for",
        ),
    ),
    Fault(
        name="I16 what was agreed to is not compared at all",
        file="gateway/confirmation.py",
        guard="if not theirs or request.act.command != text or request.act.digest != act:",
        without="if not theirs:",
        caught_by=(
            "tests/gateway/test_agreed_acts.py::test_an_agreement_counts_for_its_own_act_alone",
        ),
    ),
    Fault(
        name="I16 what was agreed to for one is done for another",
        file="gateway/confirmation.py",
        guard="        if not theirs or request",
        without="        if request",
        caught_by=(
            "tests/gateway/test_agreed_acts.py::test_an_agreement_counts_for_whoever_asked_for_it_alone",
        ),
    ),
    Fault(
        name="I13 a record that is older than its mark is taken",
        file="stores/record_mark.py",
        guard="if found.number < known.number:",
        without="if False:",
        caught_by=(f"{LOST_RECORD}::test_a_record_of_the_same_run_is_older",),
    ),
    Fault(
        name="I13 an older database is taken beneath a newer log",
        file="stores/record_mark.py",
        guard="if alone.number < known.folded:",
        without="if False:",
        caught_by=(f"{PARTS}::test_an_older_database_beneath_a_newer_log_is_refused",),
    ),
    Fault(
        name="I13 an older log is taken over a newer database",
        file="stores/record_mark.py",
        guard="if alone.number > found.number:",
        without="if False:",
        caught_by=(f"{PARTS}::test_an_older_log_over_a_newer_database_is_refused",),
    ),
    Fault(
        name="I13 a new log says no number of its own",
        file="stores/record_guard.py",
        guard="            or not self._log_is_marked\n",
        without="",
        caught_by=(f"{PARTS}::test_a_part_from_before_a_log_was_folded_in_is_refused",),
    ),
    Fault(
        name="I13 a refused start folds the log in",
        file="stores/record_guard.py",
        guard="if os.path.lexists(self._log) and self._log.stat().st_size:",
        without="if False:",
        caught_by=(f"{PARTS}::test_an_older_database_beneath_a_newer_log_is_refused",),
    ),
    Fault(
        name="I13 what is decided beside something unfit does not mark the record",
        file="stores/writer.py",
        guard="                if mark is not None:\n"
        "                    sqlite.write_mark(cursor_of(connection), mark)\n",
        without="",
        caught_by=(f"{PARTS}::test_after_something_unfit_the_record_starts_again",),
    ),
    Fault(
        name="I9 an order is claimed in a file that was emptied in place",
        file="stores/record_files.py",
        guard=" or not kept.is_whole()",
        without="",
        caught_by=(f"{OVERWRITTEN}::test_nothing_is_claimed_in_what_was_changed_in_place",),
    ),
    Fault(
        name="I9 a file that cannot be looked at counts as there",
        file="stores/record_files.py",
        guard="nobody can say that it is there\n        return True",
        without="nobody can say that it is there\n        return False",
        caught_by=(f"{OVERWRITTEN}::test_what_cannot_be_looked_at_is_lost",),
    ),
    Fault(
        name="I9 what is lost beside the record hides that the record is",
        file="stores/record_files.py",
        guard=", key=lambda item: not item[1].comes_first)",
        without=", key=lambda item: item[1].comes_first)",
        caught_by=(
            f"{OVERWRITTEN}::test_nothing_at_all_is_written_when_the_record_is_gone_with_others",
        ),
    ),
    Fault(
        name="I13 a record that went back meanwhile is gone on with",
        file="stores/record_guard.py",
        guard="if not self._is_as_it_was(found) or not self._has_grown(self._files.mark()):",
        without="if False:",
        caught_by=(
            f"{OVERWRITTEN}::test_what_was_changed_in_place_does_not_come_back_by_itself",
            f"{OVERWRITTEN}::test_a_copy_that_is_put_back_in_place_is_noticed",
        ),
    ),
    Fault(
        name="I13 a lost record is begun anew by itself",
        file="stores/record_mark.py",
        guard="if begun and not self._begin_anew:",
        without="if False:",
        caught_by=(f"{LOST_RECORD}::test_a_lost_record_is_not_begun_anew_by_itself",),
    ),
    Fault(
        name="I9 an order is claimed in a file that is gone",
        file="stores/record_guard.py",
        guard="lost = self._kept.lost()",
        without='lost = ""',
        caught_by=(f"{LOST_RECORD}::test_nothing_is_claimed_while_a_file_is_gone",),
    ),
    Fault(
        name="the lock holds by its file alone",
        file="stores/data_dir.py",
        guard="            self._lock_itself()\n",
        without="",
        caught_by=(f"{LOST_RECORD}::test_the_lock_holds_though_its_file_is_gone",),
    ),
    Fault(
        name="I13 a change is said to be done where there is no record",
        file="app/admin/offline.py",
        guard="if seeding is OfflineSeeding.WRITTEN and not there:",
        without="if False:",
        caught_by=(
            "tests/cli/test_access.py::test_nothing_is_said_to_be_done_where_there_is_no_record",
        ),
    ),
    Fault(
        name="digests of robots bypass the archive",
        file="features/robot_to_robot/digest.py",
        guard="messenger.name: messenger for messenger in reach.messengers",
        without="messenger.name: messenger._messenger for messenger in reach.messengers",
        caught_by=(
            "tests/features/robot_to_robot/test_shared_state.py::test_a_digest_is_in_the_archive_of_the_chat_that_reads_it",
        ),
    ),
    Fault(
        name="a bad value in the record is a trace",
        file="stores/decoding.py",
        guard="if value is not None and not isinstance(value, kind):",
        without="if False:",
        caught_by=("tests/stores/test_bad_values.py",),
    ),
)
