from __future__ import annotations

from typing import Any

import pytest

from rosic.messengers.matrix.emoji import EMOJI
from rosic.messengers.matrix.sas import SasCancel, SasEnd, SasExchange, SasPhase
from rosic.messengers.matrix.signed_json import ED25519, to_base64
from tests.messengers.matrix_identities import (
    ADA,
    ROBOT,
)

Event = dict[str, Any]


def _end(user: str, key: str) -> SasEnd:
    return SasEnd(user=user, device="DEV", keys={f"{ED25519}:DEV": key, f"{ED25519}:{key}": key})


def _frame(content: Event) -> Event:
    return {**content, "transaction_id": "t"}


def _exchange(own_keys: dict[str, str] | None = None) -> tuple[SasExchange, SasExchange]:
    """Return both ends of one; the first vouches for these keys as well."""
    ada, robot = _end(ADA, "A" * 43), _end(ROBOT, "B" * 43)
    vouching = SasEnd(user=ADA, device="DEV", keys={**ada.keys, **(own_keys or {})})
    return SasExchange("t", vouching, robot, _frame), SasExchange("t", robot, ada, _frame)


def _phase(one: SasExchange) -> SasPhase:
    return one.phase


def _up_to_shown(one: SasExchange, two: SasExchange) -> None:
    [(_, start)] = one.start()
    [(_, accept)] = two.started(start)
    [(_, key)] = one.accepted(accept)
    [(_, answer)] = two.key(key)
    assert one.key(answer) == []


def test_keys_are_compared_by_what_both_were_shown() -> None:
    one, two = _exchange()
    _up_to_shown(one, two)
    assert one.shown().emoji == two.shown().emoji
    [(_, macs)] = one.confirm()
    two.macs(macs)
    assert _phase(two) is SasPhase.SHOWN
    two.confirm()
    assert _phase(two) is SasPhase.DONE
    assert two.compared == {f"{ED25519}:DEV", f"{ED25519}:{'A' * 43}"}


def test_what_is_vouched_for_and_is_no_cross_signing_key_is_passed_over() -> None:
    one, two = _exchange({"ed25519:OTHER": "C" * 43})
    _up_to_shown(one, two)
    [(_, macs)] = one.confirm()
    two.macs(macs)
    assert two.compared == {f"{ED25519}:DEV", f"{ED25519}:{'A' * 43}"}


def test_a_key_that_is_vouched_for_and_not_shown_ends_it() -> None:
    hidden = to_base64(b"\x01" * 32)
    one, two = _exchange({f"{ED25519}:{hidden}": hidden})
    _up_to_shown(one, two)
    [(_, macs)] = one.confirm()
    with pytest.raises(SasCancel, match="Another key"):
        two.macs(macs)


def test_whoever_vouches_for_all_but_their_device_is_not_believed() -> None:
    ada, robot = _end(ADA, "A" * 43), _end(ROBOT, "B" * 43)
    master = {f"{ED25519}:{'A' * 43}": "A" * 43}
    one = SasExchange("t", SasEnd(user=ADA, device="DEV", keys=master), robot, _frame)
    two = SasExchange("t", robot, ada, _frame)
    _up_to_shown(one, two)
    [(_, macs)] = one.confirm()
    with pytest.raises(SasCancel, match="missing"):
        two.macs(macs)


def test_where_one_side_knows_no_emoji_numbers_are_shown() -> None:
    one, two = _exchange()
    [(_, start)] = one.start()
    start["short_authentication_string"] = ["decimal"]
    [(_, accept)] = two.started(start)
    [(_, key)] = one.accepted(accept)
    [(_, answer)] = two.key(key)
    one.key(answer)
    ours, theirs = one.shown(), two.shown()
    assert ours.decimals == theirs.decimals
    assert len(ours.decimals) == 3
    assert all(1000 <= number <= 9191 for number in ours.decimals)
    assert ours.text == " ".join(map(str, ours.decimals))


def test_a_code_is_not_shown_before_it_is_there() -> None:
    one, two = _exchange()
    for act in (one.shown, one.confirm, lambda: one.macs({"mac": {}}), lambda: one.key({})):
        with pytest.raises(SasCancel):
            act()
    [(_, start)] = one.start()
    two.started(start)
    for again in (lambda: two.started(start), lambda: one.started(start), two.shown):
        with pytest.raises(SasCancel):
            again()


def test_macs_of_one_device_are_not_those_of_the_other() -> None:
    one, two = _exchange()
    _up_to_shown(one, two)
    [(_, macs)] = one.confirm()
    with pytest.raises(SasCancel, match="not the one"):
        one.macs(macs)


def test_there_are_64_emoji_each_once() -> None:
    assert len(EMOJI) == 64
    assert len(set(EMOJI)) == 64
    assert EMOJI[0] == ("🐶", "Dog")
    assert EMOJI[63] == ("📌", "Pin")


def test_an_answer_to_a_start_that_was_taken_back_is_passed_over() -> None:
    one, two = _exchange()
    [(_, start)] = one.start()
    [(_, accept)] = two.started(start)
    one.yield_start()
    assert one.accepted(accept) == []
    assert _phase(one) is SasPhase.BEGUN
