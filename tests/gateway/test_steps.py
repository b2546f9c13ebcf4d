"""I15: nothing that anybody sends costs the event loop more than 20 ms of processor in one step."""

from __future__ import annotations

import asyncio
import os
from random import Random
from typing import Any

import pytest

from rosic.authoriser.invite_codes import ALPHABET
from rosic.bench.strangers import NAMED
from rosic.core.language import Cancel, Halt, LanguageReader
from tests.gateway.loop_steps import herd, none_is_long, run, too_long
from tests.gateway.received import (
    ADA,
    BO,
    LIGATURE,
    LONGEST,
    MARKS,
    STRANGER,
    Receiving,
    filled,
    mixed,
    texts,
)

EVERY = 23
"""Of the grid the suite takes each so manieth; a campaign takes all of it."""
SEED = int(os.environ.get("ROSIC_SEED", "12"))
ROUNDS = int(os.environ.get("ROSIC_STEPS_ROUNDS", "3000"))
GROUP, CHANNEL = -100_500, -100_777


def test_no_text_of_somebody_known_makes_a_step_long() -> None:
    async def act(place: Receiving) -> None:
        await none_is_long(place, ADA, [*texts()][SEED % EVERY :: EVERY])

    run(act)


TO_MANY = [
    "/task herd " + " then ".join(["skill1x1"] * 64),
    "/task herd " + " then ".join(f"skill1x1 {n}" for n in range(33)),
    "/task herd " + " then ".join(f"move 1.{n:02} m" for n in range(33)),
    "/task herd " + " then ".join(f"move 1.{n:02} m" for n in range(60)),
    "/task any " + " then ".join(["move 9 m"] * 64),
    "/task herd " + " then ".join(["move"] * 64),
    "/task herd " + " then ".join([*["move 1 m"] * 62, "mvoe 1 m"]),
    "/task herd " + " then ".join([*[f"move 1.{n:02} m" for n in range(32)], "mvoe 1 m"]),
    "/task herd " + " then ".join([*[f"move 1.{n:02} m" for n in range(16)], "move 1"]),
    "/task herd " + " then ".join([*[f"move 1.{n:02} m" for n in range(32)], "move 9 m"]),
    "\n".join(["/task herd skill1x1 then skilx 1"] * 5),
    "/broadcast herd skill1x1",
    "/broadcast herd mvoe 1 m",
    "/together herd skill1x1",
    "/together herd move 9 m",
    "herd skill1x1",
    "status herd",
    "status " + " ".join(f"rob{n}" for n in range(31)),
    "resume herd",
    "robots",
    "/fleet herd",
    "/wish herd skill1x1 tomorrow 14:00 for 1h",
    "/wish any of herd 1h mon-fri 8-18 priority 3",
    "/plan",
    "/handover herd Bo",
    "/quiet herd",
]


@pytest.mark.parametrize("text", TO_MANY, ids=range(len(TO_MANY)))
def test_no_line_that_is_about_many_robots_makes_a_step_long(text: str) -> None:
    """What is typed is multiplied by sixty robots with ten skills each."""

    async def act(place: Receiving) -> None:
        await none_is_long(place, ADA, [text])

    run(act, herd(60))


def test_no_task_that_is_asked_about_makes_a_step_long() -> None:
    """Both readings of it are offered, each bound to what it lets sixty robots do."""

    async def act(place: Receiving) -> None:
        await place.longest(place.message(ADA, "/settings units imperial"))
        await none_is_long(
            place,
            ADA,
            [
                "/task herd " + " then ".join(f"move 1.{n:02}" for n in range(many))
                for many in (3, 9, 33)
            ],
        )

    run(act, herd(60))


KNOWN = [
    "/wish a" + " " * (LONGEST - 8) + "b",
    filled("/wish ", ", "),
    filled("/grant ", "a b "),
    filled("/grant ", LIGATURE + " "),
    filled("/robot add ", " ", "b"),
    filled("", LIGATURE),
    filled("", LIGATURE + "\n"),
    filled("", "\u3316\n"),
    "\n".join(f"@{n}bot stop" for n in range(300)),
    NAMED[:LONGEST],
    *MARKS,
    *(f"/grant {text}"[:LONGEST] for text in MARKS),
    "\n".join(["/authenticator", "/slots", "/status", "help"] * 5),
]


