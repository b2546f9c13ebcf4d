# ruff: noqa: RUF001 - people type what is ambiguous
"""Whatever is sent, what comes back is a line or a refusal, in time linear in the text."""

from __future__ import annotations

import contextlib
import gc
import itertools
import sys
from functools import partial
from random import Random
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosic.app.features import command_table
from rosic.bench import language as bench
from rosic.config.units import compile_units
from rosic.core.language import (
    Do,
    LineContext,
    Misunderstood,
    Vocabulary,
    bind,
    clean,
    hears_stop,
    show,
    understand,
)
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Argument, Parameter, Skill
from rosic.errors import Refusal
from tests.core.language.fleet import DIRECTIONS, profiles

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from types import FrameType

    from _typeshed import TraceFunction

COMMANDS = """
omni move 50 cm left
omni move forward 0.5 m
omni move half a metre
omni turn left 90 deg
omni go home
kuka1 grasp force=20
kuka1 grasp force = 20 N
kuka1 move joint 3 -30 deg
yumi handover
crazyflies takeoff 1 m
cf1 goto 1 2 1.5
cf1 goto x=1 m y=-2 z=1.5
/move@lab_robots_bot omni 1 m
oven heat 100 °C 50 %
echo say Hello there
status omni and crazyflies
help kuka1
use omni
resume omni
stop omni
please omni, move 1,5 m to the left
takeoff 1 m
KUKA iiwa grasp
""".strip().splitlines()
ODDITIES = [
    "nan",
    "-inf",
    "1e999",
    "10^400",
    "1,500",
    "1/0",
    "½",
    "1½",
    "--5",
    "=",
    "==",
    "@",
    "/",
    "m",
    "\ud800",
    "\udfff",
    "\x00",
    "\u202e",
    "\u200b",
    "\n",
    "\r\n",
    "\u2028",
    "\t",
    "ﷺ",
    "🛑",
    "²",
    "9" * 400,
    "a" * 200,
    "force=",
    "=5",
    "😀",
    "\u0301" * 20,
    "٣",
    "𝟓",
    "..",
    "?",
    "to",
    "stop",
]

VOCABULARY = Vocabulary.build(profiles(), compile_units(), command_table())
CONTEXTS = [
    LineContext("", frozenset(VOCABULARY.profiles)),
    LineContext("omni", frozenset(VOCABULARY.profiles)),
    LineContext("echo", frozenset(VOCABULARY.profiles)),
    LineContext("crazyflies", frozenset({"omni", "cf2"})),
    LineContext("nobody", frozenset()),
]


def is_fit_to_show(text: str) -> bool:
    """Whether it can be sent, stored and put before a person."""
    return clean(text) == text and bool(text.encode())


def follow(text: str, context: LineContext) -> int:
    """Take a message the whole way; return how many commands it held that could be carried out."""
    stop = hears_stop(text, VOCABULARY.known)
    lines = understand(text, VOCABULARY, context)
    assert 1 <= len(lines) <= 20
    carried_out = 0
    for line in lines:
        if isinstance(line, Do):
            carried_out += sum(carry_out(line))
        elif isinstance(line, Misunderstood):
            assert is_fit_to_show(line.sentence)
            assert len(line.sentence) < 400
            assert all(map(is_fit_to_show, line.offers))
    if carried_out and len(lines) == 1 and lines[0].skills[0].id != "say":  # type: ignore[union-attr]
        assert stop is None, text
    return carried_out


def carry_out(line: Do) -> Iterator[int]:
    line.text.encode()
    for robot, skill in zip(line.robots, line.skills, strict=True):
        refusal: Refusal | None = None
        arguments: dict[str, Argument] = {}
        try:
            arguments = bind(VOCABULARY, robot, skill, line.spoken, group=line.group)
        except Refusal as why_not:
            refusal = why_not
        if refusal is None:
            assert list(arguments) == list(skill.parameters)
            assert is_fit_to_show(show(VOCABULARY, robot, skill, arguments))
        else:
            assert is_fit_to_show(str(refusal))
            assert len(str(refusal)) < 400
            assert all(map(is_fit_to_show, refusal.offers))
        yield refusal is None


