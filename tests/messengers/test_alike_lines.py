"""What a line of a small group is known by to every bot that hears it."""

from __future__ import annotations

from msgspec import structs

from rosic.core.identity import Address
from rosic.core.message import Chat, ChatKind, Inbound, MessageValidity
from rosic.messengers.telegram.update_window import MOST_ALIKE, SECONDS_KEPT, AlikeLines


def named(alike: AlikeLines, message: int, date_s: int = 0) -> Inbound:
    inbound = Inbound(
        sender=Address("telegram", "1001"),
        chat=Chat("telegram", "-5", ChatKind.GROUP),
        message=str(message),
        text="omni wave",
        sent_ns=0,
        received_ns=0,
        account="42",
    )
    return alike.named(inbound, date_s, "omni wave")


def test_the_same_line_has_the_same_name_however_often_it_is_given_out() -> None:
    """And what was said again in the same second has another, which is that of the other bot."""
    one, other = AlikeLines(), AlikeLines()
    first, second = named(one, 7).shared, named(one, 8).shared
    assert first != second
    assert [named(one, number).shared for number in (7, 8, 7)] == [first, second, first]
    assert [named(other, number).shared for number in (900, 905)] == [first, second]


def test_what_is_in_no_small_group_or_was_changed_shares_nothing() -> None:
    """A private chat and a supergroup number their messages for everybody."""
    alike, line = AlikeLines(), named(AlikeLines(), 7)
    line = structs.replace(line, shared="")
    others = [Chat("telegram", "5"), Chat("telegram", "-1005", ChatKind.CHANNEL)]
    for other in (
        *(structs.replace(line, chat=chat) for chat in others),
        structs.replace(line, account=""),
        structs.replace(line, standing=MessageValidity.EDITED),
    ):
        assert alike.named(other, 0, "omni wave") == other
    assert alike.named(line, 0, "omni wave").shared


def test_of_too_many_that_are_alike_each_bot_counts_its_own() -> None:
    alike = AlikeLines()
    shared = [named(alike, number).shared for number in range(MOST_ALIKE + 1)]
    assert len(set(shared[:MOST_ALIKE])) == MOST_ALIKE
    assert shared[MOST_ALIKE] == ""
    assert named(alike, 0).shared == shared[0]


def test_no_more_is_remembered_than_a_while_in_which_somebody_spoke() -> None:
    alike = AlikeLines()
    for second in range(SECONDS_KEPT):
        named(alike, second, second)
    assert named(alike, 5_000).shared.endswith(" 1"), "the first is still counted"
    named(alike, 5_001, SECONDS_KEPT)
    assert named(alike, 5_002).shared.endswith(" 0"), "the oldest has gone"
