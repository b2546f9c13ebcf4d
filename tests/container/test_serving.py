"""In which chats somebody known here was met: nothing but a look-up, for every post that comes."""

from __future__ import annotations

from rosic.container.container import CHATS_AT_MOST, ChatPeople, PersonContainer
from rosic.core.message import Chat, ChatKind
from tests.gateway.place import Place

LAB = Chat("memory", "lab", ChatKind.GROUP)


async def test_a_chat_is_served_while_somebody_is_known_to_be_in_it() -> None:
    async with Place().open() as place:
        container = place.gateway.rooms.container
        assert not container.serves(LAB)
        container.meet("p1", LAB)
        container.meet("p2", LAB)
        assert container.serves(LAB)
        assert container.serves(Chat("memory", "lab", ChatKind.GROUP, "a topic"))
        container.part("p1", LAB)
        assert container.serves(LAB)
        container.forget("p2")
        assert not container.serves(LAB)
        assert not container.company(LAB)


def test_the_chats_that_somebody_is_known_in_longest_are_forgotten_first() -> None:
    there = ChatPeople()
    person = PersonContainer("p1", there)
    for number in range(CHATS_AT_MOST + 1):
        person.select(number.to_bytes(8, "big"), "omni")
        person.select(number.to_bytes(8, "big"), "kuka1")
    chats = [number.to_bytes(8, "big") for number in range(CHATS_AT_MOST + 1)]
    assert [chat in there for chat in chats] == [False, *[True] * CHATS_AT_MOST]
    assert [there.of(chat) for chat in chats[:2]] == [frozenset(), {"p1"}]
    person.clear()
    assert not any(chat in there for chat in chats)
    assert not there.of(chats[1])
