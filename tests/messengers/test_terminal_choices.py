"""What a terminal is set to, and the numbers of buttons that are over."""

from __future__ import annotations

import pytest

from rosic.core.message import Button, Chat, Outbound
from rosic.messengers.terminal import TerminalMessenger
from rosic.messengers.terminal.messenger import OVER, Choices, own_locale
from rosic.testing.clock import ManualClock
from tests.messengers.test_terminal import Script, heard, terminal


async def test_what_is_typed_says_what_the_terminal_is_set_to() -> None:
    script = Script("status")
    messenger = TerminalMessenger(clock=ManualClock(), screen=script, locale="de_DE")

    assert [inbound.locale for inbound in await heard(messenger)] == ["de_DE"]


@pytest.mark.parametrize(
    ("settings", "locale"),
    [
        ({"LANG": "de_DE.UTF-8"}, "de_DE"),
        ({"LANG": "de_DE.UTF-8", "LC_MESSAGES": "en_GB"}, "en_GB"),
        ({"LANG": "de_DE", "LC_MESSAGES": "de_DE", "LC_ALL": "C"}, "C"),
        ({"LC_ALL": "", "LANG": "de_AT@euro"}, "de_AT"),
        ({}, ""),
    ],
)
def test_the_terminal_of_a_person_has_a_language_and_a_pipe_has_none(
    monkeypatch: pytest.MonkeyPatch, settings: dict[str, str], locale: str
) -> None:
    for name in ("LC_ALL", "LC_MESSAGES", "LANG"):
        monkeypatch.delenv(name, raising=False)
    for name, value in settings.items():
        monkeypatch.setenv(name, value)
    assert own_locale(at_hand=True) == locale
    assert own_locale(at_hand=False) == ""


async def test_a_number_whose_button_is_gone_is_a_tap_too_late() -> None:
    messenger, _ = terminal("1", "1", "2")
    button = Button("Do it", "do", nonce="n1")
    chat = Chat("terminal", "1000")
    asked = Outbound(chat=chat, text="?", buttons=((button,),))
    await messenger.send(asked)

    first, again, other = await heard(messenger)

    assert (first.nonce, first.text) == ("n1", "")
    assert (again.nonce, again.text) == (OVER, "")
    assert again.tap, "it is answered as a tap: this button is no longer good"
    assert (other.nonce, other.text) == (None, "2"), "it never stood there"


def test_numbers_that_once_stood_before_a_button_are_known() -> None:
    clock = ManualClock()
    choices = Choices()
    assert not choices.over("1"), "nothing was shown yet"
    outbound = Outbound(
        chat=Chat("terminal", "1000"), text="?", buttons=((Button("Do it", "do"),),)
    )
    choices.show("m1", outbound, clock.monotonic_ns())
    assert not choices.over("1")
    assert choices.take("1") is not None
    assert choices.over("1")
    assert choices.over(" 1 ")
    assert not choices.over("2"), "it never stood there"
    assert not choices.over("one")
    assert not choices.over("100")