@pytest.mark.parametrize("text", KNOWN, ids=range(len(KNOWN)))
def test_what_once_made_a_step_long_does_so_no_more(text: str) -> None:
    async def act(place: Receiving) -> None:
        for who in (ADA, BO, STRANGER):
            await none_is_long(place, who, [text])

    run(act)


def test_no_batch_makes_a_step_long() -> None:
    """A hundred at once, of strangers, in one chat and in many, and what they are besides texts."""

    async def act(place: Receiving) -> None:
        for updates in (
            lambda: [place.message(STRANGER, filled("", LIGATURE + "\n")) for _ in range(100)],
            lambda: [place.message(STRANGER + n, filled("", "\u3316 ")) for n in range(100)],
            lambda: [place.message(STRANGER + n, filled("/start ", "AB-CD ")) for n in range(100)],
            lambda: [place.message(ADA, "omni move 1 m") for _ in range(100)],
            lambda: [place.message(BO, "\u3316 " * 490) for _ in range(100)],
            lambda: [place.message(BO, filled("", "not stop\n")) for _ in range(100)],
            lambda: [place.message(BO, filled("@abot ", "@abot stop\n")) for _ in range(100)],
            lambda: [place.message(STRANGER, NAMED[:LONGEST]) for _ in range(100)],
            lambda: [place.edited(STRANGER + n, NAMED[:LONGEST]) for n in range(100)],
            lambda: [place.edited(BO, NAMED[:LONGEST]) for _ in range(100)],
            lambda: [place.post(CHANNEL - n, NAMED[:LONGEST]) for n in range(100)],
        ):
            step = await too_long(place, updates)
            assert step is None, step

    run(act)


def test_a_stop_is_found_before_anything_that_came_with_it_is_followed() -> None:
    """However much strangers sent before it, and before people known here are answered."""

    async def act(place: Receiving) -> None:
        pipeline, heard = place.gateway.pipeline, []
        follow = pipeline._carry

        async def take(messenger: Any, inbound: Any, arrived_ns: int) -> None:  # noqa: ANN401
            heard.append(place.gateway.rooms.stops["omni"].latched)
            await follow(messenger, inbound, arrived_ns)

        pipeline._carry = take  # type: ignore[method-assign]
        strangers = [
            place.message(STRANGER + n, filled("", LIGATURE + "\n", "\nstop")) for n in range(89)
        ]
        people = [place.message(BO, "omni look") for _ in range(10)]
        await place.longest(*strangers, *people, place.message(ADA, "stop"))
        assert heard == [True] * 99

    run(act)


def test_what_strangers_sent_is_read_last() -> None:
    """A stop is obeyed before the first of them is looked into."""

    async def act(place: Receiving) -> None:
        read: list[str] = []
        reading = place.listener.reading
        news = reading.news

        def noted(number: int, update: Any, received: Any, **of: bool) -> Any:  # noqa: ANN401
            read.append(update.message.text)
            return news(number, update, received, **of)

        reading.news = noted  # type: ignore[method-assign]
        strangers = [place.message(STRANGER, f"stop {n}") for n in range(5)]
        await place.longest(*strangers, place.message(BO, "help"), place.message(ADA, "stop"))
        assert read == ["help", "stop", *(f"stop {n}" for n in range(5))]

    run(act)


def test_what_takes_longest_to_read_is_not_waited_for() -> None:
    """A stop is obeyed that came while posts in strangers' channels, which may stop, are read."""

    async def act(place: Receiving) -> None:
        stops, reading, left = place.gateway.rooms.stops, place.listener.reading, []
        place.give(*(place.post(CHANNEL - n, NAMED[:LONGEST]) for n in range(90)))
        while not reading.behind:  # noqa: ASYNC110 - nobody is told when the first are read
            await asyncio.sleep(0)
        place.give(place.message(ADA, "stop"))
        while not stops["omni"].latched:  # noqa: ASYNC110 - nor when a robot is stopped
            await asyncio.sleep(0)
        left.append(len(reading._unread))
        await place.drained()
        assert left[0] > 30
        assert not reading.behind

    run(act)


