"""From Matrix's events to messages of ours, and what anybody can send in place of one."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic.core.identity import Address
from rosic.core.message import ChatKind, GeoPoint, MessageValidity
from rosic.messengers.matrix import incoming
from rosic.messengers.matrix.content import EncryptedFile, enclosed_file
from rosic.messengers.matrix.incoming import Known, OfferedNonce, ReceivedMoment, RoomEvent

OWN = "@robots:example.org"
ADA = "@ada:example.org"
ROOM = "!room:example.org"
NOW_NS = 1_700_000_000_000_000_000
RECEIVED = ReceivedMoment(NOW_NS, NOW_NS - 60_000_000_000)
KNOWN = Known(own=OWN)


def event(
    content: dict[str, Any],
    *,
    kind: ChatKind = ChatKind.PRIVATE,
    sender: str = ADA,
    what: str = "m.room.message",
    sent_ms: int = NOW_NS // 1_000_000 - 500,
) -> RoomEvent:
    return RoomEvent(ROOM, kind, "$one", sender, what, sent_ms, content)


def words(text: str, **more: object) -> dict[str, Any]:
    return {"msgtype": "m.text", "body": text, **more}


def test_a_text_says_who_where_and_when() -> None:
    read = incoming.read(event(words("omni move 1 m")), KNOWN, RECEIVED)

    assert read is not None
    assert (read.text, read.message, read.sender) == (
        "omni move 1 m",
        "$one",
        Address("matrix", ADA),
    )
    assert read.sent_ns == NOW_NS - 500_000_000
    assert read.standing is MessageValidity.FRESH


def test_nothing_comes_from_the_future() -> None:
    late = event(words("omni move 1 m"), sent_ms=2**60)
    read = incoming.read(late, KNOWN, RECEIVED)
    assert read is not None
    assert read.sent_ns == read.received_ns


def test_what_we_said_ourselves_is_no_message() -> None:
    assert incoming.read(event(words("stop"), sender=OWN), KNOWN, RECEIVED) is None


def test_an_edit_goes_by_the_message_that_it_changes() -> None:
    link = {"rel_type": "m.replace", "event_id": "$before"}
    edit = words("* stop", **{"m.new_content": words("stop"), "m.relates_to": link})
    read = incoming.read(event(edit), KNOWN, RECEIVED)
    assert read is not None
    assert (read.text, read.message, read.standing) == ("stop", "$before", MessageValidity.EDITED)


@pytest.mark.parametrize("link", [None, {"m.in_reply_to": {"event_id": "$asked"}}, {"rel_type": 1}])
def test_an_edit_whose_homeserver_hides_what_it_changes_is_nothing_new(link: object) -> None:
    edit = words("1", **{"m.new_content": words("1")})
    if link is not None:
        edit["m.relates_to"] = link
    read = incoming.read(event(edit), KNOWN, RECEIVED)
    assert read is not None
    assert (read.message, read.standing) == ("$one", MessageValidity.EDITED)
    assert incoming.refers_to(event(edit)) == ("", "")


def test_nobody_edits_what_another_wrote() -> None:
    link = {"rel_type": "m.replace", "event_id": "$before"}
    edit = words("* stop", **{"m.new_content": words("move"), "m.relates_to": link})
    assert incoming.read(event(edit), Known(own=OWN, author="@bob:x"), RECEIVED) is None


def test_a_reply_says_what_it_answers_and_not_what_it_repeats() -> None:
    link = {"m.in_reply_to": {"event_id": "$asked"}}
    said = words(f"> <{OWN}> at rest\n> or not\n\nstop", **{"m.relates_to": link})
    read = incoming.read(event(said), Known(own=OWN, author=OWN), RECEIVED)
    assert read is not None
    assert (read.text, read.answers, read.answers_us) == ("stop", "$asked", True)


def test_a_quotation_that_is_no_reply_stays() -> None:
    read = incoming.read(event(words("> omni\n\nstop")), KNOWN, RECEIVED)
    assert read is not None
    assert read.text == "> omni\n\nstop"


def test_a_thread_is_a_topic_in_a_group_alone() -> None:
    link = {
        "rel_type": "m.thread",
        "event_id": "$root",
        "is_falling_back": True,
        "m.in_reply_to": {"event_id": "$last"},
    }
    said = words("status", **{"m.relates_to": link})
    group = incoming.read(event(said, kind=ChatKind.GROUP), KNOWN, RECEIVED)
    private = incoming.read(event(said), KNOWN, RECEIVED)
    assert group is not None
    assert private is not None
    assert (group.chat.topic, group.answers) == ("$root", "")
    assert private.chat.topic == ""


def test_our_name_is_taken_off_where_the_markup_says_that_it_is_ours() -> None:
    link = f'<a href="https://matrix.to/#/{OWN}">Robots</a>'
    for body, markup in ((f"{OWN}: stop", ""), ("Robots: stop", f"{link}: stop")):
        said = words(body, formatted_body=markup)
        read = incoming.read(event(said, kind=ChatKind.GROUP), KNOWN, RECEIVED)
        assert read is not None
        assert (read.text, read.addressed) == ("stop", True)


def test_a_display_name_alone_is_nobody() -> None:
    other = '<a href="https://matrix.to/#/@robots:evil.org">Robots</a>'
    said = words("Robots: stop", formatted_body=f"{other}: stop")
    read = incoming.read(event(said, kind=ChatKind.GROUP), KNOWN, RECEIVED)
    assert read is not None
    assert (read.text, read.addressed) == ("Robots: stop", False)


def test_of_programs_only_a_stop_is_heard() -> None:
    assert incoming.read(event({"msgtype": "m.notice", "body": "status"}), KNOWN, RECEIVED) is None
    read = incoming.read(event({"msgtype": "m.notice", "body": "stop"}), KNOWN, RECEIVED)
    assert read is not None
    assert read.standing is MessageValidity.VIA_BOT


def test_a_tap_brings_the_nonce_and_is_dated_when_it_comes() -> None:
    link = {"rel_type": "m.annotation", "event_id": "$offer", "key": "1️⃣"}
    tap = event({"m.relates_to": link}, what="m.reaction")
    assert incoming.refers_to(tap) == ("$offer", "1️⃣")
    known = Known(own=OWN, author=OWN, offered=OfferedNonce("$offer", "nonce"))
    read = incoming.read(tap, known, RECEIVED)
    assert read is not None
    assert (read.nonce, read.under, read.text) == ("nonce", "$offer", "")
    assert read.sent_ns == read.received_ns


def test_a_tap_that_was_late_is_backlog() -> None:
    tap = event({}, what="m.reaction", sent_ms=RECEIVED.listening_since_ns // 1_000_000 - 1)
    known = Known(own=OWN, offered=OfferedNonce("$offer", "nonce"))
    read = incoming.read(tap, known, RECEIVED)
    assert read is not None
    assert read.listening_since_ns > read.received_ns


def test_a_number_in_reply_refers_to_a_button() -> None:
    link = {"m.in_reply_to": {"event_id": "$offer"}}
    said = event(words(f"> <{OWN}> go?\n\n2", **{"m.relates_to": link}))
    assert incoming.refers_to(said) == ("$offer", "2")


def test_an_encrypted_file_says_how_it_is_fetched() -> None:
    file: dict[str, Any] = {
        "url": "mxc://example.org/abc",
        "key": {"k": "key"},
        "iv": "iv",
        "hashes": {"sha256": "digest"},
    }
    said = {
        "msgtype": "m.file",
        "body": "hall.yaml",
        "file": file,
        "info": {"size": 12, "mimetype": "text/yaml"},
    }
    read = incoming.read(event(said), KNOWN, RECEIVED)
    assert read is not None
    assert read.enclosed is not None
    assert (read.enclosed.name, read.enclosed.size, read.text) == ("hall.yaml", 12, "")
    assert enclosed_file(read.enclosed.id) == EncryptedFile(file["url"], "key", "iv", "digest")


def test_what_is_written_beneath_a_file_is_its_text() -> None:
    said = {"msgtype": "m.image", "body": "the hall", "filename": "a.png", "url": "mxc://a/b"}
    read = incoming.read(event(said), KNOWN, RECEIVED)
    assert read is not None
    assert read.enclosed is not None
    assert (read.text, read.enclosed.name) == ("the hall", "a.png")


@pytest.mark.parametrize("url", ["https://evil.org/x", "file:///etc/passwd", 3, None, "mxc:/x"])
def test_a_file_lies_nowhere_but_at_a_homeserver(url: object) -> None:
    said = {"msgtype": "m.file", "body": "a", "url": url}
    assert incoming.read(event(said), KNOWN, RECEIVED) is None


@pytest.mark.parametrize(
    ("uri", "place"),
    [
        ("geo:52.1,13.25;u=12", GeoPoint(52.1, 13.25)),
        ("geo:-1,2,3", GeoPoint(-1.0, 2.0)),
        ("geo:91,0", None),
        ("geo:nan,0", None),
        ("52,13", None),
    ],
)
def test_a_place_is_two_numbers_within_the_earth(uri: str, place: GeoPoint | None) -> None:
    said = {"msgtype": "m.location", "body": "here", "geo_uri": uri}
    read = incoming.read(event(said), KNOWN, RECEIVED)
    assert (None if read is None else read.place) == place


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=10,
)
KEYS = (
    "msgtype",
    "body",
    "m.relates_to",
    "m.new_content",
    "file",
    "url",
    "info",
    "geo_uri",
    "m.mentions",
    "formatted_body",
    "filename",
)
LINK = st.fixed_dictionaries(
    {},
    optional={
        "rel_type": st.sampled_from(["m.replace", "m.thread", "m.annotation"]) | JSON,
        "event_id": JSON,
        "m.in_reply_to": JSON | st.fixed_dictionaries({"event_id": JSON}),
        "key": JSON,
    },
)
CONTENT = st.fixed_dictionaries(
    {}, optional={key: JSON | LINK if key == "m.relates_to" else JSON for key in KEYS}
)


@given(
    CONTENT,
    st.sampled_from(["m.room.message", "m.reaction", "m.x"]),
    st.sampled_from(["m.text", "m.file", "m.location", "m.notice", ""]),
)
def test_whatever_anybody_sends_is_read_or_passed_over(
    content: dict[str, Any], what: str, kind: str
) -> None:
    content = {**content, "msgtype": kind} if kind else content
    one = event(content, what=what)
    incoming.refers_to(one)
    read = incoming.read(one, KNOWN, RECEIVED)
    assert read is None or read.sent_ns <= read.received_ns
