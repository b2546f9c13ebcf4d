"""300 hostile answers: nothing acts without a tap, and what is not a good line is not proposed."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

import pytest

from rosic.app.people import ConfiguredPerson
from rosic.core.identity import Address
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from tests.features.interpreter.interpreted import LATER_S, UNREAD, Interpreted
from tests.gateway.place import BO, PEOPLE
from tests.interpreters.hostile import GOOD, HostileAnswer, bodies, over_the_wire, sayings
from tests.interpreters.scripted import ScriptedEndpoint, saying
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Iterable

LI: Final = "7"
REFUSED: Final = 'I do not know "shuffle"'
LATE_S: Final = 0.15
LONG_S: Final = 30.0
NARROW: Final = Role(scopes=("omni:move",), limits=("omni:move distance <= 1 m",), priority=5)
THEIRS: Final = re.compile(r"omni: move, (?:0\.\d+|1\.00) m (?:forward|back|left)")


class NarrowPlace(Interpreted):
    """Where Li may let omni move one metre, and sees nothing else."""

    rulebook = RoleRules(roles={**DEFAULT_ROLES, "narrow": NARROW})
    people = (*PEOPLE, ConfiguredPerson("Li", (Address("memory", LI),), ("narrow",)))


def test_they_are_three_hundred() -> None:
    found = [*over_the_wire(""), *bodies(), *sayings()]
    assert len(found) >= 300
    kinds = [each.kind for each in found]
    assert len(set(kinds)) == len(kinds)


async def ask_all(
    answers: Iterable[HostileAnswer], endpoint: ScriptedEndpoint, timeout_s: float | None = None
) -> list[str]:
    """Return what was proposed, having seen of each that only a refusal and no motion came."""
    proposed: list[str] = []
    async with NarrowPlace(endpoint.client(timeout_s=timeout_s or LONG_S * pace())).open() as place:
        await place.allow(LI)
        for answer in answers:
            endpoint.script = answer.script
            before = len(endpoint.calls)
            refusal, *more = await place.ask(UNREAD, account=LI)
            assert refusal.startswith(REFUSED), answer.kind
            assert len(endpoint.calls) == before + 1, answer.kind
            assert place.all_acted() == 0, answer.kind
            if more:
                for button, under in place.proposals():
                    assert THEIRS.fullmatch(button.label), answer.kind
                    assert button.label in more[0]
                    await place.tap(button, under, account=BO)
                    assert place.all_acted() == 0, answer.kind
                    proposed.append(f"{answer.kind}: {button.label}")
            assert place.counts.get("late", 0) == 0 or answer.slow, answer.kind
            await place.clock.advance(LATER_S)
        if timeout_s is None:
            await check_a_good_one(place, endpoint)
    return proposed


async def check_a_good_one(place: NarrowPlace, endpoint: ScriptedEndpoint) -> None:
    """See that after all of that a good answer is a good answer: proposed, and a tap acts."""
    endpoint.script = saying(GOOD)
    await place.ask(UNREAD, account=LI)
    ((button, under),) = place.proposals()
    await place.tap(button, under, account=LI)
    assert (place.acted(), place.all_acted()) == (1, 1)


@pytest.mark.limit(300)
async def test_what_comes_over_the_wire_costs_nothing_but_the_proposal() -> None:
    with ScriptedEndpoint(saying(GOOD)) as elsewhere, ScriptedEndpoint(saying(GOOD)) as endpoint:
        answers = [*over_the_wire(f"{elsewhere.address}/v1/chat/completions")]
        assert await ask_all([a for a in answers if not a.slow], endpoint) == []
        assert await ask_all([a for a in answers if a.slow], endpoint, LATE_S) == []
        assert elsewhere.calls == []  # no redirect was followed


@pytest.mark.limit(300)
async def test_what_a_body_holds_costs_nothing_but_the_proposal() -> None:
    with ScriptedEndpoint(saying(GOOD)) as endpoint:
        assert await ask_all(bodies(), endpoint) == []


@pytest.mark.limit(300)
async def test_what_it_says_is_proposed_only_if_this_person_could_have_said_it() -> None:
    with ScriptedEndpoint(saying(GOOD)) as endpoint:
        assert await ask_all(sayings(), endpoint) == []