def mutated(random: Random) -> str:
    text = random.choice(COMMANDS)
    for _ in range(random.randrange(4)):
        at = random.randrange(len(text) + 1)
        match random.randrange(7):
            case 0:
                text = text[:at] + text[at + 1 :]
            case 1:
                text = text[:at] + random.choice(ODDITIES) + text[at:]
            case 2:
                text = f"{text[:at]} {random.choice(ODDITIES)} {text[at:]}"
            case 3:
                text = text[: at - 1] + text[at : at + 1] + text[at - 1 : at] + text[at + 1 :]
            case 4:
                words = text.split(" ")
                random.shuffle(words)
                text = " ".join(words)
            case 5:
                text = f"{text}\n{random.choice(COMMANDS)}"
            case _:
                text = text[:at] + chr(random.randrange(0x110000)) + text[at + 1 :]
    return text


def noise(random: Random) -> str:
    top = random.choice((0x80, 0x3000, 0x110000))
    return "".join([chr(random.randrange(top)) for _ in range(random.randrange(60))])


@pytest.mark.limit(240)
@pytest.mark.parametrize("messages", [25_000, pytest.param(100_000, marks=pytest.mark.campaign)])
def test_however_many_messages_raise_nothing_but_refusals(messages: int) -> None:
    random = Random(20)  # noqa: S311 - the same messages every time
    carried_out = 0
    for number in range(messages):
        text = noise(random) if number % 4 == 0 else mutated(random)
        if number % 5000 == 0:
            text *= 1 + 100_000 // (len(text) + 1)
        carried_out += follow(text, CONTEXTS[number % len(CONTEXTS)])
    # The mutations leave enough alone to reach every room behind the grammar.
    assert carried_out > messages // 10


@settings(deadline=None)  # a busy machine is no fault
@given(text=st.text(st.characters(codec=None), max_size=200), context=st.sampled_from(CONTEXTS))
def test_any_text_at_all(text: str, context: LineContext) -> None:
    follow(text, context)


@settings(deadline=None)  # a busy machine is no fault
@given(
    lines=st.lists(
        st.tuples(st.sampled_from(COMMANDS), st.lists(st.sampled_from(ODDITIES), max_size=3)).map(
            lambda said: " ".join([said[0], *said[1]])
        ),
        min_size=1,
        max_size=25,
    ),
    context=st.sampled_from(CONTEXTS),
)
def test_any_lines_of_commands_and_oddities(lines: list[str], context: LineContext) -> None:
    follow("\n".join(lines), context)


# ---- linear, by counting what the interpreter does ----


