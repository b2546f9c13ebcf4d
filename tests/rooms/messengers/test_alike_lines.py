"""What a line of a small group is known by to every bot that hears it."""

from __future__ import annotations

from rosic.core.identity import Address
from rosic.core.message import Chat, ChatKind, Inbound
from rosic.messengers.telegram.window import MOST_ALIKE, SECONDS_KEPT, AlikeLines


def line(message: int, said: str = "omni wave", sent_ns: int = 0) -> Inbound:
    return Inbound(
        sender=Address("telegram", "1001"),
        chat=Chat("telegram", "-5", ChatKind.GROUP),
        message=str(message),
        text=said,
        sent_ns=sent_ns,
        received_ns=0,
        account="42",
    )


def test_the_same_line_has_the_same_name_however_often_it_is_given_out() -> None:
    """And what was said again in the same second has another, which is that of the other bot."""
    one, other = AlikeLines(), AlikeLines()
    first, second = one.named(line(7)).shared, one.named(line(8)).shared
    assert first != second
    assert [one.named(line(number)).shared for number in (7, 8, 7)] == [first, second, first]
    assert [other.named(line(number)).shared for number in (900, 905)] == [first, second]


def test_of_too_many_that_are_alike_each_bot_counts_its_own() -> None:
    alike = AlikeLines()
    shared = [alike.named(line(number)).shared for number in range(MOST_ALIKE + 1)]
    assert len(set(shared[:MOST_ALIKE])) == MOST_ALIKE
    assert shared[MOST_ALIKE] == ""
    assert alike.named(line(0)).shared == shared[0]


def test_no_more_is_remembered_than_a_while_in_which_somebody_spoke() -> None:
    alike = AlikeLines()
    for second in range(SECONDS_KEPT):
        alike.named(line(second, sent_ns=second))
    assert alike.named(line(5_000)).shared.endswith(" 1"), "the first is still counted"
    alike.named(line(5_001, sent_ns=SECONDS_KEPT))
    assert alike.named(line(5_002)).shared.endswith(" 0"), "the oldest has gone"
