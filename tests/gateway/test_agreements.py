"""What a line comes to for somebody, how it is shown, and what a button is bound to (I16)."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, NamedTuple

import pytest
from msgspec.structs import replace

from rosic.core.identity import DIGEST_BYTES, Address, Caller
from rosic.core.language import Do, Line
from rosic.core.message import Button, Chat
from rosic.errors import Expired, OutOfBounds, Refusal
from tests.gateway.place import BO, FLEET, Place, profile
from tests.gateway.test_rights import who

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.core.robot.profile import Profile
    from rosic.gateway.agreement import Agreements

CHAT = Chat("memory", BO)


class Table(NamedTuple):
    """One person, and what their words come to."""

    place: Place
    agreements: Agreements
    caller: Caller

    def lines(self, text: str, selected: str = "") -> tuple[Line, ...]:
        """Read some words."""
        visible = frozenset(self.place.gateway.rooms.profiles)
        return self.agreements._reader.lines(text, selected, visible)

    def line(self, text: str, selected: str = "") -> Do:
        """Read one line that lets robots do something."""
        (line,) = self.lines(text, selected)
        assert isinstance(line, Do)
        return line

    async def choose(self, name: str) -> None:
        """Choose a robot."""
        await self.place.say(f"/use {name}", account=BO, chat=BO)

    def bound(self, command: str, label: str = "label", act: bytes = b"") -> Button:
        """Bind a button."""
        return self.agreements.bind(Button(label, command, act=act), self.caller, CHAT)


@asynccontextmanager
async def table(fleet: tuple[Profile, ...] = FLEET) -> AsyncIterator[Table]:
    async with Place(fleet=fleet).open() as place:
        caller = Caller(who(place, "Bo"), "Bo", Address("memory", BO), "key", "session")
        yield Table(place, place.gateway.pipeline.agreements, caller)


# ---- what a button is bound to ----


async def test_a_button_names_its_robot_and_is_bound_to_what_it_does() -> None:
    async with table() as at:
        await at.choose("omni")
        button = at.bound("move 1 m", "move 1 m")
        assert (button.label, button.command) == ("omni move 1 m", "omni move 1 m")
        assert button.act == at.agreements.of(at.line("omni move 1 m"), at.caller).digest
        assert at.bound("move 1 m", "Further").label == "Further"
        assert at.bound("move 1 m") == at.bound("omni move 1 m")


@pytest.mark.parametrize("mark", ["!", ">", "^"])
async def test_what_a_button_is_marked_with_stays(mark: str) -> None:
    async with table() as at:
        await at.choose("omni")
        button = at.bound(f"{mark}move 1 m")
        assert button.command == f"{mark}omni move 1 m"
        assert button.act == at.bound("move 1 m").act


async def test_what_was_bound_to_an_act_is_not_bound_to_another() -> None:
    """A question that was put under other rules stays that question."""
    async with table() as at:
        shown = Button("Do it", "omni move 1 m", act=b"what was shown")
        assert at.agreements.bind(shown, at.caller, CHAT) is shown


@pytest.mark.parametrize(
    "command",
    [
        "status",
        "?omni move 1 m",
        "/use omni",
        "omni move 99 m",
        "leave it",
        "omni",
        "/task go 1",
        "/task omni move 99 m",
        "/task nobody move 1 m",
    ],
)
async def test_what_lets_no_robot_do_anything_is_bound_to_nothing(command: str) -> None:
    async with table() as at:
        assert at.bound(command) == Button("label", command)


async def test_several_lines_are_bound_together_as_they_were_said() -> None:
    async with table() as at:
        await at.choose("omni")
        both = at.bound("omni move 1 m\ncf1 move 1 m", "Both")
        assert both.command == "omni move 1 m\ncf1 move 1 m"
        acts = {
            both.act,
            at.bound("omni move 1 m").act,
            at.bound("cf1 move 1 m").act,
            at.bound("cf1 move 1 m\nomni move 1 m").act,
            at.bound("swarm move 1 m").act,
            at.bound("omni move 2 m").act,
            at.bound("omni wave").act,
        }
        assert len(acts) == 7


# ---- what a tap may do ----


async def test_a_tap_does_what_it_agreed_to_and_nothing_that_differs() -> None:
    async with table() as at:
        lines = at.lines("omni move 1 m\ncf1 move 2 m")
        act = at.bound("omni move 1 m\ncf1 move 2 m").act
        at.agreements.check(at.caller, lines, act)
        for other in (b"", b"other", at.bound("omni move 1 m").act):
            with pytest.raises(Expired) as caught:
                at.agreements.check(at.caller, lines, other)
            assert "now it would be omni: move, 1.00 m forward; cf1: move, 2.00 m forward." in str(
                caught.value
            )
        for earlier in (act[:DIGEST_BYTES] + bytes(8), act[:DIGEST_BYTES], act[:-1]):
            with pytest.raises(Expired, match="The rules here have changed since you were asked"):
                at.agreements.check(at.caller, lines, earlier)


@pytest.mark.parametrize("text", ["status", "omni move 99 m", "omni fly", ""])
async def test_what_moves_nothing_needs_no_agreement(text: str) -> None:
    """What is refused for what it says is refused where that is looked at."""
    async with table() as at:
        at.agreements.check(at.caller, at.lines(text), b"")


async def test_what_is_refused_hides_nothing_that_is_not() -> None:
    async with table() as at:
        with pytest.raises(Expired, match="now it would be cf1: move, 1"):
            at.agreements.check(at.caller, at.lines("omni move 99 m\ncf1 move 1 m"), b"")


async def test_an_act_is_current_as_long_as_it_comes_to_the_same() -> None:
    async with table() as at:
        line = at.line("omni move 1 m")
        act = at.agreements.of(line, at.caller)
        assert at.agreements.is_current(act, line, at.caller) is True
        assert at.agreements.is_current(act, at.line("omni move 2 m"), at.caller) is False
        too_far = at.line("omni move 99 m")
        with pytest.raises(OutOfBounds):
            at.agreements.of(too_far, at.caller)
        assert at.agreements.is_current(act, too_far, at.caller) is False


# ---- how it is named and shown ----


async def test_a_line_names_whom_it_is_for_once() -> None:
    async with table() as at:
        named = at.agreements.named
        assert named(at.line("move 1 m", "omni")) == "omni move 1 m"
        assert named(at.line("omni move 1 m", "cf1")) == "omni move 1 m"
        assert named(at.line("swarm move 1 m")) == "swarm move 1 m"
        assert named(at.line("move 1 m", "swarm")) == "swarm move 1 m"


async def test_what_is_offered_instead_names_its_robot_and_other_offers_stay() -> None:
    async with table() as at:
        line = at.line("move 1 m", "omni")
        refusal = Refusal("no", offers=("move 1 m", "omni wave", "status"))
        at.agreements.make_good(refusal, line, at.caller, CHAT)
        assert refusal.offers == ("omni move 1 m", "omni wave", "status")
        (status,) = at.lines("status")
        untouched = Refusal("no", offers=("move 1 m",))
        at.agreements.make_good(untouched, status, at.caller, CHAT)
        assert untouched.offers == ("move 1 m",)
        nothing = Refusal("no")
        at.agreements.make_good(nothing, line, at.caller, CHAT)
        assert nothing.offers == ()


async def test_an_act_is_shown_with_its_robots_and_every_value() -> None:
    async with table() as at:
        alone = at.agreements.of(at.line("omni move 1 m"), at.caller)
        assert (alone.command, alone.shown) == ("omni move 1 m", "omni: move, 1.00 m forward")
        group = at.agreements.of(at.line("move 1 m", "swarm"), at.caller)
        assert group.command == "swarm move 1 m"
        assert group.shown == "swarm (cf1, cf2): move, 1.00 m forward"
        assert [(part.robot, part.skill, part.arguments["distance"]) for part in group.parts] == [
            ("cf1", "move", 1.0),
            ("cf2", "move", 1.0),
        ]
        with pytest.raises(Expired, match=r"it would be omni, cf1: move, 1\.00 m forward\."):
            at.agreements.check(at.caller, at.lines("omni move 1 m\ncf1 move 1 m"), b"")


async def test_members_of_a_group_that_do_different_things_are_shown_one_by_one() -> None:
    far = profile("far", groups=("both",))
    move = replace(
        far.skills["move"],
        parameters={
            **far.skills["move"].parameters,
            "distance": replace(far.skills["move"].parameters["distance"], default=3.0),
        },
    )
    near = replace(
        move,
        parameters={
            **move.parameters,
            "distance": replace(move.parameters["distance"], default=0.5),
        },
    )
    fleet = (
        replace(far, skills={**far.skills, "move": move}),
        replace(profile("near", groups=("both",)), skills={**far.skills, "move": near}),
    )
    async with table(fleet) as at:
        act = at.agreements.of(at.line("both move"), at.caller)
        assert act.shown == "far: move, 3.00 m forward; near: move, 0.50 m forward"


async def test_a_group_of_one_is_shown_as_that_robot() -> None:
    async with table((profile("solo", groups=("few",)),)) as at:
        act = at.agreements.of(at.line("few move 1 m"), at.caller)
        assert (act.command, act.shown) == ("few move 1 m", "solo: move, 1.00 m forward")


async def test_of_many_robots_only_so_many_are_named() -> None:
    fleet = tuple(
        profile(f"r{number:02}", groups=("all51", "fifty")[: 1 + (number < 50)])
        for number in range(51)
    )
    async with table(fleet) as at:
        many = at.agreements.of(at.line("all51 move 1 m"), at.caller).shown
        assert many.endswith("r48, r49, ...): move, 1.00 m forward")
        fifty = at.agreements.of(at.line("fifty move 1 m"), at.caller).shown
        assert fifty.endswith("r48, r49): move, 1.00 m forward")


# ---- several at once ----


async def test_together_is_bound_to_what_each_of_them_does() -> None:
    async with table() as at:
        one = at.bound("/together omni+cf1 move 1 m")
        assert one.act
        same = [at.bound(f"/{verb} omni+cf1 move 1 m").act for verb in ("together", "broadcast")]
        assert same == [one.act, one.act]
        assert at.bound("/together OMNI+cf1 move 1 m").act == one.act
        others = {
            at.bound(f"/together {what}").act
            for what in ("cf1+omni move 1 m", "omni move 1 m", "omni+cf1 move 2 m", "swarm wave")
        }
        assert len({one.act, *others}) == 5
        assert at.bound("/together swarm move 1 m").act == at.bound("swarm move 1 m").act


async def test_a_task_is_bound_to_every_step_of_each_who_may_do_it() -> None:
    async with table() as at:
        acts = [
            at.bound(f"/task {what}").act
            for what in ("cf1 move 1 m", "cf1 move 2 m", "cf1 move 1 m then wave", "any move 1 m")
        ]
        assert all(acts)
        assert len(set(acts)) == 4
        assert at.bound("/task cf1 move 1 m priority 2").act == acts[0]
