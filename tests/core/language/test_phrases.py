"""Lines as people write them: what acts, what is proposed, and what is only answered."""

from __future__ import annotations

import random
import tomllib
from functools import cache
from itertools import chain
from typing import TYPE_CHECKING

import msgspec
import pytest

from rosic.app.features import command_table
from rosic.config.lexicons import SHIPPED, known_phrases, read_lexicon
from rosic.config.profiles import known_units, load_profile, shipped_profiles
from rosic.core.language import (
    Do,
    Help,
    LanguageReader,
    LineContext,
    Misunderstood,
    Proposed,
    Vocabulary,
    VocabularyHolder,
    understand,
)
from rosic.core.language.arguments import bind
from rosic.core.language.lexicon_compiler import compile_lexicons
from rosic.core.language.line_words import spoken_line, without_accents
from rosic.errors import Refusal
from tests.core.language.test_corpus import LANGUAGES, ROBOTS, VOCABULARY, acts, phrases, read

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.language.lexicon import Lexicon
    from rosic.core.robot.skill import Argument, Skill

ORDERS = (
    ("omni forward 1 m", "omni move forward 1 m"),
    ("go forward half a meter", "omni move forward 0.5 m"),
    ("turn omni right by 90 degrees", "omni turn right 90 deg"),
    ("omni vor 50 cm", "omni move forward 0.5 m"),
    ("mueve omni medio metro adelante", "omni move forward 0.5 m"),
    ("omni 前进一米", "omni move forward 1 m"),
    ("omni move -1 m", "omni move back 1 m"),
    ("land all drones", "crazyflies land"),
    ("kuka1 greif zu", "kuka1 grasp"),
    ("omni fünfundvierzig Grad nach links", "omni turn left 45 deg"),
    ("omni avance de vingt cinq centimètres", "omni move forward 0.25 m"),
    ("omni anderthalb Meter zurück", "omni move back 1.5 m"),
    ("omni dos metros y medio a la derecha", "omni move right 2.5 m"),
    ("omni un mètre cinquante à gauche", "omni move left 1.5 m"),
    ("omni 向左走两米半", "omni move left 2.5 m"),
    ("omni one point five metres back", "omni move back 1.5 m"),
    ("让2号无人机跟着1号无人机", "cf2 follow cf1"),
    ("setze omni bitte zwanzig Zentimeter zurück", "omni move back 0.2 m"),
)


@pytest.mark.parametrize(("text", "meant"), ORDERS)
def test_what_names_robot_skill_and_values_acts(text: str, meant: str) -> None:
    assert acts(text, "omni" if "omni" not in text and "go " in text else "") == acts(meant, "")


NO_ORDERS = (
    "omni a avance de 1 m",
    "omni esta 1 m a la izquierda",
    "omni esta 1 m a esquerda",
    "kuka a ferme la pince",
    "omni 1 m vor? ne lass mal",
    "omni forward 1 m?",
    'she said "omni forward 1 m"',
    "omni forward 1 m or 2 m",
    "omni forward 1 m xyzzy",
    "omni und kuka1 1 m vor",
    "omni nao avance 1 m",
    "omni forward 1 m left 2 m",
    "omni 1 m",
    "forward 1 m",
    # a denial in one language is a filler in another
    "omni no avança 1 m",
    "omni no recua 1 metro",
    "cf1 no decolar",
    # where somebody stands
    "omni 1 m links von mir",
    "omni 1 m left of me",
    "omni 1 m a la izquierda de mí",
    "omni 1 m to the left of the cube",
    # questions
    "omni move 1 m?",
    "kuka1 at home?",
    "omni move 1 m, right?",
    # a time of day, and not a value
    "kuka1 grasp at 8",
    "kuka1 greif um 10",
    "cf1 heb ab um 2",
    "omni move at 3",
    "omni move 1 m at 15:00",
    "in an hour omni move 1 m",
    "later, omni move 1 m",
    "morgen cf1 starten",
    # exceptions, and how often
    "all drones but cf2 land",
    "aterriza todos los drones menos cf1",
    "lande alle drohnen bis auf cf1",
    "omni dos veces 1 m adelante",
    # a choice that the robot has not
    "omni desce 1 m",
    "omni sube 1 m",
    # announcements, abilities, conditions, reports
    "omni gonna move 1 m",
    "omni puede avanzar 1 m",
    "cf1 vai decolar",
    "cf1 va décoller",
    "cf1 将起飞",
    "se cf1 pousar",
    "até cf1 pousar",
    "al aterrizar cf1",
    "beim landen von cf1",
    "if you can move omni 1 m",
    "alle drohnen starten gerade",
    # praise and things
    "omni back 1 m, well done",
    "kuka1 松开的东西",
    "the launch",
    "follow cf1 with cf2",
    # values that stand elsewhere
    "omni move 1 m once",
    "omni move 1 m and back",
    "omni turn half to the left",
)


