"""What a profile must keep besides types, forms and bounds: where its parts have to agree."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

from rosic.config.lexicons import known_phrases
from rosic.config.profile_fields import BOUNDS, FORMS, HIDDEN
from rosic.contracts.file_rules import Place, Rule, Rules, ValidationFinding, nearest
from rosic.core.alerts.rule import InvalidAlertRule, compile_rule, read_run, rules_of
from rosic.core.language import UnitTable, Vocabulary
from rosic.core.language.command import NO_COMMANDS
from rosic.core.policy.scope import AMONG, FILES, PLACES, READ, RESUME
from rosic.core.robot.benchmark import POSE
from rosic.core.robot.profile import Files, Profile, Telemetry
from rosic.core.robot.skill import Parameter, Skill

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence


# ---- profile skill validation ----

# What a profile must keep where choices stand for numbers and arms follow trajectories.

# ---- choices and trajectories ----


def meant(skill: Skill, place: Place, written: str) -> Iterator[ValidationFinding]:
    """See that ``$place.x`` is among what the choices of a parameter stand for.

    Args:
        skill: Whose parameter is there.
        place: Where it is written.
        written: Without the sign: ``place.x``, or the name alone.
    """
    name, dot, part = written.partition(".")
    means = skill.parameters[name].means
    known = next(iter(means.values()), {})
    if dot and part not in known:
        hint = nearest(part, known) or f"Say under 'means' of {name} what its choices stand for."
        yield ValidationFinding(
            place, f"${written}: the choices of {name} do not stand for '{part}'.", hint
        )
    elif means and not dot:
        hint = f"Write ${name}.{next(iter(known), 'x')}."
        yield ValidationFinding(place, f"${name} is a word; what it stands for has names.", hint)


# ---- expectations ----


def expected(profile: Profile) -> Iterator[ValidationFinding]:
    """See that a benchmark speaks of what there is."""
    for name, skill in profile.skills.items():
        benchmark = skill.benchmark
        if benchmark is None:
            continue
        place: Place = ("skills", name, "benchmark")
        if benchmark.energy is not None and benchmark.battery not in profile.telemetry:
            yield ValidationFinding(
                (*place, "energy"),
                "What it takes of its battery needs the telemetry of that.",
                nearest(benchmark.battery, profile.telemetry),
            )
        for parameter in benchmark.per_s:
            yield from _numeric(skill, (*place, "per_s", parameter), parameter)
        for key, bound in benchmark.errors.items():
            at: Place = (*place, "errors", key)
            if bound.measured in POSE and profile.pose is None:
                yield ValidationFinding(
                    (*at, "measured"), "Where it is needs the profile's 'pose'."
                )
            if isinstance(bound.wanted, str):
                yield from _wanted(skill, (*at, "wanted"), bound.wanted)


def _wanted(skill: Skill, place: Place, written: str) -> Iterator[ValidationFinding]:
    name, dot, part = written[1:].partition(".")
    if written[:1] != "$":
        yield ValidationFinding(
            place, f"{written!r} is neither a number nor a parameter.", "Write $name."
        )
    elif not dot:
        yield from _numeric(skill, place, name)
    elif name not in skill.parameters or any(
        not isinstance(meaning.get(part), float)
        for meaning in skill.parameters[name].means.values()
    ):
        yield ValidationFinding(place, f"{written} is no number that a choice stands for.")


def _numeric(skill: Skill, place: Place, name: str) -> Iterator[ValidationFinding]:
    parameter = skill.parameters.get(name)
    if parameter is None or parameter.choices is not None or parameter.text:
        yield ValidationFinding(
            place,
            f"{name!r} is not a number that this skill asks for.",
            nearest(name, skill.parameters),
        )


# ---- profile validation ----

# These words have a meaning for every robot, and are rights of their own.
RESERVED: Final = frozenset({READ, RESUME, FILES, PLACES, *AMONG, "stop"})
FLEET: Final = "fleet"
NO_STRATEGY: Final = frozenset({"back", "now", "idle"})


def profile_rules(units: UnitTable, own: Rules) -> Rules:
    """Return everything a profile is checked against.

    Args:
        units: The units that people may use.
        own: What the adapter asks of the keys of its own.
    """

    def parameter(made: Parameter) -> Iterator[ValidationFinding]:
        yield from _unit(made.unit, units)
        yield from _whole(made)

    def telemetry(made: Telemetry) -> Iterator[ValidationFinding]:
        yield from _unit(made.unit, units)
        if made.full != 1.0 and made.unit != "%":
            yield ValidationFinding(("full",), "'full' is of a share: it needs the unit %.")

    def words(made: Profile) -> Iterator[ValidationFinding]:
        fault = clash([made], units)
        if fault:
            yield ValidationFinding(_said_in(made, fault), fault, "Choose another word.")

    def alerts(made: Profile) -> Iterator[ValidationFinding]:
        yield from _alerts(made, units)

    checks: dict[type, tuple[Rule, ...]] = {
        Parameter: (parameter,),
        Telemetry: (telemetry,),
        Files: (_folders,),
        Skill: (_placeholders,),
        Profile: (_reserved, _located, _texts, _strategies, expected, words, alerts),
    }
    return Rules(
        bounds={**own.bounds, **BOUNDS},
        forms={**own.forms, **FORMS},
        hidden=HIDDEN | own.hidden,
        checks={
            asked: (*checks.get(asked, ()), *own.checks.get(asked, ()))
            for asked in {**checks, **own.checks}
        },
    )


def clash(profiles: Sequence[Profile], units: UnitTable) -> str:
    """Say why people could not speak to these robots; empty when they could."""
    try:
        Vocabulary.build(profiles, units, NO_COMMANDS, known_phrases())
    except ValueError as fault:
        sentence = str(fault).rstrip(".")
        return f"{sentence[:1].upper()}{sentence[1:]}."
    return ""


def _said_in(profile: Profile, sentence: str) -> Place:
    """Find the part of a profile whose name a sentence quotes."""
    quoted = {word.casefold() for word in re.findall(r"""["']([^"']+)["']""", sentence)}
    for key in ("words", "groups"):
        if quoted & {word.casefold() for word in getattr(profile, key)}:
            return (key,)
    # Of two that clash, the later one is easier to rename.
    for name, skill in reversed(list(profile.skills.items())):
        if quoted & {word.casefold() for word in skill.words}:
            return ("skills", name, "words")
        for parameter in skill.parameters:
            if quoted >= {name, parameter}:
                return ("skills", name, "parameters", parameter)
    return next((("skills", name) for name in profile.skills if name in quoted), ("id",))


def _unit(unit: str, units: UnitTable) -> Iterator[ValidationFinding]:
    if unit and units.find(unit) is None:
        close = nearest(unit, units.exact, say_all=False)
        yield ValidationFinding(("unit",), f"{unit!r} is not a unit ROSIC knows.", close)


def _whole(parameter: Parameter) -> Iterator[ValidationFinding]:
    for key in ("min", "max", "default"):
        value = getattr(parameter, key)
        if parameter.integer and isinstance(value, float) and not value.is_integer():
            yield ValidationFinding(
                (key,), f"'{key}' must be a whole number, as 'integer' is true."
            )


def _placeholders(skill: Skill) -> Iterator[ValidationFinding]:
    place, sent = skill.sent.place, skill.sent
    if not place:
        return
    written = {
        key: str(value)[1:] for key, value in sent.values.items() if str(value).startswith("$")
    }
    named = {key: name.partition(".")[0] for key, name in written.items()}
    unknown = {key: name for key, name in named.items() if name not in skill.parameters}
    for key, name in unknown.items():
        hint = nearest(name, skill.parameters) or "This skill has no parameters."
        yield ValidationFinding((*place, key), f"${name} is not a parameter of this skill.", hint)
    for key in () if unknown else named:
        yield from meant(skill, (*place, key), written[key])
    used = {*named.values(), *sent.besides}
    for name in () if unknown else skill.parameters:
        if name not in used:
            yield ValidationFinding(
                ("parameters", name),
                f"'{name}' is asked of people but never sent to the robot.",
                f"Write ${name} where it belongs under {'.'.join(map(str, place))}.",
            )


def _reserved(profile: Profile) -> Iterator[ValidationFinding]:
    if FLEET in (profile.id, *profile.groups):
        yield ValidationFinding(
            ("id",), f"'{FLEET}' cannot be a robot: it means all that is known of them."
        )
    for name in profile.skills:
        if name in RESERVED:
            yield ValidationFinding(
                ("skills", name), f"'{name}' cannot be a skill: it means the same for every robot."
            )


def _texts(profile: Profile) -> Iterator[ValidationFinding]:
    for name, skill in profile.skills.items():
        for key, parameter in skill.parameters.items():
            place: Place = ("skills", name, "parameters", key)
            if not parameter.text:
                continue
            if not profile.link.dialogue:
                yield ValidationFinding(
                    place,
                    "Free text goes to a robot only over its dialogue.",
                    "Set link.dialogue to true, or give choices instead of text.",
                )
            elif skill.sent.place:
                yield ValidationFinding(place, f"Free text never goes into {skill.sent.into}.")


def _located(profile: Profile) -> Iterator[ValidationFinding]:
    if bool(profile.go_to) != (profile.frame is not None):
        yield ValidationFinding(
            (), "To be sent to a place on Earth, a robot needs both frame and go_to."
        )
    if not profile.go_to:
        return
    name, *axes = profile.go_to.split()
    if name not in profile.skills:
        hint = nearest(name, profile.skills)
        yield ValidationFinding(("go_to",), f"{name!r} is not a skill of this robot.", hint)
        return
    parameters = profile.skills[name].parameters
    for axis in axes:
        if axis not in parameters or parameters[axis].unit != "m":
            yield ValidationFinding(("go_to",), f"{axis!r} is not a parameter of {name} in m.")
    for other, parameter in parameters.items():
        if other not in axes and parameter.default is None:
            yield ValidationFinding(
                ("go_to",), f"{name} also asks for {other}, which a place does not say."
            )


def _folders(files: Files) -> Iterator[ValidationFinding]:
    if bool(files.accept) != files.takes:
        yield ValidationFinding(
            (),
            "Files are taken with both: which kinds to accept, and an inbox or deliver.",
        )
    if files.inbox and files.inbox.rstrip("/") == files.outbox.rstrip("/"):
        yield ValidationFinding(("outbox",), "What the robot gives needs a folder of its own.")


def _strategies(profile: Profile) -> Iterator[ValidationFinding]:
    for name, strategy in profile.strategies.items():
        if name in NO_STRATEGY:
            yield ValidationFinding(
                ("strategies", name), f"'{name}' cannot be a strategy: it has a meaning already."
            )
        for key, parameter in strategy.parameters.items():
            if parameter.text:
                yield ValidationFinding(
                    ("strategies", name, "parameters", key),
                    "Free text goes to a robot only over its dialogue.",
                    "Give choices instead of text.",
                )


def _alerts(profile: Profile, units: UnitTable) -> Iterator[ValidationFinding]:
    if clash([profile], units):
        return
    yield from _low(profile, units)
    if not profile.alerts:
        return
    vocabulary = Vocabulary.build([profile], units, NO_COMMANDS)
    names: set[str] = set()
    for index, alert in enumerate(profile.alerts):
        if alert.name in names:
            yield ValidationFinding(
                ("alerts", index, "name"),
                f"Two rules are called {alert.name!r}.",
                "Tell them apart.",
            )
        names.add(alert.name)
        try:
            rule = compile_rule(profile, alert, units)
            if alert.run:
                read_run(rule, vocabulary)
        except InvalidAlertRule as wrong:
            sentence = str(wrong)
            yield ValidationFinding(
                ("alerts", index, wrong.key), f"{sentence[:1].upper()}{sentence[1:]}."
            )


def _low(profile: Profile, units: UnitTable) -> Iterator[ValidationFinding]:
    try:
        rules_of(replace(profile, alerts=()), units)
    except InvalidAlertRule as wrong:
        yield ValidationFinding(("telemetry",), f"An alarm cannot be made of alert_below: {wrong}.")