@pytest.mark.parametrize("answers", [1, 20])
def test_a_stop_behind_a_mix_is_found_as_soon_as_it_is_handed_over(answers: int) -> None:
    """Of each answer the first is a stranger's message and the rest are posts in their channels."""

    async def act(place: Receiving) -> None:
        stops, reading, read = place.gateway.rooms.stops, place.listener.reading, []
        news = reading.news

        def noted(number: int, update: Any, received: Any, **of: bool) -> Any:  # noqa: ANN401
            read.append(number)
            return news(number, update, received, **of)

        reading.news = noted  # type: ignore[method-assign]
        for answer in range(answers):
            place.give(
                place.message(STRANGER, NAMED[:LONGEST]),
                *(place.post(CHANNEL - answer * 99 - n, NAMED[:LONGEST]) for n in range(99)),
            )
        stop = place.message(ADA, "stop")
        place.give(stop)
        while not stops["omni"].latched:  # noqa: ASYNC110 - nobody is told
            await asyncio.sleep(0)
        before = read[: read.index(stop["update_id"])]
        # What was read while the first of it came: of each post a stop is looked for, for 6 ms.
        assert len(before) <= 2, len(before)

    run(act)


def test_a_stop_in_a_channel_where_nobody_was_met_is_looked_for_all_the_same() -> None:
    """After everything else: one of its admins may have access here."""

    async def act(place: Receiving) -> None:
        company, asked = place.gateway.stop_lane._company, []
        ask = company.ask

        async def noted(messenger: Any, inbound: Any) -> Any:  # noqa: ANN401
            asked.append(inbound.text)
            return await ask(messenger, inbound)

        company.ask = noted  # type: ignore[method-assign]
        await place.longest(place.post(CHANNEL, "stop"), place.message(BO, "help"))
        assert asked == ["stop"]

    run(act)


def test_a_stop_of_nobody_is_found_before_anything_that_came_with_it_is_followed() -> None:
    """An anonymous admin's, read after people known here and before any of them is followed."""

    async def act(place: Receiving) -> None:
        pipeline, heard = place.gateway.pipeline, []
        follow = pipeline._carry
        group = {"id": GROUP, "type": "supergroup", "title": "Lab"}
        await place.longest(place.message(ADA, "status", chat=group))

        async def take(messenger: Any, inbound: Any, arrived_ns: int) -> None:  # noqa: ANN401
            heard.append(place.gateway.rooms.stops["omni"].latched)
            await follow(messenger, inbound, arrived_ns)

        pipeline._carry = take  # type: ignore[method-assign]
        unnamed = place.message(1087968824, "stop", chat=group, sender_chat=group)
        posts = [place.post(CHANNEL - n, NAMED[:LONGEST]) for n in range(20)]
        await place.longest(*(place.message(BO, "help") for _ in range(5)), *posts, unnamed)
        assert heard == [True] * 5

    run(act)


def test_of_strangers_words_no_stop_is_looked_for() -> None:
    async def act(place: Receiving) -> None:
        asked: list[str] = []

        class Counted(LanguageReader):
            def urgent(self, text: str) -> Halt | Cancel | None:
                asked.append(text)
                return super().urgent(text)

        place.gateway.pipeline._reader = Counted(place.gateway.rooms.vocabularies)
        await place.longest(place.message(STRANGER, "stop"), place.message(BO, "help"))
        assert asked == ["help"]
        assert not place.gateway.rooms.stops["omni"].latched
        passed_over = place.listener.counts["passed-over"]
        await place.longest(place.message(STRANGER, "@other_bot stop\n/stop@other_bot"))
        assert place.listener.counts["passed-over"] == passed_over + 1

    run(act)


