"""I16: whose button is good, where, for how long, and how often."""

from __future__ import annotations

import pytest

from rosic.authoriser.button_tokens import (
    ANYBODY,
    EACH_AT_LEAST,
    EACH_AT_MOST,
    LIFETIME_NS,
    MENU_LIFETIME_NS,
    ButtonTokens,
    lifetime_of,
)
from rosic.core.identity import Address
from rosic.core.message import Button, Chat, Inbound
from rosic.errors import Expired, NotPermitted
from rosic.testing.clock import ManualClock, SeededEntropy

MOVE = Button("Move", "omni move 1 m", act=b"act")


class Shown:
    """Buttons, and who counts what is refused."""

    def __init__(self, at_most: int = 10) -> None:
        self.clock = ManualClock()
        self.refused: list[str] = []
        self.buttons = ButtonTokens(
            self.clock, SeededEntropy(), at_most=at_most, count=self.refused.append
        )

    def tap(
        self, nonce: str, who: str = "p1", chat: str = "c1", *, since_ns: int = 0
    ) -> tuple[str, bytes]:
        now_ns = self.clock.wall_ns()
        inbound = Inbound(
            sender=Address("memory", "1"),
            chat=Chat("memory", chat),
            message="m",
            text="",
            nonce=nonce,
            sent_ns=now_ns,
            received_ns=now_ns,
            listening_since_ns=since_ns,
        )
        return self.buttons.redeem(nonce, who, inbound)[:2]

    async def past_ns(self, lasts_ns: int) -> None:
        await self.clock.advance(lasts_ns / 1e9)


def test_a_button_is_good_once() -> None:
    shown = Shown()
    nonce = shown.buttons.issue(MOVE, "p1", "c1").nonce
    assert len(nonce) >= 16
    assert shown.tap(nonce) == ("omni move 1 m", b"act")
    assert shown.refused == []
    with pytest.raises(Expired, match="no longer good"):
        shown.tap(nonce)
    assert shown.refused == ["button-used"]


@pytest.mark.parametrize(("who", "chat"), [("p2", "c1"), ("p1", "c2")])
def test_a_button_is_good_for_one_person_in_one_chat(who: str, chat: str) -> None:
    shown = Shown()
    nonce = shown.buttons.issue(MOVE, "p1", "c1").nonce
    with pytest.raises(NotPermitted, match="asked of somebody else"):
        shown.tap(nonce, who, chat)
    assert shown.refused == ["button-other"]
    assert shown.tap(nonce)[0] == "omni move 1 m", "a tap by another does not use it up"


@pytest.mark.parametrize(
    ("button", "lasts_ns"),
    [
        (MOVE, LIFETIME_NS),
        (Button("omni", "use omni"), MENU_LIFETIME_NS),
        (Button("Robots", "robots"), MENU_LIFETIME_NS),
        (Button("Join", "/join", good_for_ns=5_000_000_000), 5_000_000_000),
    ],
)
async def test_a_button_is_good_for_its_time_and_not_a_nanosecond_longer(
    button: Button, lasts_ns: int
) -> None:
    assert lifetime_of(button) == lasts_ns
    shown = Shown()
    first, second = (shown.buttons.issue(button, "p1", "c1") for _ in range(2))
    assert first.good_for_ns == lasts_ns
    assert first.nonce != second.nonce
    await shown.past_ns(lasts_ns)
    assert shown.tap(first.nonce)[0] == button.command
    await shown.past_ns(1_000)
    with pytest.raises(Expired, match="too old") as late:
        shown.tap(second.nonce)
    assert late.value.offers == (button.command,)
    assert shown.refused == ["button-late"]
    with pytest.raises(Expired, match="no longer good"):
        shown.tap(second.nonce)


async def test_an_answer_may_live_longer_and_none_less_than_a_minute() -> None:
    shown = Shown()
    long, short = (
        shown.buttons.issue(MOVE, "p1", "c1", lifetime_ns=ns) for ns in (3 * LIFETIME_NS, 1)
    )
    await shown.past_ns(LIFETIME_NS)
    assert shown.tap(short.nonce)
    await shown.past_ns(2 * LIFETIME_NS)
    assert shown.tap(long.nonce)


def test_a_gap_in_listening_ends_what_was_shown_before_it_and_nothing_else() -> None:
    shown = Shown()
    shown_ns = shown.clock.wall_ns()
    before, at, still = (
        shown.buttons.issue(MOVE, "p1", "c1", still=still).nonce for still in (False, False, True)
    )
    with pytest.raises(Expired, match="too old"):
        shown.tap(before, since_ns=shown_ns + 1)
    assert shown.tap(at, since_ns=shown_ns)
    assert shown.tap(still, since_ns=shown_ns + 1), "nothing moves by it"


@pytest.mark.parametrize("command", ["stop", "stop omni"])
def test_a_stop_is_on_the_button_itself_and_good_for_ever(command: str) -> None:
    shown = Shown()
    assert shown.buttons.issue(Button("Stop", command), "p1", "c1").nonce == command
    assert shown.buttons.issue(Button("?", "stopwatch"), "p1", "c1").nonce != "stopwatch"


