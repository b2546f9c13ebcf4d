"""300 hostile answers: nothing acts without a tap, and what is not a good line is not proposed."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

import pytest

from rosic.app.people import ConfiguredPerson
from rosic.core.identity import Address
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from tests.features.interpreter.interpreted import LATER_S, Interpreted
from tests.gateway.place import BO, PEOPLE
from tests.interpreters.hostile import GOOD, HostileAnswer, bodies, over_the_wire, sayings
from tests.interpreters.scripted import ScriptedEndpoint, saying

if TYPE_CHECKING:
    from collections.abc import Iterable

LI: Final = "7"
UNREAD: Final = "would you kindly shuffle a smidgen ahead"
REFUSED: Final = 'I do not know "would"'
LATE_S: Final = 0.15
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


async def ask_all(answers: Iterable[HostileAnswer], endpoint: ScriptedEndpoint) -> list[str]:
    """Return what was proposed, having seen of each that only a refusal and no motion came."""
    proposed: list[str] = []
    async with NarrowPlace(endpoint.client(timeout_s=LATE_S)).open() as place:
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
            await place.clock.advance(LATER_S)
        # After all of that a good answer is a good answer.
        endpoint.script = saying(GOOD)
        await place.ask(UNREAD, account=LI)
        ((button, under),) = place.proposals()
        await place.tap(button, under, account=LI)
        assert (place.acted(), place.all_acted()) == (1, 1)
    return proposed


@pytest.mark.limit(300)
async def test_what_comes_over_the_wire_costs_nothing_but_the_proposal() -> None:
    with ScriptedEndpoint(saying(GOOD)) as elsewhere, ScriptedEndpoint(saying(GOOD)) as endpoint:
        answers = over_the_wire(f"{elsewhere.address}/v1/chat/completions")
        assert await ask_all(answers, endpoint) == []
        assert elsewhere.calls == []  # no redirect was followed


@pytest.mark.limit(300)
async def test_what_a_body_holds_costs_nothing_but_the_proposal() -> None:
    with ScriptedEndpoint(saying(GOOD)) as endpoint:
        assert await ask_all(bodies(), endpoint) == []


@pytest.mark.limit(300)
async def test_what_it_says_is_proposed_only_if_this_person_could_have_said_it() -> None:
    with ScriptedEndpoint(saying(GOOD)) as endpoint:
        assert await ask_all(sayings(), endpoint) == []
