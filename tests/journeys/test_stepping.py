"""Before something dangerous: a second factor, a second person, a tap. Each counts once."""

from __future__ import annotations

import time
from base64 import b32decode
from typing import TYPE_CHECKING, Any

import pytest

from rosic.authoriser.two_factor import hotp, step_at
from tests.journeys.fleet import Person
from tests.journeys.lab import Lab, lab

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher

CARE = """
[[care]]
scopes = ["ant:hop"]
step_up = true

[[care]]
scopes = ["bee:hop"]
second_person = true

[[care]]
scopes = ["cat:hop"]
confirm = true
"""
NO_GOOD = "This button is no longer good. Nothing was done."
PROVE_FIRST = "needs your second factor first"
TRIES = 5


class Phone:
    """An authenticator app on the clock of this machine."""

    def __init__(self, shown: str) -> None:
        letters = shown.partition("secret=")[2].partition("&")[0]
        self._secret = b32decode(letters + "=" * (-len(letters) % 8))

    def code(self, later: int = 0) -> str:
        """Return the code of this half minute, or of one of the next."""
        return hotp(self._secret, step_at(time.time_ns()) + later)

    def wrong(self) -> str:
        """Return a code of no half minute that is near."""
        near = {self.code(later) for later in range(-3, 4)}
        return next(
            c for c in ("000000", "111111", *map(str, range(123450, 123460))) if c not in near
        )


async def set_up(place: Lab, user: int) -> tuple[Phone, str]:
    """Enrol a phone in the private chat; return it and the code that was used for that."""
    shown = await place.ask(user, "/authenticator", "secret=")
    phone = Phone(shown["text"])
    code = phone.code()
    await type_code(place, user, code, "Your phone is set up")
    return phone, code


async def type_code(place: Lab, user: int, code: str, expected: str) -> None:
    """Type a code, and wait for the answer: it replies to nothing, as what was typed is deleted."""

    async def times() -> int:
        return sum(expected in m["text"] for m in await place.control.messages(user, by_bot=True))

    before = await times()
    await place.say(user, f"/code {code}")

    async def once_more() -> bool:
        return await times() > before

    assert await place.until(once_more), f"nobody read {expected!r}"


async def asked(place: Lab, chat: int, label: str) -> dict[str, Any]:
    """Wait for the newest message of a chat with a button of this label."""

    async def look() -> dict[str, Any] | None:
        for message in reversed(await place.control.messages(chat, by_bot=True)):
            if any(button["text"] == label for row in message["buttons"] for button in row):
                found: dict[str, Any] = message
                return found
        return None

    message = await place.until(look)
    assert message is not None, f"nobody showed {label} in {chat}"
    return dict(message)


async def answer(place: Lab, tap: str) -> str:
    """Return what whoever tapped reads at once."""

    async def look() -> Any:  # noqa: ANN401 - any JSON
        return (await place.control.call("press", query_id=tap))["answers"]

    [answered] = await place.until(look)
    return str(answered.get("text") or "")


async def press(place: Lab, user: int, label: str) -> str:
    """Tap the newest button of a label in somebody's private chat."""
    message = await asked(place, user, label)
    return await answer(place, await place.control.tap(user, user, message["message_id"], label))


def careful(place: Lab) -> None:
    """Let some skills want more than the right to them."""
    place.config.write_text(place.config.read_text() + CARE)


async def test_a_second_factor_is_asked_for_and_its_codes_count_once(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        careful(place)
        await place.start()
        room = await place.control.create_chat("supergroup", "Room", members=[place.bo])
        await place.ask(place.bo, "ant hop", PROVE_FIRST)
        await place.ask(place.bo, "/authenticator", "in a private chat", chat=room)
        assert place.acted() == 0

        phone, used = await set_up(place, place.bo)
        await place.ask(place.bo, "ant hop", "done ")
        assert place.acted() == 1
        await type_code(place, place.bo, used, "was used before")
        await place.ask(place.bo, "ant hop", PROVE_FIRST, chat=room)  # proven in another chat only
        for _ in range(TRIES - 1):
            await type_code(place, place.bo, phone.wrong(), "This code is not right")
        # Not even the right one, once five were wrong.
        await type_code(place, place.bo, phone.code(1), "Too many wrong codes. Try again in")
        await place.drained()
        assert place.acted() == 1
        assert await place.control.violations() == []


async def test_a_second_person_agrees_once_and_only_who_was_asked(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        careful(place)
        viewer = await place.control.create_user("Vi")
        config = place.config.read_text()
        person = Person(viewer, "Vi", "viewer")
        place.config.write_text(
            f'{config}\n[[principal]]\nname = "{person.name}"\n'
            f'address = "telegram:{person.account}"\nrole = "{person.role}"\n'
        )
        await place.start()
        await place.ask(viewer, "/me", "You are Vi")
        await place.ask(place.bo, "bee hop", "I have asked Ada")
        question = await asked(place, place.ada, "I agree")
        [data] = [
            button["callback_data"]
            for row in question["buttons"]
            for button in row
            if button["text"] == "I agree"
        ]

        for wrong in (viewer, place.bo):  # whoever got hold of what the button carries
            own = await place.ask(wrong, "/help", "Say stop at any time")
            tap = await place.control.tap(wrong, wrong, own["message_id"], data, forged=True)
            assert await answer(place, tap) == "This question was asked of somebody else."
        assert not [
            m for m in await place.control.messages(viewer, by_bot=True) if "wants" in m["text"]
        ]
        assert place.acted() == 0

        assert await press(place, place.ada, "I agree") == ""
        await place.reads(place.bo, "Ada agrees: Bee: hop, 1.00 m.")
        assert place.acted() == 0, "an agreement alone moves nothing"
        message = await asked(place, place.bo, "Do it")
        assert await press(place, place.bo, "Do it") == ""
        await place.reads(place.bo, "done ")
        again = await place.control.tap(
            place.bo, place.bo, message["message_id"], "Do it", stale=True
        )
        assert await answer(place, again) == NO_GOOD
        await place.drained()
        assert place.acted() == 1


@pytest.mark.parametrize(
    ("line", "label", "asks_ada"), [("cat hop", "Do it", False), ("bee hop", "I agree", True)]
)
async def test_killed_between_the_question_and_the_tap_nothing_moves(
    tmp_path: Path, launcher: Launcher, line: str, label: str, *, asks_ada: bool
) -> None:
    async with lab(tmp_path, launcher) as place:
        careful(place)
        gateway = await place.start()
        who = place.ada if asks_ada else place.bo
        await place.say(place.bo, line)
        question = await asked(place, who, label)
        gateway.kill()
        tap = await place.control.tap(who, who, question["message_id"], label)

        await place.start()

        assert await answer(place, tap) == NO_GOOD
        await place.drained()
        assert place.acted() == 0
        await place.say(place.bo, line)  # asked anew, it is asked about anew
        await asked(place, who, label)
        assert place.acted() == 0
