"""What goes to Matrix: texts as given, buttons as signs and numbers, edits."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rosic.core.message import Button, Chat, ChatKind
from rosic.messengers.matrix import outgoing
from rosic.messengers.matrix.outgoing import Offers
from rosic.messengers.matrix.signs import KEYS

ROOM = "!room:example.org"
YES, NO = Button("Yes", "omni move 1 m", "nonce-1"), Button("No", "cancel", "nonce-2")
STOP = Button("Stop", "stop omni", "nonce-3")


def test_a_text_without_buttons_stays_as_it_is() -> None:
    assert outgoing.labelled("*omni* <b>", ()) == "*omni* <b>"


def test_a_row_of_buttons_is_a_line_beneath() -> None:
    shown = outgoing.labelled("Move?", ((YES, NO), (STOP,)))
    assert shown == "Move?\n\n1. Yes   2. No\n3. Stop"


def test_from_the_eleventh_on_a_button_shows_its_sign() -> None:
    rows = [(Button(f"b{n}", "x", f"n{n}"),) for n in range(1, 13)]
    assert outgoing.labelled("", rows).split("\n")[9:11] == ["10. b10", f"11. b11 {KEYS[10]}"]


def test_a_sign_or_a_number_taps_the_button_in_its_place() -> None:
    offers = Offers()
    offers.offer(ROOM, "$m", (YES, NO))
    for sign in (KEYS[1], KEYS[1].replace("\ufe0f", ""), "2"):
        tapped = offers.tapped(ROOM, "$m", sign)
        assert tapped is not None
        assert tapped.nonce == "nonce-2"
    for other in ("3", "0", "-1", "٢", "👍", "", "22222222222222222222"):
        assert offers.tapped(ROOM, "$m", other) is None
    assert offers.tapped("!elsewhere:example.org", "$m", "1") is None


def test_other_buttons_take_the_place_of_those_before() -> None:
    offers = Offers()
    offers.offer(ROOM, "$m", (YES,))
    offers.offer(ROOM, "$m", (NO,))
    tapped = offers.tapped(ROOM, "$m", "1")
    assert tapped is not None
    assert tapped.nonce == "nonce-2"
    offers.offer(ROOM, "$m", ())
    assert offers.tapped(ROOM, "$m", "1") is None


def test_a_button_that_stops_is_known_by_its_nonce() -> None:
    offers = Offers()
    offers.offer(ROOM, "$m", (YES, STOP))
    assert offers.stops("nonce-3")
    assert not offers.stops("nonce-1")


def test_another_run_knows_which_buttons_there_were() -> None:
    before, after = Offers(), Offers()
    before.offer(ROOM, "$m", (YES, STOP))
    after.restore(before.kept())
    tapped = after.tapped(ROOM, "$m", "2")
    assert tapped is not None
    assert after.stops(tapped.nonce)
    after.restore(b"{}")
    assert after.known


def test_what_is_remembered_is_bounded() -> None:
    offers = Offers()
    for number in range(outgoing.REMEMBERED + 10):
        offers.offer(ROOM, f"${number}", (Button("Stop", "stop", f"n{number}"),))
    assert len(offers._offered) == len(offers._stops) == outgoing.REMEMBERED


def test_an_edit_names_what_it_changes_and_reads_well_without_edits() -> None:
    content = outgoing.replacing("$m", outgoing.words("done"))
    assert content["body"] == "* done"
    assert content["m.new_content"] == {"msgtype": "m.text", "body": "done"}
    assert content["m.relates_to"] == {"rel_type": "m.replace", "event_id": "$m"}


def test_an_answer_in_a_thread_stays_in_it() -> None:
    chat = Chat("matrix", ROOM, ChatKind.GROUP, "$root")
    inside = outgoing.related(chat, "")["m.relates_to"]
    assert (inside["rel_type"], inside["event_id"], inside["is_falling_back"]) == (
        "m.thread",
        "$root",
        True,
    )
    assert outgoing.related(chat, "$m")["m.relates_to"]["is_falling_back"] is False
    assert outgoing.related(Chat("matrix", ROOM), "") == {}


@given(st.text(alphabet="ab ü\n🤖", max_size=200))
def test_pieces_of_a_long_text_are_the_text(seed: str) -> None:
    text = (seed * 2_000)[:60_000].strip()
    cut = outgoing.pieces(text)
    assert all(len(piece.encode()) <= outgoing.TEXT_BYTES for piece in cut)
    assert "".join("".join(cut).split()) == "".join(text.split())
