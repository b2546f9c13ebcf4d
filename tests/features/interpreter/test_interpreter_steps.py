"""I15: whatever an interpreter answers, and however much can be said, no step takes 20 ms."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.bench.recorder import pace_of_machine
from rosic.bench.strangers import LoopStep, MeteredLoop, undisturbed
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Parameter, Skill
from tests.features.interpreter.interpreted import LATER_S, Interpreted
from tests.interpreters.hostile import bodies, chunked, dripping, endless, raw, sayings
from tests.interpreters.scripted import ScriptedEndpoint, completion, http, saying

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from tests.interpreters.scripted import Script

LONGEST_STEP_S = 0.020
TRIES = 5
UNREAD = "would you kindly shuffle a smidgen ahead"
ROBOTS, SKILLS = 50, 100
WORDS = 12

LONG_TEXTS = (
    ("hum " * 75).strip(),
    "a" * 300,
    "ada bo vi " * 30,
    "\u0301" * 300,
    "\ufdfa" * 300,
    "aa1 " * 75,
    "(" * 300,
    "abcd efgh " * 30,
)


def many() -> tuple[Profile, ...]:
    """Return 5,000 skills of fifty robots, each with choices and numbers."""
    names = [f"word{chr(97 + number)}" for number in range(WORDS)]
    skills = {
        f"act{number}": Skill(
            id=f"act{number}",
            parameters={
                "where": Parameter(choices=dict.fromkeys(names, ())),
                "far": Parameter(unit="m", min=0.01, max=5.0),
            },
        )
        for number in range(SKILLS)
    }
    return tuple(
        Profile(id=f"robot{number}", link=Link(kind="memory"), skills=skills)
        for number in range(ROBOTS)
    )


def longest_step(
    script: Script,
    texts: Iterable[str],
    fleet: Callable[[], tuple[Profile, ...]] | None = None,
    timeout_s: float = 0.5,
) -> LoopStep:
    """Return the longest step of asking about texts, from the line to what becomes of it."""

    async def main() -> LoopStep:
        loop = asyncio.get_running_loop()
        assert isinstance(loop, MeteredLoop)
        with ScriptedEndpoint(script) as endpoint:
            client = endpoint.client(timeout_s=timeout_s)
            made = None if fleet is None else fleet()
            async with Interpreted(client, fleet=made).open() as place:
                await place.allow()
                await place.ask(UNREAD)  # what is made once is made
                await place.clock.advance(LATER_S)
                loop.reset()
                for text in texts:
                    await place.ask(text)
                    found = loop.longest
                    await place.clock.advance(LATER_S)
                    loop.longest = found  # what is due each minute is measured elsewhere
        return loop.longest

    with undisturbed(), asyncio.Runner(loop_factory=MeteredLoop) as runner:
        return runner.run(main())


def check(step: Callable[[], LoopStep]) -> None:
    """See that nothing takes too long, of several tries in one at least."""
    found: list[LoopStep] = []
    for _ in range(TRIES):
        found.append(step())
        if found[-1].cpu_ns / 1e9 <= LONGEST_STEP_S * pace_of_machine():
            return
    raise AssertionError(min(found))


@pytest.mark.parametrize(
    "script",
    [
        pytest.param(script, id=kind)
        for kind, script in {
            "a huge body": raw(http(b" " * 400_000)),
            "an endless body": endless(b" " * 65_536, b"HTTP/1.1 200 OK\r\n\r\n"),
            "many chunks": raw(chunked(*[b" "] * 2_500, completion("x"))),
            "drops of ends": dripping(chunked(*[b"0\r\n\r\n"] * 1_600, last=b""), 0.0),
            "deep": raw(http(b"[" * 16_000)),
            "deep beside it": raw(http(b'{"a":' + b"[" * 8_000 + b"]" * 8_000 + b"}")),
            "a huge number": raw(http(b'{"choices": ' + b"9" * 16_000 + b"}")),
            "long lines": saying("\n".join("omni move " + "1 m " * 1_300 for _ in range(3))),
            "lines as long as may be": saying("\n".join(["omni " + "move 1 m " * 12] * 100)),
            "lines of marks": saying("\n".join(["o" + "\u0301" * 119] * 40)),
            "lines of signs": saying("\n".join(["o" + "\ufdfa" * 119] * 40)),
            "lines of brackets": saying("\n".join(["a" + "(" * 119] * 100)),
            "lines of numbers": saying("\n".join(["omni move " + "1 " * 55] * 100)),
            "lines of breaks": saying("\n" * 15_000),
        }.items()
    ],
)
def test_no_answer_takes_a_long_step(script: Script) -> None:
    check(lambda: longest_step(script, [UNREAD] * 2))


@pytest.mark.limit(300)
def test_of_all_hostile_answers_none_takes_a_long_step() -> None:
    answers = [*bodies(), *sayings()][::5]

    def step() -> LoopStep:
        def script(call: object) -> None:
            each = answers[next(turn) % len(answers)]
            each.script(call)  # type: ignore[arg-type]

        turn = iter(range(10_000))
        return longest_step(script, [UNREAD] * len(answers))

    check(step)


def test_no_text_takes_a_long_step() -> None:
    check(lambda: longest_step(saying("omni wave"), LONG_TEXTS))


def test_however_much_can_be_said_no_step_is_long() -> None:
    answer = "robot7 act3 wordb 0.5 m\nrobot49 act99 wordc 1 m"
    check(lambda: longest_step(saying(answer), [UNREAD] * 3, many))
