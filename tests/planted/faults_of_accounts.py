"""Faults in who is one person by several accounts, and in where that person is told something."""

from __future__ import annotations

from tests.planted.faults import Fault

LINKING = "tests/features/access/test_linking.py"
LINKED = "tests/gateway/test_linked_accounts.py"

OF_ACCOUNTS = (
    Fault(
        name="two accounts of one person are two persons",
        file="gateway/confirmation.py",
        guard="if who == request.caller.principal:",
        without="if asked.caller.address == request.caller.address:",
        caught_by=(f"{LINKED}::test_two_accounts_of_one_person_are_not_two_persons",),
    ),
    Fault(
        name="an account that is somebody's becomes somebody else's",
        file="authoriser/account_links.py",
        guard="if person is None or known is not None:",
        without="if person is None:",
        caught_by=(
            f"{LINKING}::test_an_account_that_is_somebodys_stays_theirs",
            f"{LINKING}::test_whoever_lost_their_access_does_not_come_back_as_somebody_else",
        ),
    ),
    Fault(
        name="the file takes an account from whoever linked it",
        file="app/people.py",
        guard="found = _with_free_accounts(person, authoriser.directory)",
        without="found = person",
        caught_by=(f"{LINKED}::test_the_file_takes_no_account_from_whoever_linked_it",),
    ),
    Fault(
        name="a code for an account outlives that whoever asked for it is locked",
        file="gateway/access_registry.py",
        guard="self.links.void(fact.key)",
        without="pass",
        caught_by=(f"{LINKING}::test_a_code_dies_with_the_access_of_whoever_asked_for_it",),
    ),
    Fault(
        name="whoever guessed too often may say a code for an account",
        file="features/access/join.py",
        guard="refused = self._enrolment.not_now(inbound.sender)",
        without="refused = None",
        caught_by=(f"{LINKING}::test_strangers_guess_as_often_as_they_guess_invitations_and_wait",),
    ),
    Fault(
        name="a code for an account is good after a group has read it",
        file="features/access/linking.py",
        guard="burnt = [one for one in map(self._links.burn, codes) if one is not None]",
        without="burnt = []",
        caught_by=(f"{LINKING}::test_a_code_shown_in_a_group_is_good_for_nobody",),
    ),
    Fault(
        name="the last account is taken away",
        file="authoriser/account_links.py",
        guard="if len(person.addresses) == 1:",
        without="if False:",
        caught_by=(f"{LINKING}::test_unlink_alone_shows_ones_accounts",),
    ),
    Fault(
        name="browsers stay signed in when an account is lost",
        file="authoriser/account_links.py",
        guard="sessions = self._page_sessions.end_all(principal)",
        without="sessions = ()",
        caught_by=(f"{LINKING}::test_an_account_that_goes_ends_what_it_may_have_begun",),
    ),
    Fault(
        name="buttons stay good when an account is lost",
        file="gateway/access_registry.py",
        guard='self._authoriser.buttons.void(principal, "")',
        without="pass",
        caught_by=(f"{LINKING}::test_an_account_that_goes_ends_what_it_may_have_begun",),
    ),
    Fault(
        name="what a lost account asked is still asked",
        file="gateway/access_registry.py",
        guard="self.account_lost.emit(principal, address)",
        without="pass",
        caught_by=(
            f"{LINKED}::test_what_was_asked_by_an_account_that_goes_comes_to_nothing",
            f"{LINKED}::test_an_account_that_is_lost_hears_no_robot",
        ),
    ),
    Fault(
        name="a card goes on in an account that is lost",
        file="features/dashboard/dashboards.py",
        guard="if not self._sides.reads(dashboard.owner, dashboard.chat):",
        without="if False:",
        caught_by=(f"{LINKED}::test_a_card_in_an_account_that_is_lost_ends",),
    ),
    Fault(
        name="the archive of an account that is lost goes on",
        file="features/personal_data/__init__.py",
        guard="kernel.access.account_lost.connect(end_archive)",
        without="pass",
        caught_by=(f"{LINKED}::test_nothing_more_is_kept_of_an_account_that_is_lost",),
    ),
    Fault(
        name="a notice goes to a messenger that is not connected",
        file="gateway/delivery/notifier.py",
        guard="there = [place for place in places if is_connected(place.messenger) is not False]",
        without="there = places",
        caught_by=(f"{LINKED}::test_a_messenger_that_is_not_connected_is_passed_over",),
    ),
    Fault(
        name="a notice goes to every account",
        file="gateway/delivery/notifier.py",
        guard="return dict.fromkeys((*changed, *(there or places)[:1]))",
        without="return places",
        caught_by=(f"{LINKED}::test_a_notice_goes_where_the_person_was_last",),
    ),
)
