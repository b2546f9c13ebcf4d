"""What is wrong with roles, grants and care, in one clear sentence each.

Whoever reads a file or takes a change asks here first and changes nothing while there is a
mistake. `rosic.core.policy.permissions` never fails on one: what is not understood gives nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from rosic.core.i18n import capital, joined, said
from rosic.core.language.suggestions import did_you_mean
from rosic.core.policy.limits import LimitMismatch, LimitRule, fit_limits, parse_limit
from rosic.core.policy.roles import ASSURANCES, DEEPEST, chains, loops
from rosic.core.policy.scope import FLEET, NO_SKILLS, RESUME, Scope, words_given, words_meant
from rosic.core.rate_limit import parse_rate

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rosic.core.policy.limits import Convert
    from rosic.core.policy.roles import Grant, Role, RoleRules, SkillPrecondition
    from rosic.core.policy.scope import Fleet
    from rosic.core.robot.profile import RobotId

Place: TypeAlias = tuple[str | int, ...]


class RoleMistake(NamedTuple):
    """One thing that is wrong.

    Attributes:
        place: Keys and indices from the rulebook or the grant down to it.
        sentence: For whoever wrote it.
        hint: What to do about it; may be empty.
    """

    place: Place
    sentence: str
    hint: str = ""


def rulebook_mistakes(rulebook: RoleRules, fleet: Fleet, convert: Convert) -> list[RoleMistake]:
    """Return everything that is wrong with roles, care and pre-emption."""
    found: list[RoleMistake] = []
    for name, role in rulebook.roles.items():
        found += _role(name, role, rulebook.roles, fleet, convert)
    for loop in loops(rulebook.roles):
        found.append(
            RoleMistake(
                ("role", loop[0], "includes"),
                said(
                    "The role {role} includes itself: {loop}.",
                    role=loop[0],
                    loop=joined(said(" includes "), loop),
                ),
                said("Take one of these includes out."),
            )
        )
    for index, care in enumerate(rulebook.care):
        found += _care(("care", index), care, fleet)
    for index, whom in enumerate(rulebook.preempt):
        found += _robots(("preempt", index), whom, fleet)
    return found


def grant_mistakes(
    grant: Grant, rulebook: RoleRules, fleet: Fleet, convert: Convert
) -> list[RoleMistake]:
    """Return everything that is wrong with one grant."""
    found: list[RoleMistake] = []
    if not grant.role and not grant.scopes:
        found.append(RoleMistake((), said("This gives nothing."), said("Name a role, or scopes.")))
    if grant.role and grant.role not in rulebook.roles:
        found.append(_unknown_role(("role",), grant.role, rulebook.roles))
    for index, text in enumerate(grant.scopes):
        found += _scope(("scopes", index), text, fleet)
    for index, whom in enumerate(grant.robots):
        found += _robots(("robots", index), whom, fleet)
    if found:
        return found
    given = dict(_given(_scopes_of(grant.role, grant.scopes, rulebook.roles), fleet))
    if grant.robots:
        only = {robot for whom in grant.robots for robot in fleet.robots(whom)}
        given = {robot: words for robot, words in given.items() if robot in only}
        if not given:
            where = ", ".join(grant.robots)
            nothing = said(
                "The role {role} gives nothing on {where}.", role=grant.role, where=where
            )
            found.append(RoleMistake(("robots",), nothing))
    return found + list(_limits(grant.limits, given, fleet, convert))


def given_by(rulebook: RoleRules, role: str, fleet: Fleet) -> dict[RobotId, frozenset[str]]:
    """Return what a role gives with everything it includes, without limits."""
    return dict(_given(_scopes_of(role, (), rulebook.roles), fleet))


def _role(
    name: str, role: Role, roles: Mapping[str, Role], fleet: Fleet, convert: Convert
) -> Iterator[RoleMistake]:
    here: Place = ("role", name)
    for index, inner in enumerate(role.includes):
        if inner not in roles:
            yield _unknown_role((*here, "includes", index), inner, roles)
    if any(len(chain.via) >= DEEPEST and chain.last.includes for chain in chains(roles, name)):
        yield RoleMistake(
            (*here, "includes"),
            said("The role {name} includes roles more than {n} deep.", name=name, n=DEEPEST),
            said("Include the inner ones directly."),
        )
    for index, text in enumerate(role.scopes):
        yield from _scope((*here, "scopes", index), text, fleet)
    if not role.scopes and not role.includes:
        nothing = said("The role {name} gives nothing.", name=name)
        yield RoleMistake(here, nothing, said("Give it scopes, or includes."))
    yield from _assurance((*here, "assurance"), role.assurance)
    yield from _rate((*here, "rate"), role.rate)
    given = dict(_given(_scopes_of(name, (), roles), fleet))
    for mistake in _limits(role.limits, given, fleet, convert):
        yield mistake._replace(place=(*here, *mistake.place))


def _care(here: Place, care: SkillPrecondition, fleet: Fleet) -> Iterator[RoleMistake]:
    if not care.needs and not care.assurance:
        hint = said("Set confirm, step_up or second_person.")
        yield RoleMistake(here, said("This asks for nothing."), hint)
    for index, text in enumerate(care.scopes):
        place = (*here, "scopes", index)
        mistakes = list(_scope(place, text, fleet))
        yield from mistakes
        if not mistakes:
            scope = Scope.parse(text)
            if not any(words_meant(scope, r, fleet) for r in fleet.robots(scope.robot)):
                yield RoleMistake(
                    place,
                    said("{text!r} touches no skill.", text=text),
                    said("A wildcard stands for a robot's own skills alone."),
                )
            else:
                yield from _never_asked(place, text, care)
    yield from _assurance((*here, "assurance"), care.assurance)


def _never_asked(place: Place, text: str, care: SkillPrecondition) -> Iterator[RoleMistake]:
    """Find what no part of the gateway would ask for: it would read as if it protected (I18)."""
    scope = Scope.parse(text)
    if scope.robot != FLEET and scope.skill not in NO_SKILLS:
        return
    hint = said(
        "Name a robot's skills; besides them only resume is asked about, for its assurance alone."
    )
    if care.needs:
        alone = said(
            "{text!r} is no skill: confirm, step_up and second_person are asked for skills alone.",
            text=text,
        )
        yield RoleMistake(place, alone, hint)
    elif scope.robot == FLEET or scope.skill != RESUME:
        few = said(
            "{text!r} is no skill: an assurance is asked for skills and resume alone.", text=text
        )
        yield RoleMistake(place, few, hint)


def _unknown_role(place: Place, role: str, roles: Iterable[str]) -> RoleMistake:
    unknown = said("No role is called {role!r}.", role=role)
    return RoleMistake(place, unknown, _nearest(role, roles))


def _assurance(place: Place, named: str) -> Iterator[RoleMistake]:
    if named and named not in ASSURANCES:
        yield RoleMistake(
            place,
            said("{named!r} is no assurance of a channel.", named=named),
            said("Known: {names}.", names=", ".join(ASSURANCES)),
        )


def _rate(place: Place, text: str) -> Iterator[RoleMistake]:
    try:
        if text:
            parse_rate(text)
    except ValueError as fault:
        yield RoleMistake(place, _ended(fault))


def _ended(fault: ValueError) -> str:
    """Return what is wrong as a sentence."""
    return joined("", (fault.args[0], "."))


def _robots(place: Place, whom: str, fleet: Fleet) -> Iterator[RoleMistake]:
    if fleet.robots(whom):
        return
    if "*" in whom or "?" in whom:
        none = said("No robot matches {whom!r}.", whom=whom)
        yield RoleMistake(place, none, _known(fleet.skills))
    else:
        known = (*fleet.skills, *fleet.groups)
        unknown = said("No robot or group is called {whom!r}.", whom=whom)
        yield RoleMistake(place, unknown, _nearest(whom, known))


def _scope(place: Place, text: str, fleet: Fleet) -> Iterator[RoleMistake]:
    try:
        scope = Scope.parse(text)
    except ValueError as fault:
        yield RoleMistake(place, _ended(fault))
        return
    mistakes = list(_robots(place, scope.robot, fleet))
    yield from mistakes
    robots = fleet.robots(scope.robot)
    if not mistakes and not any(words_given(scope, robot, fleet) for robot in robots):
        words = sorted({word for robot in robots for word in fleet.words(robot)})
        if len(robots) == 1:
            none = said("{robot} has no skill {skill!r}.", robot=robots[0], skill=scope.skill)
        else:
            none = said(
                "No robot of {robots!r} has a skill {skill!r}.",
                robots=scope.robot,
                skill=scope.skill,
            )
        yield RoleMistake(place, none, _nearest(scope.skill, words))


def _scopes_of(role: str, bare: Iterable[str], roles: Mapping[str, Role]) -> Iterator[Scope]:
    texts = [text for chain in chains(roles, role) for text in chain.last.scopes]
    for text in (*texts, *bare):
        try:
            yield Scope.parse(text)
        except ValueError:  # said elsewhere
            continue


def _given(scopes: Iterable[Scope], fleet: Fleet) -> Iterator[tuple[RobotId, frozenset[str]]]:
    """Return what scopes give together, without limits."""
    all_of_them = list(scopes)
    for robot in (*fleet.skills, FLEET):
        words = frozenset[str]().union(*(words_given(scope, robot, fleet) for scope in all_of_them))
        if words:
            yield robot, words


def _limits(
    texts: Iterable[str],
    given: Mapping[RobotId, frozenset[str]],
    fleet: Fleet,
    convert: Convert,
) -> Iterator[RoleMistake]:
    """Find limits that cannot be read, touch nothing, or do not fit what they touch."""
    rules: list[LimitRule] = []
    for index, text in enumerate(texts):
        place: Place = ("limits", index)
        try:
            rule = parse_limit(text)
        except ValueError as fault:
            yield RoleMistake(place, _ended(fault))
            continue
        sentence = _misfit([rule], given, fleet, convert) or _idle(rule, given, fleet)
        if sentence:
            shown = capital(joined("", (sentence, ".")))
            yield RoleMistake(place, shown, _near_parameter(rule, given, fleet))
        else:
            rules.append(rule)
    together = _misfit(rules, given, fleet, convert)
    if together:
        yield RoleMistake(("limits",), capital(joined("", (together, "."))))


def _misfit(
    rules: list[LimitRule],
    given: Mapping[RobotId, frozenset[str]],
    fleet: Fleet,
    convert: Convert,
) -> str:
    """Return why limits do not fit the first skill that they do not fit; empty if they do."""
    for robot, words in given.items():
        for word in sorted(words & fleet.skills.get(robot, {}).keys()):
            touching = [r for r in rules if _touches(r, robot, word, fleet)]
            try:
                fit_limits(touching, word, fleet.skills[robot][word], convert)
            except LimitMismatch as fault:
                return said("on {robot}, {fault}", robot=robot, fault=fault.args[0])
    return ""


def _idle(rule: LimitRule, given: Mapping[RobotId, frozenset[str]], fleet: Fleet) -> str:
    """Return why a limit limits nothing; empty if it does."""
    for robot, words in given.items():
        for word in words & fleet.skills.get(robot, {}).keys():
            skill = fleet.skills[robot][word]
            if rule.parameter in skill.parameters and _touches(rule, robot, word, fleet):
                return ""
    return said(
        "no skill given here has a parameter {parameter!r}, so {limit!r} limits nothing",
        parameter=rule.parameter,
        limit=rule.said,
    )


def _touches(rule: LimitRule, robot: RobotId, word: str, fleet: Fleet) -> bool:
    return rule.scope is None or word in words_given(rule.scope, robot, fleet)


def _near_parameter(rule: LimitRule, given: Mapping[RobotId, frozenset[str]], fleet: Fleet) -> str:
    known = {
        name
        for robot, words in given.items()
        for word in words & fleet.skills.get(robot, {}).keys()
        for name in fleet.skills[robot][word].parameters
    }
    return "" if rule.parameter in known else _nearest(rule.parameter, sorted(known))


def _nearest(word: str, known: Iterable[str]) -> str:
    names = list(known)
    close = did_you_mean(word, names)
    return said("Did you mean {close}?", close=close[0]) if close else _known(names)


def _known(names: Iterable[str]) -> str:
    listed = sorted(names)
    return said("Known here: {names}.", names=", ".join(listed)) if listed else ""
