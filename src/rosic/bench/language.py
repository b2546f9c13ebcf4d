"""What it costs to read a line: one of the grammar, and one as people write it."""

from __future__ import annotations

from random import Random
from statistics import median
from time import perf_counter_ns, thread_time_ns
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.app.features import command_table
from rosic.bench.recorder import pace_of_machine
from rosic.bench.report import BenchCase, BenchReport, case_of, machine
from rosic.config.lexicons import known_phrases
from rosic.config.profiles import known_units, load_profile, shipped_profiles
from rosic.core.language import (
    LONGEST_TEXT,
    MOST_LINES,
    MOST_PHRASE_WORDS,
    LineContext,
    Vocabulary,
    understand,
)
from rosic.core.language.lexicon import NO_PHRASES
from rosic.core.robot.skill import Parameter, Skill

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.bench.recorder import BenchRecorder
    from rosic.core.robot.profile import Profile


ROUNDS, QUICK_ROUNDS = 300, 20
RUNS, QUICK_RUNS = 5, 1
ROBOTS = ("omni", "kuka1", "yumi", "cf1", "cf2", "cf3")
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
# Texts that nobody writes: as many words as are read, of any language, drawn at random; some were
# found by changing words of the slowest for as long as that made them slower.
CONTRIVED, QUICK_CONTRIVED = 300, 30
CONTRIVED_ROUNDS = 9
SEED = 7
COMMON = """
    omni drone drones all left right up down forward back move turn take land off it no again then
    and und links vor para zu a little bit half faster meter degrees 8
"""
SLOWEST = (
    "fünfundneunzig minute fünfte degré zwoa drone decaler row para quadcopters para 8 formacao",
    "links para degrees 8 fünfte funften row drone aujourd'hui para degré formacao minute",
    "drones meter 1st hauteur drones landen fünfundvierzig para",
    "drones " * MOST_PHRASE_WORDS,
    "omin forwrad 1 m\nomin forwrad 1 m",
    "\n".join(["omin forwrad 1 m and then land on it"] * MOST_LINES),
    ("left " * LONGEST_TEXT)[:LONGEST_TEXT],
    ("前进" * LONGEST_TEXT)[:LONGEST_TEXT],
)

METHOD = (
    "Each text read {rounds} times anew, {runs} runs, medians. Rate: texts a second. Six robots "
    "that ship are spoken of; and the same with a robot of {skills:,} skills beside them. "
    "Contrived: {contrived} texts of {words} words at random from all lexicons, and the slowest "
    "that a search found; processor time, in units of the machine for which figures are promised."
)
BESIDE = "{name}: {ratio:.1f} times a line of the grammar."
WORST = "The slowest of all texts: {ms:.2f} ms (promised: {promised:.0f})."
CONTRIVED_WORST = "The slowest contrived text: {ms:.2f} ms (promised: {promised:.0f})."
FLAT = "With {skills:,} skills beside them, what people write costs {ratio:.2f} times as much."
EXACT_RATIO = "A line of the grammar costs {ratio:.2f} times what it does without any lexicon."


def measure(recorder: BenchRecorder) -> BenchReport:
    """Return what was measured."""
    rounds, runs = (QUICK_ROUNDS, QUICK_RUNS) if recorder.quick else (ROUNDS, RUNS)
    few = vocabulary_of_robots()
    many = vocabulary_of_robots(many_skills=True)
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
    for _ in range(runs):
        for name, what in named.items():
            with recorder.turn(name, of=runs) as turn:
                turn.saw(*_run(*what, rounds))
    cases = {case.name: case for case in recorder.cases()}
    texts = contrived_texts(few, QUICK_CONTRIVED if recorder.quick else CONTRIVED)
    costs = [_cost_ns(text, few) for text in (*SLOWEST, *texts)]
    contrived = case_of("contrived", [(1e9 * len(costs) / sum(costs), costs)])
    worst = CONTRIVED_WORST.format(ms=max(costs) / 1e6, promised=PROMISED_MS)
    return BenchReport(
        machine=machine(),
        method=METHOD.format(
            rounds=rounds,
            runs=runs,
            skills=MANY_SKILLS,
            contrived=len(texts),
            words=MOST_PHRASE_WORDS,
        ),
        cases=(*cases.values(), contrived),
        findings=(*_findings(cases), worst),
    )


def vocabulary_of_robots(*, many_skills: bool = False) -> Vocabulary:
    """Return what can be said of six robots that ship, and of one of very many skills."""
    files = shipped_profiles()
    robots = [load_profile(files[name]) for name in ROBOTS]
    if many_skills:
        robots.append(_of_many(robots[0]))
    return Vocabulary.build(robots, known_units(), command_table(), known_phrases())


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


def contrived_texts(vocabulary: Vocabulary, count: int) -> list[str]:
    """Return texts of words of any language, half of them of frequent ones."""
    words = sorted(
        {word for table in vocabulary.phrases.tables for word in table.senses if " " not in word}
    )
    common = COMMON.split()
    drawn = Random(SEED)  # noqa: S311 - the same texts each time
    return [
        " ".join(drawn.choice(common if at % 2 else words) for _ in range(MOST_PHRASE_WORDS))
        for at in range(count)
    ]


def _cost_ns(text: str, vocabulary: Vocabulary) -> float:
    """Return what a text costs of the processor, were this the machine of the promise."""
    context = LineContext("", frozenset(vocabulary.profiles))
    costs: list[int] = []
    for _ in range(CONTRIVED_ROUNDS):
        began_ns = thread_time_ns()
        understand(text, vocabulary, context)
        costs.append(thread_time_ns() - began_ns)
    return median(costs) / pace_of_machine()


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