@pytest.mark.parametrize(
    ("command", "for_ever"),
    [("cancel omni", True), ("cancel all", True), ("cancel booking 3", False), ("cancels", False)],
)
def test_what_ends_what_the_tapper_does_is_on_the_button_itself_and_a_booking_is_not(
    command: str, *, for_ever: bool
) -> None:
    shown = Shown()
    issued = shown.buttons.issue(Button("Cancel", command), "p1", "c1")
    assert (issued.nonce == command) is for_ever


async def test_a_button_for_anybody_is_good_for_all_in_its_chat_as_often_as_they_like() -> None:
    shown = Shown()
    nonce = shown.buttons.issue(MOVE, ANYBODY, "c1").nonce
    for who in ("p1", "p2", "p1"):
        assert shown.tap(nonce, who)
    with pytest.raises(NotPermitted):
        shown.tap(nonce, "p1", "c2")
    await shown.past_ns(LIFETIME_NS + 1_000)
    with pytest.raises(Expired, match="too old"):
        shown.tap(nonce)


def test_what_was_asked_of_somebody_can_be_made_void_and_nothing_else() -> None:
    shown = Shown()
    asked, other, of_another, again = (
        shown.buttons.issue(Button("?", command), who, "c1").nonce
        for command, who in (
            ("!omni move", "p1"),
            ("omni move", "p1"),
            ("!omni move", "p2"),
            ("!cf1 move", "p1"),
        )
    )
    assert shown.buttons.void("p1", "?") == 0
    assert shown.buttons.void("p1", "!") == 2
    for nonce in (asked, again):
        with pytest.raises(Expired, match="no longer good"):
            shown.tap(nonce)
    assert shown.tap(other)
    assert shown.tap(of_another, "p2")


def test_the_oldest_buttons_die_first_when_there_are_too_many() -> None:
    shown = Shown(at_most=3)
    nonces = [shown.buttons.issue(MOVE, "p1", "c1").nonce for _ in range(4)]
    with pytest.raises(Expired):
        shown.tap(nonces[0])
    assert all(shown.tap(nonce) for nonce in nonces[1:])


def test_nobodys_buttons_have_those_of_others_die() -> None:
    shown = Shown(at_most=10 * EACH_AT_MOST)
    other = shown.buttons.issue(MOVE, "p2", "c1").nonce
    nonces = [shown.buttons.issue(MOVE, "p1", "c1").nonce for _ in range(20 * EACH_AT_MOST)]
    assert len(shown.buttons._bound) == EACH_AT_MOST + 1
    assert shown.tap(other, "p2")
    with pytest.raises(Expired):
        shown.tap(nonces[-EACH_AT_MOST - 1])
    assert all(shown.tap(nonce) for nonce in nonces[-EACH_AT_MOST:])
    assert not shown.buttons._own


async def test_of_somebodys_buttons_that_are_too_old_the_newest_are_kept() -> None:
    """What is kept is bounded by what is shown in a lifetime; the sentence still offers more."""
    shown = Shown(at_most=10 * EACH_AT_MOST)
    menus = [shown.buttons.issue(Button("A", "?omni"), "p1", "c1").nonce for _ in range(3)]
    moves = [shown.buttons.issue(MOVE, "p1", "c1").nonce for _ in range(3 * EACH_AT_LEAST)]
    await shown.past_ns(MENU_LIFETIME_NS)
    shown.buttons.issue(MOVE, "p1", "c1")
    assert len(shown.buttons._bound) == len(menus) + len(moves) + 1  # the oldest of them is good
    await shown.past_ns(1)
    newest = shown.buttons.issue(MOVE, "p1", "c1").nonce
    assert len(shown.buttons._bound) == EACH_AT_LEAST
    with pytest.raises(Expired, match="no longer good"):
        shown.tap(moves[0])
    with pytest.raises(Expired, match="too old") as why:
        shown.tap(moves[-1])
    assert why.value.offers == (MOVE.command,)
    assert shown.tap(newest)


def test_what_is_refused_is_refused_though_nobody_counts() -> None:
    shown = Shown()
    shown.buttons = ButtonTokens(shown.clock, SeededEntropy(), count=shown.refused.append)
    with pytest.raises(Expired):
        shown.tap("unknown")


def test_whom_a_button_was_shown_is_known_while_nobody_has_used_it() -> None:
    shown = Shown()
    own = shown.buttons.issue(MOVE, "p1", "c1").nonce
    shared = shown.buttons.issue(MOVE, ANYBODY, "c1").nonce
    assert shown.buttons.asked(own) == "p1"
    assert shown.buttons.asked(shared) is None
    assert shown.buttons.asked("unknown") is None
    shown.tap(own)
    assert shown.buttons.asked(own) is None


def test_what_anybody_may_tap_is_not_counted_as_one_persons() -> None:
    shown = Shown(at_most=2 * EACH_AT_MOST)
    shared = [shown.buttons.issue(MOVE, ANYBODY, "c1").nonce for _ in range(EACH_AT_MOST + 1)]
    assert shown.tap(shared[0]) == ("omni move 1 m", b"act")