def steps(work: Callable[[], object]) -> int:
    """Count the lines of Python executed and the functions called, built-in ones included.

    Not what is remembered for everybody at the first time, nor what ends because somebody else's
    objects are collected meanwhile.
    """
    work()
    count = 0

    def trace(_: FrameType, event: str, __: object) -> TraceFunction:
        nonlocal count
        count += event == "line"
        return trace

    def profile(_: FrameType, event: str, __: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    before, before_profile = sys.gettrace(), sys.getprofile()
    gc.collect()
    gc.disable()
    sys.settrace(trace)
    sys.setprofile(profile)
    try:
        work()
    finally:
        sys.settrace(before)
        sys.setprofile(before_profile)
        gc.enable()
    return count


SHAPES = [
    "a",
    "1",
    "1,",
    "1.",
    "=",
    "@a",
    "a ",
    "1 ",
    "1 m ",
    "left ",
    "omni ",
    "s t o p ",
    "🛑",
    "ﷺ",
    "\u0301",
    "\n",
    "a\n",
    "stop\n",
    "omni move 1 m\n",
    "stop ",
    "please ",
    "/",
    "1/",
    "10^",
    "é ",
    "½",
    "x=",
    "status ",
    "the omni ",
    "\u200b",
    "go ",
    "straight ",
    "halt, ",
    "\ud800",
]
PREFIXES = ["", "omni ", "omni move ", "status ", "stop ", "echo ", "sotp "]


@pytest.mark.parametrize("shape", SHAPES)
def test_work_grows_no_faster_than_the_text(shape: str) -> None:
    for prefix in PREFIXES:
        # Whole shapes: half a word at the end is another word, with other work.
        texts = [prefix + shape * (size // len(shape)) for size in (500, 1000, 2000)]
        counts = [steps(partial(follow_plainly, text)) for text in texts]
        for smaller, larger in itertools.pairwise(counts):
            assert larger <= 2.2 * smaller + 1500, (prefix, shape, counts)


def follow_plainly(text: str) -> None:
    hears_stop(text, VOCABULARY.known)
    for line in understand(text, VOCABULARY, CONTEXTS[0]):
        if isinstance(line, Do):
            with contextlib.suppress(Refusal):
                bind(VOCABULARY, line.robots[0], line.skills[0], line.spoken)


@pytest.mark.parametrize("size", [4096, 4097, 10_000, 100_000])
def test_beyond_the_cap_no_more_is_done(size: int) -> None:
    text = "omni move 1 m " * (size // 14 + 1)

    assert steps(lambda: hears_stop(text[:size])) <= steps(lambda: hears_stop(text[:4096])) + 50
    if size > 4096:
        assert steps(lambda: understand(text[:size], VOCABULARY, CONTEXTS[0])) < 100


def fleet(robots: int, skills: int) -> Vocabulary:
    def robot(number: int) -> Profile:
        own = {f"skill{n}": Skill(id=f"skill{n}") for n in range(skills - 1)}
        move = Skill(
            id="move",
            parameters={
                "direction": Parameter(choices=DIRECTIONS, default="forward"),
                "distance": Parameter(unit="m", min=0, max=5),
            },
        )
        name = f"omni{number}" if number else "omni"
        return Profile(id=name, link=Link(kind="memory"), skills={"move": move, **own})

    return Vocabulary.build(map(robot, range(robots)), VOCABULARY.units, command_table())


@pytest.mark.parametrize("text", ["omni move forward 0.5 m", "/move omni 1 m", "status omni"])
def test_the_number_of_robots_and_skills_costs_nothing(text: str) -> None:
    counts = []
    for robots, skills in ((1, 5), (50, 10), (300, 20)):
        vocabulary = fleet(robots, skills)
        context = LineContext("", frozenset(vocabulary.profiles))

        def work(vocabulary: Vocabulary = vocabulary, context: LineContext = context) -> None:
            hears_stop(text, vocabulary.known)
            (line,) = understand(text, vocabulary, context)
            if isinstance(line, Do):
                bind(vocabulary, line.robots[0], line.skills[0], line.spoken)

        counts.append(steps(work))
    assert counts[0] == counts[1] == counts[2]


def test_what_is_not_understood_is_looked_for_among_a_bounded_number() -> None:
    counts = []
    for robots in (1000, 2000):
        vocabulary = fleet(robots, 3)
        context = LineContext("", frozenset(vocabulary.profiles))
        counts.append(steps(lambda v=vocabulary, c=context: understand("omn move", v, c)))  # type: ignore[misc]
    assert counts[1] <= 1.1 * counts[0]


MOST_STEPS = 40_000
"""Some 2 ms: of one and the same text they differ by a third from hour to hour."""


def test_the_slowest_text_that_can_be_written_costs_what_is_promised() -> None:
    vocabulary = bench.vocabulary_of_robots()
    context = LineContext("", frozenset(vocabulary.profiles))
    texts = (*bench.SLOWEST, *bench.contrived_texts(vocabulary, bench.QUICK_CONTRIVED))
    costs = {text: steps(partial(understand, text, vocabulary, context)) for text in texts}
    assert {text: cost for text, cost in costs.items() if cost > MOST_STEPS} == {}