def test_an_article_makes_a_thing_of_what_can_be_done() -> None:
    assert acts("launch", "cf1") == acts("cf1 takeoff", "")
    assert acts("the launch", "cf1") == []


MEANT = (
    ("omni move 1 m right, now", "omni move right 1 m"),
    ("omni turn 90 deg right, now", "omni turn right 90 deg"),
    ("omni turn 90 deg left right now", "omni turn left 90 deg"),
    ("omni back 1 m and a half", "omni move back 1.5 m"),
    ("OMNI GO BACK 2 METERS", "omni move back 2 m"),
    ("can you move omni 1 m?", "omni move 1 m"),
    ("fly cf1 to x=1, y=2, z=1", "cf1 goto x=1 y=2 z=1"),
    ("omni goto x=1,y=2", "omni goto x=1 y=2"),
    ("omni gira menos 90 grados", "omni turn right 90 deg"),
)


@pytest.mark.parametrize(("text", "meant"), MEANT)
def test_what_was_once_read_otherwise_is_read_as_it_is_meant(text: str, meant: str) -> None:
    assert acts(text, "") == acts(meant, "") != []


@pytest.mark.parametrize("text", NO_ORDERS)
def test_what_says_anything_else_does_not_act(text: str) -> None:
    assert acts(text, "") == []


def test_an_order_goes_on_being_what_was_typed() -> None:
    line = read("omni 50 cm vor", "")
    assert isinstance(line, Do)
    assert line.text == "omni 50 cm vor"
    assert line.named
    line = read("50 cm vor", "omni")
    assert isinstance(line, Do)
    assert not line.named


@pytest.mark.parametrize("text", ["kuka", "kuka?", "please kuka"])
def test_a_name_that_begins_a_longer_one_is_a_name_at_the_end_of_a_line(text: str) -> None:
    assert "kuka iiwa" in VOCABULARY.callees
    assert read(text, "") == Help("kuka1")


def test_what_is_overheard_is_talk_unless_it_is_a_line_of_the_grammar() -> None:
    everybody = frozenset(VOCABULARY.profiles)
    overheard = LineContext("omni", everybody, overheard=True)
    for text in ("50 cm vor", "omni 50 cm vor", "was kann omni?", "hallo", "ein bisschen vor"):
        [line] = understand(text, VOCABULARY, overheard)
        assert isinstance(line, Misunderstood), text
        assert not isinstance(line, Proposed), text
    [line] = understand("omni move 50 cm", VOCABULARY, overheard)
    assert isinstance(line, Do)


def test_a_robot_that_is_not_seen_is_no_robot() -> None:
    unseen = LineContext("", frozenset({"kuka1"}))
    for text in ("omni vor 50 cm", "drone 1 abheben", "alle Drohnen landen", "omin vor 50 cm"):
        [line] = understand(text, VOCABULARY, unseen)
        assert isinstance(line, Misunderstood)
        assert not any("omni" in offer or "cf" in offer for offer in line.offers)


# ---- what follows another order ----

FOLLOWING = (
    ("omni move forward 1 m", "again", "omni move forward 1 m 0.25 m/s"),
    ("omni move forward 1 m", "no, left", "omni move left 1 m 0.25 m/s"),
    ("omni move forward 1 m", "nein, links", "omni move left 1 m 0.25 m/s"),
    ("omni move left 2 m", "the same but 1 m", "omni move left 1 m 0.25 m/s"),
    ("omni move left 2 m speed=0.2", "faster", "omni move left 2 m 0.3 m/s"),
    ("omni move left 2 m speed=0.3", "langsamer", "omni move left 2 m 0.2 m/s"),
    ("omni move left 2 m speed=0.8", "faster", "omni move left 2 m 0.8 m/s"),
    ("omni move left 2 m", "the other way", "omni move right 2 m"),
    ("omni turn left 90 deg", "deshaz", "omni turn right 90 deg"),
    ("omni move left 1 m", "un peu plus", "omni move left 0.5 m"),
)


