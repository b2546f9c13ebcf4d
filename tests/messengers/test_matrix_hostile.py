"""What a stranger or a homeserver sends so that a stop is lost, or more than a stop counts."""

from __future__ import annotations

import asyncio
from collections import Counter
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import pytest
from nio.crypto import Olm
from nio.exceptions import EncryptionError

from rosic.core.identity import Address
from rosic.core.message import Chat, Inbound, MessageValidity
from rosic.core.policy.roles import Assurance
from rosic.messengers.matrix.olm_machine import OlmMachine
from rosic.messengers.matrix.reading import ReadEvent
from rosic.messengers.matrix.rooms import entered_at
from rosic.messengers.matrix.sync_window import SyncWindow

if TYPE_CHECKING:
    from collections.abc import Callable

OWN = "@robots:example.org"


async def handed_over(text: str) -> Inbound:
    """Return how an urgent message is handed over."""
    heard: list[Inbound] = []

    async def receive(inbound: Inbound) -> None:
        heard.append(inbound)

    async def weigh(_one: ReadEvent) -> Inbound:
        raise AssertionError("a stop waits for no look at keys")

    inbound = Inbound(
        sender=Address("matrix", "@ada:example.org"),
        chat=Chat("matrix", "!room:example.org"),
        message="$one",
        text=text,
        sent_ns=1,
        received_ns=1,
    )
    one = ReadEvent(inbound, urgent=True, known=True, reaction=False, evidence=None)
    async with asyncio.TaskGroup() as group:
        window = SyncWindow(group, receive, weigh, Counter())
        batch = window.begin("token")
        window.admit(one, batch)
        window.close(batch)
    (found,) = heard
    return found


@pytest.mark.parametrize("text", ["stop kuka1\nomni move 1 m", "stop\r\nomni move 1 m"])
async def test_beside_a_stop_that_nobody_looked_at_nothing_counts(text: str) -> None:
    found = await handed_over(text)
    assert (found.text, found.standing) == (text, MessageValidity.ANONYMOUS)


async def test_what_turns_out_to_be_no_stop_may_only_look() -> None:
    found = await handed_over("stop")
    assert found.standing is MessageValidity.UNVERIFIED
    assert found.assurance is Assurance.PROVIDER_READABLE


def raising(error: Exception) -> Callable[..., Any]:
    def act(*_event: Any, **_more: Any) -> Any:  # noqa: ANN401
        raise error

    return act


def test_what_cannot_be_read_is_passed_over_whatever_it_raises(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    odd = UnicodeDecodeError("utf-8", b"x", 0, 1, "not UTF-8")
    monkeypatch.setattr(Olm, "handle_to_device_event", raising(ValueError("no Olm message")))
    monkeypatch.setattr(Olm, "decrypt_megolm_event", raising(odd))
    machine = object.__new__(OlmMachine)
    assert machine.handle_to_device_event(object()) is None
    with pytest.raises(EncryptionError, match="no event: UnicodeDecodeError"):
        machine.decrypt_megolm_event(object(), "!room:example.org")


def test_an_event_of_the_room_inside_a_ciphertext_is_none() -> None:
    source = {"type": "m.room.member", "state_key": OWN, "content": {"membership": "invite"}}
    assert entered_at([SimpleNamespace(source=source, decrypted=False)], OWN) == 1
    assert entered_at([SimpleNamespace(source=source, decrypted=True)], OWN) == 0