def odd(place: Receiving, long: str = LIGATURE * 20_000) -> list[dict[str, Any]]:
    """Return updates whose other parts are as long and as deep as they can be, and longer."""
    deep = json_deep(400)
    person = {"id": BO, "is_bot": False, "first_name": long, "language_code": long}
    chat = {"id": BO, "type": "private", "title": long, "first_name": long}
    group = {"id": GROUP, "type": "supergroup", "title": long}
    document = {"file_id": "x" * 20_000, "file_name": long + "/../" * 5_000, "file_size": 5}
    member = {"user": person, "status": "member"}
    left = {"user": person, "status": "left"}
    return [
        place.message(BO, "status", **{"from": person, "chat": chat}),
        place.message(BO, "", caption=f"{long[: LONGEST - 1]}\n", document=document),
        place.message(BO, "status", entities=[{"type": "bold", "offset": n} for n in range(5_000)]),
        place.message(BO, "status", photo=deep, location=deep, via_bot=None, left_chat_member=deep),
        place.message(BO, "x", reply_to_message={"message_id": 1, "chat": chat, "from": deep}),
        place.message(BO, filled("", "@a"), chat=group),
        place.message(1087968824, filled("", "\U0001f6d1 x\n"), chat=group, sender_chat=group),
        place.update(
            callback_query={
                "id": "1",
                "from": person,
                "data": long,
                "message": {"message_id": 1, "chat": chat},
            }
        ),
        place.update(
            my_chat_member={
                "chat": group,
                "from": person,
                "old_chat_member": left,
                "new_chat_member": member,
            }
        ),
        place.update(
            message_reaction={
                "chat": group,
                "message_id": 1,
                "user": person,
                "new_reaction": [{"emoji": str(n)} for n in range(5_000)],
            }
        ),
        place.update(message=deep),
        place.update(
            channel_post={"message_id": 1, "date": 0, "chat": group, "text": filled("", "\u505c\n")}
        ),
    ]


def json_deep(levels: int) -> object:
    """Return lists in lists."""
    found: object = []
    for _ in range(levels):
        found = [found]
    return found


def test_no_other_part_of_an_update_makes_a_step_long() -> None:
    async def act(place: Receiving) -> None:
        for number in range(len(odd(place))):
            for text in (LIGATURE, *MARKS):
                long = text * (20_000 // len(text))
                step = await too_long(place, lambda n=number, long=long: [odd(place, long)[n]])  # type: ignore[misc]
                assert step is None, (number, text[:3], step)

    run(act)


def test_no_search_for_a_code_that_a_group_is_shown_makes_a_step_long() -> None:
    """With the most to look up: no eight symbols twice, in the text and behind its words."""

    async def act(place: Receiving) -> None:
        chat = {"id": GROUP, "type": "supergroup", "title": "Lab"}
        await place.longest(place.message(ADA, "/invite viewer for 2h"))
        await place.longest(place.message(ADA, "/archive on", chat=chat))
        assert place.gateway.access.enrolment.invitations.open()
        chance = Random(SEED)  # noqa: S311 - a seed makes it repeatable

        def updates() -> list[dict[str, Any]]:
            text, link = ("".join(chance.choices(ALPHABET, k=LONGEST)) for _ in range(2))
            more: dict[str, Any] = {"chat": chat, "entities": [{"type": "text_link", "url": link}]}
            return [
                place.message(BO, text, **more),
                place.message(BO, f"omni help\n{text[10:]}", **more, edit_date=0),
                place.message(STRANGER, f"stop it {text[10:]}", **more),
                place.post(CHANNEL, text),
            ]

        for number in range(4):
            step = await too_long(place, lambda number=number: updates()[number : number + 1])  # type: ignore[misc]
            assert step is None, (number, step)

    run(act)


def test_texts_made_at_random_make_no_step_long() -> None:
    async def act(place: Receiving) -> None:
        chance = Random(SEED)  # noqa: S311 - a seed makes it repeatable
        await none_is_long(place, BO, [mixed(chance) for _ in range(60)])

    run(act)


@pytest.mark.campaign
@pytest.mark.limit(7_200)
def test_no_text_at_all_makes_a_step_long() -> None:
    """The whole grid, by an admin, then texts at random by everybody."""

    async def act(place: Receiving) -> None:
        await none_is_long(place, ADA, texts())
        chance = Random(SEED)  # noqa: S311 - a seed makes it repeatable
        for who in (ADA, BO, STRANGER):
            await none_is_long(place, who, (mixed(chance) for _ in range(ROUNDS)))

    run(act)


def test_a_step_that_is_too_long_is_noticed() -> None:
    """The meter itself: a handler that takes its time is found, and named."""

    async def act(place: Receiving) -> None:
        charge = place.gateway.rooms.organiser.charge

        def slow(caller: object) -> None:
            work = [str(n).casefold() for n in range(400_000)]
            assert work
            charge(caller)  # type: ignore[arg-type]

        place.gateway.rooms.organiser.charge = slow  # type: ignore[method-assign]
        step = await too_long(place, lambda: [place.message(ADA, "status")])
        assert step is not None
        assert "_follow" in step.what

    run(act)