@pytest.mark.parametrize(("before", "text", "meant"), FOLLOWING)
def test_what_is_vague_follows_the_order_before_it(before: str, text: str, meant: str) -> None:
    last = read(before, "")
    assert isinstance(last, Do)
    reader = LanguageReader(VocabularyHolder(VOCABULARY))
    found = reader.following(text, last, frozenset(VOCABULARY.profiles))
    assert found, text
    assert acts(found[0], "") == acts(meant, ""), found


def test_what_undoes_a_skill_is_proposed_where_the_profile_says_so() -> None:
    takeoff = load_profile(shipped_profiles()["cf1"])
    skills = dict(takeoff.skills)
    skills["takeoff"] = msgspec.structs.replace(skills["takeoff"], reverse="land")
    vocabulary = Vocabulary.build(
        (msgspec.structs.replace(takeoff, skills=skills),),
        known_units(),
        command_table(),
        known_phrases(),
    )
    [last] = understand("cf1 takeoff", vocabulary, LineContext("", frozenset({"cf1"})))
    assert isinstance(last, Do)
    reader = LanguageReader(VocabularyHolder(vocabulary))
    assert reader.following("undo", last, frozenset({"cf1"})) == ("cf1 land",)


# ---- generated texts ----


@cache
def lexicons() -> Mapping[str, Lexicon]:
    return {code: read_lexicon(SHIPPED / code / "lexicon.toml") for code in LANGUAGES}


def words_of_everything() -> list[str]:
    """Return every phrase of every lexicon, of the profiles, and some that are none."""
    tables = [tomllib.loads((SHIPPED / code / "lexicon.toml").read_text()) for code in LANGUAGES]
    rows = (row for table in tables for rows in table.values() for row in rows.values())
    said = [phrase for row in rows if isinstance(row, list) for phrase in row]
    for robot in VOCABULARY.robots.values():
        said += [*robot.names, *robot.phrases]
    return [*said, "zzz", "=", "?", ",", ".", "x", "y", "cm", "m", "deg", "°", "m/s", "N"]


def padded(text: str) -> str:
    return f" {' '.join(spoken_line(text).words)} "


@cache
def choice_phrases() -> tuple[tuple[str, frozenset[str]], ...]:
    """Return what the files and the profiles have for choices, with what each stands for."""
    found = []
    for lexicon in lexicons().values():
        tables = (lexicon.choices, lexicon.combined, lexicon.skills)
        for meant, several in chain.from_iterable(table.items() for table in tables):
            parts = [part for phrase in several for part in phrase.split("…")]
            spoken = {padded(part) for part in (*parts, *map(without_accents, parts))}
            found += [(phrase, frozenset(meant.split())) for phrase in spoken]
    for robot in VOCABULARY.robots.values():
        for parameter in chain.from_iterable(skill.choices for skill in robot.skills.values()):
            for word, choice in (parameter.words or {}).items():
                found.append((padded(word), frozenset({choice})))
    return tuple(found)


@cache
def number_phrases() -> tuple[str, ...]:
    rows = chain.from_iterable(lexicon.numbers.values() for lexicon in lexicons().values())
    return tuple(padded(phrase) for row in rows for phrase in row)


def generated(seed: int, count: int) -> list[str]:
    draw = random.Random(seed)  # noqa: S311 - drawn anew from its seed
    vocabulary = words_of_everything()
    names = [name for robot in VOCABULARY.robots.values() for name in robot.names]
    found = []
    for _ in range(count):
        words = [draw.choice(vocabulary) for _ in range(draw.randint(0, 5))]
        words += [f"{draw.choice((1, 2, 30, 0.5, 90, 45))} {draw.choice(('m', 'cm', 'deg', ''))}"]
        words += [draw.choice(names)] * draw.randint(0, 1)
        draw.shuffle(words)
        found.append(" ".join(words))
    return found


