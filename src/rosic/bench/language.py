"""What it costs to read a line: one of the grammar, and one as people write it."""

from __future__ import annotations

from time import perf_counter_ns
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.app.features import command_table
from rosic.bench.report import BenchCase, BenchReport, case_of, machine
from rosic.config.lexicons import known_phrases
from rosic.config.profiles import known_units, load_profile, shipped_profiles
from rosic.core.language import LineContext, Vocabulary, understand
from rosic.core.language.lexicon import NO_PHRASES
from rosic.core.robot.skill import Parameter, Skill

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.robot.profile import Profile

ROUNDS, QUICK_ROUNDS = 300, 20
RUNS, QUICK_RUNS = 5, 1
MANY_SKILLS = 5_000
PROMISED_MS = 2.0
EXACT = ("omni move 1 m left", "kuka1 grasp force=20", "cf1 takeoff 1 m")
PHRASES = (
    *("can you move omni half a meter to the left?", "omni bitte fünfzig Zentimeter nach links"),
    *("por favor, mueve omni un metro adelante", "omni recule de vingt cinq centimètres"),
    *("gira o omni 90 graus para a direita", "请让 omni 前进一米"),
)
VAGUE = ("omni ein bisschen vor", "omni a little to the left", "omni froward 1 m", "omin vor 1 m")
SEQUENCES = (
    "omni move 1 m then turn left 90 degrees",
    "omni avance de 1 m puis tourne de 90 degrés",
)
NOTHING = ("omni should never move", "what a lovely day it is", "how is the weather in Lisbon?")
# As many words as are read, each of which may mean something in every language.
LONGEST = ("omni " + "left 1 m and forward 2 cm a la no " * 8)[:238].rsplit(" ", 1)[0]

METHOD = (
    "Each text read {rounds} times anew, {runs} runs, medians. Rate: texts a second. Six robots "
    "that ship are spoken of; and the same with a robot of {skills:,} skills beside them."
)
BESIDE = "{name}: {ratio:.1f} times a line of the grammar."
WORST = "The slowest of all texts: {ms:.2f} ms (promised: {promised:.0f})."
FLAT = "With {skills:,} skills beside them, what people write costs {ratio:.2f} times as much."
EXACT_RATIO = "A line of the grammar costs {ratio:.2f} times what it does without any lexicon."


def measure(*, quick: bool) -> BenchReport:
    """Return what was measured."""
    rounds, runs = (QUICK_ROUNDS, QUICK_RUNS) if quick else (ROUNDS, RUNS)
    files = shipped_profiles()
    robots = [load_profile(files[name]) for name in ("omni", "kuka1", "yumi", "cf1", "cf2", "cf3")]
    units, commands = known_units(), command_table()
    few = Vocabulary.build(robots, units, commands, known_phrases())
    many = Vocabulary.build([*robots, _of_many(robots[0])], units, commands, known_phrases())
    bare = replace(few, phrases=NO_PHRASES)
    named = {
        "grammar": (few, EXACT),
        "grammar, no lexicon": (bare, EXACT),
        "as people write": (few, PHRASES),
        "vague or misspelt": (few, VAGUE),
        "two things in one": (few, SEQUENCES),
        "no order": (few, NOTHING),
        "the longest": (few, (LONGEST,)),
        "as people write, many skills": (many, PHRASES),
    }
    cases = {
        name: case_of(name, [_run(*what, rounds) for _ in range(runs)])
        for name, what in named.items()
    }
    return BenchReport(
        machine=machine(),
        method=METHOD.format(rounds=rounds, runs=runs, skills=MANY_SKILLS),
        cases=tuple(cases.values()),
        findings=tuple(_findings(cases)),
    )


def _of_many(like: Profile) -> Profile:
    """Return a robot of very many skills, each with a choice and a number."""
    parameter = Parameter(unit="m", min=0, max=5)
    skills = {
        f"skill{n}": Skill(id=f"skill{n}", parameters={"distance": parameter})
        for n in range(MANY_SKILLS)
    }
    return replace(like, id="many", title="", words=(), groups=(), skills=skills, alerts=())


def _run(vocabulary: Vocabulary, texts: Sequence[str], rounds: int) -> tuple[float, list[float]]:
    context = LineContext("", frozenset(vocabulary.profiles))
    times: list[float] = []
    for _ in range(rounds):
        for text in texts:
            began = perf_counter_ns()
            understand(text, vocabulary, context)
            times.append(perf_counter_ns() - began)
    return len(times) / (sum(times) / 1e9), times


def _findings(cases: dict[str, BenchCase]) -> list[str]:
    exact = cases["grammar"].p50_us
    found = [EXACT_RATIO.format(ratio=exact / cases["grammar, no lexicon"].p50_us)]
    for name, case in cases.items():
        if not name.startswith("grammar"):
            found.append(BESIDE.format(name=name, ratio=case.p50_us / exact))
    slowest = max(case.p50_us for case in cases.values())
    found.append(WORST.format(ms=slowest / 1e3, promised=PROMISED_MS))
    ratio = cases["as people write, many skills"].p50_us / cases["as people write"].p50_us
    found.append(FLAT.format(skills=MANY_SKILLS, ratio=ratio))
    return found
