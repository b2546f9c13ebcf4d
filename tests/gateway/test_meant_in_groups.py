"""What people say to each other in a group moves no robot at once: it becomes a question."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from rosic.core.message import Chat, ChatKind, MessageValidity
from rosic.core.robot.profile import Profile
from rosic.gateway.reply_context import CONVERSATIONS_KEPT, GOES_ON_NS, GroupConversations
from rosic.robots.ros2.profile import Ros2Link
from rosic.testing.clock import ManualClock
from tests.gateway.place import ADA, BO, FLEET, VI, Place

if TYPE_CHECKING:
    from rosic.core.message import Inbound

GOES_ON_S = GOES_ON_NS / 1e9
ASKED = "People talk here, so it moves only if you confirm it."
WAVES = "omni: wave? People talk here, so it moves only if you confirm it."
CHATTER = "I think the other one is nicer"


def written(
    place: Place, text: str, *, account: str = ADA, topic: str = "", chat: str = "-5", **how: object
) -> Inbound:
    """Return something that somebody writes in a group; to others, unless it says otherwise."""
    where = Chat("memory", chat, ChatKind.GROUP, topic)
    return replace(place.chat._inbound(account, where, None, None), text=text, **how)


async def heard(place: Place, text: str, **how: object) -> str:
    """Have somebody write it; return what was told because of it."""
    await place.clock.advance(0.001)
    return await brought(place, written(place, text, **how))  # type: ignore[arg-type]


async def brought(place: Place, inbound: Inbound) -> str:
    """Have the platform bring it; return what was told because of it."""
    before = len(place.chat.told)
    place.chat.deliver(inbound)
    await place.quiet()
    return "\n".join(told.outbound.text for told in list(place.chat.told)[before:])


def acts(place: Place) -> dict[str, int]:
    """Return how often each robot acted, without those that did not."""
    return {robot: times for robot in place.gateway.robots if (times := place.acted(robot))}


async def choose(place: Place, name: str, **how: object) -> None:
    """Choose a robot or a group, so long ago that nobody is talking to it any more."""
    assert name in await heard(place, f"use {name}", **how)
    await place.clock.advance(GOES_ON_S)


# ---- what is asked ----


async def test_an_order_that_names_nobody_is_asked_about_and_a_tap_does_it() -> None:
    async with Place().open() as place:
        await choose(place, "omni")
        assert await heard(place, "move 1 m") == f"omni: move, 1.00 m forward? {ASKED}"
        labels = [button.label for row in place.last()[1].buttons for button in row]
        assert (acts(place), labels) == ({}, ["Do it", "Leave it"])
        assert "done" in await place.tap(*place.button("Do it"))
        assert acts(place) == {"omni": 1}


async def test_left_it_is_left() -> None:
    async with Place().open() as place:
        await choose(place, "omni")
        await heard(place, "wave")
        do_it = place.button("Do it")
        assert await place.tap(*place.button("Leave it")) == "Nothing was done."
        await place.tap(*do_it, account=BO)
        assert acts(place) == {}


async def test_it_is_asked_of_whoever_wrote_it_alone() -> None:
    async with Place().open() as place:
        await choose(place, "omni")
        await heard(place, "wave")
        assert await place.tap(*place.button("Do it"), account=BO) == ""
        assert acts(place) == {}


async def test_the_only_robot_that_can_do_it_was_not_named_by_it() -> None:
    async with Place(fleet=FLEET[:1]).open() as place:
        assert await heard(place, "wave") == WAVES
        assert acts(place) == {}
        await place.say("wave")
        assert acts(place) == {"omni": 1}, "in private it is the one"


@pytest.mark.parametrize("text", ["omni wave", "wave", "/wave"])
@pytest.mark.parametrize(
    "where",
    [
        f"{CHATTER}\n%s",
        f"%s\n{CHATTER}",
        f"%s\n{CHATTER}\n%s",
        "%s\nkuka1 move was nicer when Bo drove",
    ],
)
async def test_what_stands_among_lines_that_are_no_commands_is_asked_about(
    text: str, where: str
) -> None:
    async with Place().open() as place:
        await heard(place, "use omni")
        said = where.replace("%s", text)
        told = await heard(place, said)
        assert (told.count(WAVES), acts(place)) == (said.count(text), {})
        await heard(place, said, addressed=True)
        assert set(acts(place)) == {"omni"}


async def test_in_reply_to_what_a_person_wrote_it_is_asked_even_in_a_conversation() -> None:
    async with Place().open() as place:
        await heard(place, "use omni")
        assert await heard(place, "wave", answers="of-bo") == WAVES
        assert acts(place) == {}
        await heard(place, "omni wave", answers="of-bo")
        assert acts(place) == {"omni": 1}, "named, it is meant"


async def test_so_it_is_where_the_platform_does_not_tell_whose_words_it_answers() -> None:
    async with Place(fleet=FLEET[:1]).open() as place:
        await heard(place, "use omni")
        assert await heard(place, "wave", answers_us=True) == WAVES
        assert acts(place) == {}


async def test_what_cannot_be_done_is_refused_with_what_can() -> None:
    async with Place().open() as place:
        await choose(place, "omni")
        told = await heard(place, f"move 40 m\n{CHATTER}\nwave")
        assert "at most 5" in told
        assert WAVES in told, "the other lines are still followed"
        assert acts(place) == {}
        await place.tap(*place.button("omni move 5 m"))
        assert acts(place) == {"omni": 1}


async def test_who_may_not_move_it_does_not_by_a_tap_either() -> None:
    async with Place().open() as place:
        await choose(place, "omni", account=VI)
        await heard(place, "wave", account=VI)
        assert "needs the right" in await place.tap(*place.button("Do it"), account=VI)
        assert acts(place) == {}


async def test_what_comes_twice_is_asked_once_and_not_done_later() -> None:
    async with Place().open() as place:
        await choose(place, "omni")
        inbound = written(place, "wave")
        assert await brought(place, inbound) == WAVES
        assert await brought(place, inbound) == ""
        await heard(place, "use omni")
        assert await brought(place, inbound) == ""
        assert acts(place) == {}
        lately = written(place, "move 1 m")
        await brought(place, lately)
        assert acts(place) == {"omni": 1}
        assert await brought(place, lately) == ""
        assert acts(place) == {"omni": 1}


async def test_what_is_addressed_to_another_bot_of_ours_is_not_asked_about_as_well() -> None:
    """Each of several bots hears the message, by one id; it is addressed to one of them."""
    async with Place().open() as place:
        await choose(place, "omni")
        ours = written(place, "wave", answers="of-bo", addressed=True)
        await brought(place, ours)
        assert acts(place) == {"omni": 1}
        assert await brought(place, replace(ours, addressed=False)) == ""
        assert acts(place) == {"omni": 1}


# ---- what is done at once ----


@pytest.mark.parametrize(
    ("text", "robots"),
    [
        ("omni wave", {"omni"}),
        ("wave omni", {"omni"}),
        ("please omni, move 1 m", {"omni"}),
        ("swarm wave", {"cf1", "cf2"}),
        ("omni wave\nkuka1 wave", {"omni", "kuka1"}),
        ("/wave", {"kuka1"}),
    ],
)
async def test_what_names_its_robot_or_is_a_command_is_done_at_once(
    text: str, robots: set[str]
) -> None:
    async with Place().open() as place:
        await choose(place, "kuka1")
        assert ASKED not in await heard(place, text)
        assert set(acts(place)) == robots


async def test_what_is_addressed_to_us_is_done_at_once() -> None:
    async with Place().open() as place:
        await choose(place, "omni")
        await heard(place, "wave", addressed=True)
        assert acts(place) == {"omni": 1}


async def test_a_tap_is_meant_whatever_its_button_says() -> None:
    async with Place().open() as place:
        await choose(place, "omni")
        text = f"omni wave\n{CHATTER}"
        await heard(place, text, standing=MessageValidity.EDITED)
        assert acts(place) == {}
        await place.tap(*place.button(text))
        assert acts(place) == {"omni": 1}


async def test_what_only_looks_is_never_asked_about() -> None:
    async with Place().open() as place:
        await choose(place, "omni")
        assert ASKED not in await heard(place, f"look\n{CHATTER}")
        assert acts(place) == {"omni": 1}


@pytest.mark.parametrize("text", ["stop", "stop omni", f"{CHATTER}\nstop", "wave\nstop"])
@pytest.mark.parametrize("answers", ["", "of-bo"])
async def test_a_stop_is_never_asked_about(text: str, answers: str) -> None:
    async with Place().open() as place:
        await choose(place, "omni")
        await heard(place, text, answers=answers)
        assert place.gateway.robots["omni"].gate.latched
        assert acts(place) == {}


async def test_in_private_nothing_of_it_is_asked() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.clock.advance(2 * GOES_ON_S)
        await place.say(f"{CHATTER}\nwave\n{CHATTER}")
        await place.say("wave", answers="of-bo")
        assert acts(place) == {"omni": 2}


async def test_a_topic_of_a_robot_means_it() -> None:
    async with Place().open() as place:
        await place.say("/topic omni", topic="7", chat="-5", kind=ChatKind.GROUP)
        await heard(place, "wave", topic="7", account=BO)
        assert acts(place) == {"omni": 1}
        assert await heard(place, "wave", topic="7", account=BO, answers="of-ada") == WAVES
        await choose(place, "kuka1", topic="7")
        assert ASKED in await heard(place, "wave", topic="7"), "the topic is not of that one"
        assert acts(place) == {"omni": 1}


# ---- a conversation ----


async def tapped(place: Place) -> None:
    await heard(place, "move 1 m")
    await place.tap(*place.button("Do it"))


OPENINGS = {
    "chosen": ("use omni", {}),
    "named": ("omni wave", {}),
    "addressed": ("wave", {"addressed": True}),
}


@pytest.mark.parametrize("how", [*OPENINGS, "tapped"])
async def test_whoever_has_just_spoken_to_a_robot_goes_on_without_its_name(how: str) -> None:
    async with Place().open() as place:
        await choose(place, "omni")
        if how == "tapped":
            await tapped(place)
        else:
            text, more = OPENINGS[how]
            await heard(place, text, **more)
        before = place.acted()
        await place.clock.advance(GOES_ON_S - 1.0)
        await heard(place, "wave")
        assert place.acted() == before + 1
        await place.clock.advance(1.0)
        assert await heard(place, "wave") == WAVES, "what names nobody makes it no longer"
        assert place.acted() == before + 1


async def test_the_wall_clock_makes_no_conversation_longer() -> None:
    async with Place().open() as place:
        await heard(place, "use omni")
        place.clock.suspend(GOES_ON_S)
        place.clock.jump_wall(-1.0)
        await heard(place, "wave")
        assert acts(place) == {}


@pytest.mark.parametrize(
    "other", [{"account": BO}, {"topic": "8"}, {"chat": "-6"}], ids=["person", "topic", "group"]
)
async def test_it_is_one_persons_in_one_place(other: dict[str, str]) -> None:
    async with Place().open() as place:
        await choose(place, "omni", **other)
        await heard(place, "use omni")
        assert await heard(place, "wave", **other) == WAVES
        assert acts(place) == {}


async def test_it_is_with_one_robot() -> None:
    async with Place().open() as place:
        await choose(place, "omni")
        await heard(place, "kuka1 wave")
        assert await heard(place, "wave") == WAVES
        assert acts(place) == {"kuka1": 1}


@pytest.mark.parametrize(
    ("text", "how"),
    [
        (f"{CHATTER}\nuse omni", {}),
        ("use omni", {"answers": "of-bo"}),
        (f"{CHATTER}\nomni wave", {}),
        ("omni look at that\nomni wave", {"account": VI}),
        ("status omni", {}),
    ],
)
async def test_what_may_be_said_to_others_begins_none(text: str, how: dict[str, str]) -> None:
    async with Place().open() as place:
        account = how.get("account", ADA)
        await choose(place, "omni", account=account)
        await heard(place, text, **how)
        assert await heard(place, "wave", account=account) == WAVES
        assert acts(place) == {}


# ---- a robot that one talks to ----

TALKER = Profile(id="talker", link=Ros2Link(kind="memory", dialogue=True))


async def test_words_to_each_other_are_not_said_to_a_robot_that_was_chosen_once() -> None:
    async with Place(fleet=(*FLEET, TALKER)).open() as place:
        await choose(place, "talker")
        assert ASKED in await heard(place, "what a day")
        assert acts(place) == {}
        await heard(place, "talker what a day")
        await heard(place, "and it goes on")
        assert acts(place) == {"talker": 2}


async def test_words_to_it_make_no_command_of_what_stands_beside_them() -> None:
    async with Place(fleet=(*FLEET, TALKER)).open() as place:
        await heard(place, "use talker")
        assert WAVES in await heard(place, f"{CHATTER}\nomni wave")
        assert acts(place) == {}
        await heard(place, "talker hello\nomni wave")
        assert acts(place) == {"talker": 1, "omni": 1}


# ---- what is kept ----


def test_as_many_are_kept_as_fit_the_newest() -> None:
    clock = ManualClock()
    conversations = GroupConversations(clock)
    chat = Chat("memory", "-5", ChatKind.GROUP)
    conversations.note("first", chat, "omni")
    for number in range(CONVERSATIONS_KEPT - 1):
        conversations.note(f"p{number}", chat, "omni")
    assert conversations.goes_on("first", chat, "omni")
    conversations.note("first", chat, "omni")
    conversations.note("last", chat, "omni")
    assert [conversations.goes_on(who, chat, "omni") for who in ("first", "p0", "p1", "last")] == [
        True,
        False,
        True,
        True,
    ]


# ---- whatever a group says ----

NAMED = {
    "omni wave": ("omni",),
    "wave kuka1": ("kuka1",),
    "please kuka1 move 1 m": ("kuka1",),
    "swarm wave": ("swarm",),
    "/cf1 wave": ("cf1",),
}
CHOICES = {f"use {name}": (name,) for name in ("omni", "kuka1", "swarm")}
BARE = ("wave", "move 1 m", "please wave", "move back")
SAID_TO_OTHERS = (
    CHATTER,
    "omni will do it",
    "omni move was what I said",
    "kuka1 was faster yesterday",
    "wave to us when you are there",
    "we move at 10",
    "move on, please",
    "use your head",
    "nobody waves here",
    "ok",
)
LINES = (*NAMED, *CHOICES, *BARE, *BARE, "/wave", *SAID_TO_OTHERS)
TEXTS = st.one_of(
    st.sampled_from((*CHOICES, *BARE)),
    st.lists(st.sampled_from(LINES), min_size=1, max_size=3).map("\n".join),
)
MEMBERS = {"swarm": {"cf1", "cf2"}}


class Message(msgspec.Struct, frozen=True):
    """What somebody writes, and what a group knows of it."""

    text: str
    account: str
    answers: str
    addressed: bool
    after_s: float


MESSAGES = st.builds(
    Message,
    TEXTS,
    st.sampled_from((ADA, ADA, BO)),
    st.sampled_from(("", "", "of-vi")),
    st.sampled_from((False, False, False, True)),
    st.sampled_from((1.0, 100.0, GOES_ON_S)),
)


@settings(max_examples=150, deadline=None)
@given(messages=st.lists(MESSAGES, min_size=1, max_size=8))
@pytest.mark.limit(600)
def test_nothing_moves_by_what_may_be_said_to_others(messages: list[Message]) -> None:
    asyncio.run(_talk(messages))


class Talk:
    """Judges what moves without the grammar: by which lines are known by heart."""

    def __init__(self) -> None:
        self._spoken: dict[tuple[str, str], float] = {}
        self._now_s = 0.0

    async def goes_on(self, place: Place, message: Message) -> None:
        """Have somebody write, and judge what moves because of it."""
        before = acts(place)
        how = {"account": message.account, "answers": message.answers}
        told = await heard(place, message.text, addressed=message.addressed, **how)
        moved = {r for r, times in acts(place).items() if times > before.get(r, 0)}
        if message.addressed:
            assert ASKED not in told, f"it was said to us: {message.text!r}"
            lines = message.text.split("\n")
            chosen = {name for line in lines for name in CHOICES.get(line, ())}
            swarm = {"swarm"} if moved & MEMBERS["swarm"] else set()
            self._note(message, moved | swarm | chosen)
        else:
            self._judge(message, moved, told)
        await place.clock.advance(message.after_s)
        self._now_s += message.after_s

    def _judge(self, message: Message, moved: set[str], told: str) -> None:
        lines = message.text.split("\n")
        if len(lines) > 1 and any(line in SAID_TO_OTHERS for line in lines):
            assert not moved, f"among words to others: {message.text!r}"
            return
        named = {name for line in lines for name in NAMED.get(line, ())}
        if len(lines) == 1 and named:
            assert ASKED not in told, f"it was named: {message.text!r}"
        chosen = {name for line in lines for name in CHOICES.get(line, ())}
        talks_to = set() if message.answers else chosen | self._talks_to(message.account)
        if "/wave" not in lines:
            assert moved <= _robots(named | talks_to), f"nobody said so to it: {message.text!r}"
        self._note(message, named | (set() if message.answers else chosen))

    def _talks_to(self, account: str) -> set[str]:
        lately = {key for key, at_s in self._spoken.items() if self._now_s - at_s < GOES_ON_S}
        return {name for who, name in lately if who == account}

    def _note(self, message: Message, names: set[str]) -> None:
        self._spoken |= {(message.account, name): self._now_s for name in names}


async def _talk(messages: list[Message]) -> None:
    talk = Talk()
    async with Place().open() as place:
        for message in messages:
            await talk.goes_on(place, message)


def _robots(names: set[str]) -> set[str]:
    return {robot for name in names for robot in MEMBERS.get(name, {name})}