def check_evidence(text: str, selected: str) -> bool:
    """See that robot, choices and numbers of an order stand in its words; whether it is one."""
    line = read(text, selected)
    if not isinstance(line, Do) or line.speech:
        return False
    robot = line.robots[0]
    compiled = VOCABULARY.compiled_skill(robot, line.skills[0].id)
    assert compiled is not None
    try:
        values: Mapping[str, Argument] = bind(VOCABULARY, robot, line.skills[0], line.spoken)
    except Refusal:
        return False
    assert line.named or line.name == selected or len(_able(line.skills[0])) == 1, text
    words = padded(text)
    said = {choice for phrase, meant in choice_phrases() if phrase in words for choice in meant}
    for parameter in compiled.parameters:
        value = values[parameter.name]
        if value == parameter.default:
            continue
        if parameter.words is not None:
            assert value in said or str(value) in text, (text, parameter.name, value)
        else:
            number = any(phrase in words for phrase in number_phrases())
            assert number or any(letter.isnumeric() for letter in text), text
    return True


def _able(skill: Skill) -> list[str]:
    return [name for name, profile in VOCABULARY.profiles.items() if skill.id in profile.skills]


def test_an_order_stands_in_the_words_that_were_said() -> None:
    texts = generated(seed=14, count=5_000)
    assert sum(check_evidence(text, "omni") for text in texts) > 5


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(20))
def test_many_orders_stand_in_the_words_that_were_said(seed: int) -> None:
    assert sum(check_evidence(text, "omni") for text in generated(seed, 10_000)) > 10


def test_a_proposal_is_a_line_of_the_grammar_that_does_what_it_says() -> None:
    for text in generated(seed=15, count=2_000):
        line = read(text, "omni")
        if isinstance(line, Proposed):
            for offer in line.offers:
                assert not isinstance(read(offer, ""), Misunderstood), (text, offer)
                for robot, skill, _ in acts(offer, ""):
                    spoken = VOCABULARY.robots[robot].skills[skill].spoken
                    assert spoken in offer, (text, offer)


# ---- languages beside each other ----


SECTIONS = ("skills", "choices", "units", "numbers", "verbs")


def with_a_word(draw: random.Random) -> tuple[str, dict[str, Lexicon]]:
    """Return the lexicons with a word of one language said in another for something else."""
    known = dict(lexicons())
    here, there = draw.sample(LANGUAGES, 2)
    source = getattr(known[there], draw.choice(SECTIONS))
    word = draw.choice([phrase for row in source.values() for phrase in row])
    section = draw.choice(SECTIONS)
    table = dict(getattr(known[here], section))
    meant = draw.choice(list(table))
    table[meant] = (*table[meant], word)
    known[here] = msgspec.structs.replace(known[here], **{section: table})
    return here, known


def check_beside_each_other(seed: int) -> bool:
    """See that a word in one language changes no order in another; whether it was let in."""
    here, known = with_a_word(random.Random(seed))  # noqa: S311 - drawn anew from its seed
    try:
        book = compile_lexicons(known)
    except ValueError:
        return False
    profiles = tuple(VOCABULARY.profiles[name] for name in ROBOTS)
    vocabulary = Vocabulary.build(profiles, known_units(), command_table(), book)
    everybody = frozenset(vocabulary.profiles)
    for language in LANGUAGES:
        for phrase in phrases(language):
            if phrase.label != "act" or language == here:
                continue
            [line] = understand(phrase.text, vocabulary, LineContext(phrase.selected, everybody))
            before = read(phrase.text, phrase.selected)
            if isinstance(line, Do) and isinstance(before, Do):
                assert (line.name, line.skills, line.spoken) == (
                    before.name,
                    before.skills,
                    before.spoken,
                ), (phrase, seed)
    return True


def test_a_word_in_one_language_changes_no_order_in_another() -> None:
    found = [check_beside_each_other(seed) for seed in range(4)]
    assert len(found) == 4


@pytest.mark.campaign
def test_no_word_in_any_language_changes_an_order_in_another() -> None:
    let_in = [check_beside_each_other(seed) for seed in range(300)]
    assert True in let_in
    assert False in let_in


def test_a_word_that_may_be_a_choice_leaves_none_to_a_default() -> None:
    line = read("omni 1 m weit bewegen xyzzy", "")
    assert isinstance(line, Proposed)
    assert line.offers == ("omni move forward 1 m", "omni move back 1 m", "omni move left 1 m")
