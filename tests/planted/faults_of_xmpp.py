"""Guards of XMPP, and of what messengers without buttons share."""

from __future__ import annotations

from tests.planted.faults import Fault

STANZAS = "tests/messengers/test_xmpp_stanzas.py"
PLAIN = "tests/messengers/test_plain_messenger.py"

OF_XMPP = (
    Fault(
        name="an author's stamp makes an old message young",
        file="messengers/xmpp/stanzas.py",
        guard="min((*stamps, moment.received_ns)) if stamps",
        without="min(max(stamps), moment.received_ns) if stamps",
        caught_by=(f"{STANZAS}::test_the_oldest_stamp_counts",),
    ),
    Fault(
        name="a stamp that lies ahead is now",
        file="messengers/xmpp/stanzas.py",
        guard="if max(stamps, default=0) > moment.received_ns + 2 * SECOND_NS:",
        without="if False:",
        caught_by=(f"{STANZAS}::test_a_stamp_that_is_none_or_lies_ahead_makes_it_backlog",),
    ),
    Fault(
        name="what comes by way of a room has an account's address",
        file="messengers/xmpp/stanzas.py",
        guard=' and xml.find(f"{USER}x") is None',
        without="",
        caught_by=(f"{STANZAS}::test_only_what_an_account_wrote_is_private",),
    ),
    Fault(
        name="anybody's archive names a message",
        file="messengers/xmpp/stanzas.py",
        guard=' if one.get("by") == by',
        without="",
        caught_by=(f"{STANZAS}::test_only_our_own_archive_or_the_rooms_names_a_message",),
    ),
    Fault(
        name="numbers begin at 1 with every message",
        file="messengers/numbered_buttons.py",
        guard="if self.last >= HIGHEST or now_ns - self.shown_ns > AGAIN_NS:",
        without="if now_ns != self.shown_ns or now_ns:",
        caught_by=(f"{PLAIN}::test_a_number_is_never_that_of_another_button_soon",),
    ),
    Fault(
        name="an edit chooses a button",
        file="messengers/plain_messenger.py",
        guard="if inbound.standing is not MessageValidity.FRESH:",
        without="if False:",
        caught_by=(f"{PLAIN}::test_an_edit_to_a_number_chooses_nothing",),
    ),
    Fault(
        name="strangers take everybody's place",
        file="messengers/chat_lanes.py",
        guard="(self._at_most if known else self._at_most // 2)",
        without="self._at_most",
        caught_by=(f"{PLAIN}::test_strangers_take_no_place_from_people_who_are_known",),
    ),
)
