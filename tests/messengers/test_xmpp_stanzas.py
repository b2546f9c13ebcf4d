"""What a stanza of XMPP says: pure, so the same stanza is the same message."""

from __future__ import annotations

import time
from xml.etree.ElementTree import Element, fromstring

import pytest

from rosic.core.message import Chat, ChatKind, Inbound, MessageValidity
from rosic.core.time_units import SECOND_NS
from rosic.messengers.xmpp import stanzas
from tests.pace import pace

ADA = "ada@example.org"
NOW_NS = 1_700_000_000 * SECOND_NS
MOMENT = stanzas.Moment(NOW_NS, NOW_NS - 7, NOW_NS - 60 * SECOND_NS)
PRIVATE = Chat("xmpp", ADA)
ROOM = Chat("xmpp", "lab@rooms.example.org", ChatKind.GROUP)


def stanza(inside: str, more: str = "id='m1'") -> Element:
    start = (
        f"<message xmlns='jabber:client' from='{ADA}/phone' to='robots@example.org/rosic' {more}>"
    )
    return fromstring(f"{start}{inside}</message>")  # noqa: S314 - written here


def read(inside: str, chat: Chat = PRIVATE) -> Inbound:
    return stanzas.read(stanza(inside), ADA, chat, MOMENT)


def delay(stamp: str) -> str:
    return f"<delay xmlns='urn:xmpp:delay' from='example.org' stamp='{stamp}'/>"


def test_what_has_no_stamp_was_sent_when_it_was_on_its_way_at_the_earliest() -> None:
    assert read("<body>status</body>").sent_ns == MOMENT.earliest_ns


@pytest.mark.parametrize(
    ("stamps", "sent_s"),
    [
        (("2023-11-14T22:13:10Z",), -10),
        (("2023-11-14T23:13:10+01:00",), -10),
        (("2023-11-14T22:13:10.500Z",), -9.5),
        (
            ("2023-11-14T22:13:19Z", "2023-11-14T22:13:10Z"),
            -10,
        ),  # an author's stamp makes it no younger
        (("2023-11-14T22:13:21Z",), 0),
    ],
)
def test_the_oldest_stamp_counts(stamps: tuple[str, ...], sent_s: float) -> None:
    inside = "".join(map(delay, stamps))
    assert read(f"<body>status</body>{inside}").sent_ns == NOW_NS + int(sent_s * SECOND_NS)


@pytest.mark.parametrize(
    "stamp",
    ["", "yesterday", "2023-11-14T22:13:10", "9999-99-99T00:00:00Z", "2024-01-01T00:00:00Z"],
)
def test_a_stamp_that_is_none_or_lies_ahead_makes_it_backlog(stamp: str) -> None:
    assert read(f"<body>status</body>{delay(stamp)}").sent_ns == 0


def test_a_correction_is_an_edit_of_what_it_changes() -> None:
    one = read("<body>omni move 9 m</body><replace xmlns='urn:xmpp:message-correct:0' id='m0'/>")
    assert (one.standing, one.message) == (MessageValidity.EDITED, "m0#")


def test_two_messages_with_one_id_are_two() -> None:
    """Some clients count from one again each time that they sign in."""
    first, second = read("<body>stop</body>"), read("<body>status</body>")
    assert first.message.startswith("m1#")
    assert second.message.startswith("m1#")
    assert first.message != second.message
    assert first.message == read(f"<body>stop</body>{delay('2023-11-14T22:13:10Z')}").message


@pytest.mark.parametrize(
    ("by", "chat", "counts"),
    [
        ("robots@example.org", PRIVATE, True),
        ("lab@rooms.example.org", ROOM, True),
        ("elsewhere@example.org", PRIVATE, False),
    ],
)
def test_only_our_own_archive_or_the_rooms_names_a_message(
    by: str, chat: Chat, *, counts: bool
) -> None:
    named = f"<body>stop</body><stanza-id xmlns='urn:xmpp:sid:0' id='a-1' by='{by}'/>"
    assert (read(named, chat).message == "m1#a-1") is counts


def test_others_are_named_as_they_name_themselves_and_as_the_room_does() -> None:
    assert stanzas.name_for("m1#a-1", PRIVATE) == "m1"
    assert stanzas.name_for("m1#a-1", ROOM) == "a-1"
    assert stanzas.name_for("7f3", ROOM) == "7f3"


def test_a_reply_is_without_what_it_repeats() -> None:
    one = read("<body>&gt; a\n&gt; b\nyes</body><reply xmlns='urn:xmpp:reply:0' id='7f3'/>")
    assert (one.text, one.answers) == ("yes", "7f3")
    assert read("<body>&gt; a\nyes</body>").text == "> a\nyes"


def test_what_a_reply_repeats_takes_no_longer_than_reading_it() -> None:
    repeated = "&gt; \n" * 85_000
    begun_s = time.process_time()
    one = read(f"<body>{repeated}stop</body><reply xmlns='urn:xmpp:reply:0' id='7f3'/>")
    assert one.text == "stop"
    assert time.process_time() - begun_s < 0.2 * pace(), "it was 0.9 s, and is 0.02 s"


def test_a_file_is_its_address_and_nothing_else() -> None:
    url = "https://example.org/up/7f3/hall%202.yaml"
    linked = f"<x xmlns='jabber:x:oob'><url>{url}</url></x>"
    one = read(f"<body>{url}</body>{linked}")
    assert one.enclosed is not None
    assert (one.text, one.enclosed.id, one.enclosed.name) == ("", url, "hall 2.yaml")
    assert read(f"<body>stop</body>{linked}").text == "stop"
    assert read(f"<body>stop</body>{linked}").enclosed is None


@pytest.mark.parametrize("address", ["https://[", "x", "https://example.org/"])
def test_an_address_that_is_none_is_a_text(address: str) -> None:
    linked = f"<x xmlns='jabber:x:oob'><url>{address}</url></x>"
    assert read(f"<body>{address}</body>{linked}").enclosed is None


def test_words_are_those_of_the_message_alone() -> None:
    """Not those that it passes on, and not those of markup beside it."""
    passed_on = (
        "<forwarded xmlns='urn:xmpp:forward:0'><message xmlns='jabber:client'><body>stop</body>"
        "</message></forwarded><html xmlns='http://jabber.org/protocol/xhtml-im'><body>stop</body></html>"
    )
    assert read(passed_on).text == ""


def test_reactions_are_few_and_short() -> None:
    put = "<reaction>1️⃣</reaction>" + "<reaction>👍</reaction>" * 20
    put += f"<reaction>{'x' * 1_000}</reaction>"
    about, signs = stanzas.reacted(
        stanza(f"<reactions xmlns='urn:xmpp:reactions:0' id='7f3'>{put}</reactions>")
    )
    assert about == "7f3"
    assert signs[0] == "1️⃣"
    assert len(signs) == 9


def test_what_is_encrypted_is_known_for_it() -> None:
    assert stanzas.is_encrypted(
        stanza("<body>OMEMO</body><encrypted xmlns='eu.siacs.conversations.axolotl'/>")
    )
    assert not stanzas.is_encrypted(stanza("<body>stop</body>"))


@pytest.mark.parametrize("kind", ["error", "headline", "groupchat"])
def test_only_what_an_account_wrote_is_private(kind: str) -> None:
    """An error repeats what we said ourselves, in the name of whom we said it to."""
    assert not stanzas.is_private(stanza("<body>stop</body>", f"type='{kind}'"))
    assert stanzas.is_private(stanza("<body>stop</body>"))
    beside = "<body>stop</body><x xmlns='http://jabber.org/protocol/muc#user'/>"
    assert not stanzas.is_private(stanza(beside, "type='chat'"))


def test_what_xml_cannot_hold_is_left_out() -> None:
    assert stanzas.speakable("a\x00b\x0bc\ud800d\r\ne\rf\ufffe🤖\t") == "abcd\ne\nf🤖\t"
