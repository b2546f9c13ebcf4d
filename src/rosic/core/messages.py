"""Sentences people read that are not a refusal and not a life."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import capital, figure, filled, joined, said, said_n, titled
from rosic.core.language.common_names import known_name, shown_name
from rosic.core.language.sanitise import echo
from rosic.core.policy.scope import RESUME
from rosic.core.time_units import DAY_S, HOUR_S, MINUTE_S
from rosic.core.units import bound_in_words, measured

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from rosic.core.identity import PrincipalId
    from rosic.core.order import RestReport
    from rosic.core.robot.profile import Presence, Profile
    from rosic.core.robot.skill import Parameter, Skill

HELP = said("Say what a robot should do, for example:\n{examples}")
HELP_LOOK = said("You may look at robots here. What you lack, ask for: /ask")
HELP_STOP = said(
    "Say stop at any time: whatever you may see, you may stop. A robot's name alone shows its "
    "buttons."
)

# The texts of the paper's Algorithm 7.
MAY_COMMAND = said("You have permission to send and receive commands.")
MAY_NOT_COMMAND = said("You do not have permission to send and receive commands.")
MAY_COMMAND_LATER = said("You have permission to send commands, but not just now.")
INFORMATION = said("Here's the information you requested.")
NO_INFORMATION = said("You do not have permission to access this information.")

RESUME_SAID = said("resume")
REST_UNMEASURED = said("whether it rests is not measured")
NOTHING_VISIBLE = said(
    "There is no robot here for you yet. The admin of this place can change that."
)

NO_NUMBER: Final = said("not known, as the robot gives no number")
STALE_S = 10.0
"""What a robot reported so long ago, or longer, is told with its age."""

NAMED_AT_MOST = 50
"""A message that names more robots than this is read by nobody, and is sent in many parts."""


def no_robot(named: str) -> str:
    """Return that a name, as somebody typed it, means no robot."""
    return said("I know no robot called {name}.", name=echo(named))


def no_robot_or_group(named: str) -> str:
    """Return that a name, as somebody typed it, means no robot and no group."""
    return said("I know no robot and no group called {name}.", name=echo(named))


def help_for_all(examples: Sequence[str]) -> str:
    """Return the general help, with examples from the robots this person may see."""
    return filled(
        HELP, examples=joined("\n", (joined("", ("  ", example)) for example in examples))
    )


def help_for(profile: Profile, shown: str = "") -> str:
    """Return what one robot can do, or several that can do the same."""
    lines: list[str] = [said("{shown} can:", shown=shown or profile.shown)]
    for skill in profile.skills.values():
        wanted = joined(", ", (parameter_hint(n, p) for n, p in skill.parameters.items()))
        lines.append(joined("", ("  ", named(skill), joined("", (": ", wanted)) if wanted else "")))
    return joined("\n", lines)


def headed(shown: str, text: str) -> str:
    """Return a text with a robot's name before it, once: a sentence may begin with it already."""
    rest = text[len(shown) :]
    if text.startswith(shown) and not rest[:1].isalnum():
        return text
    return joined(": ", (shown, text))


def spoken(skill: Skill) -> str:
    """Return a skill's name as people type it."""
    return skill.id.replace("_", " ")


def named(skill: Skill) -> str:
    """Return a skill's name in a sentence: as it is typed, in a language it has a title in."""
    return titled(spoken(skill), skill.titles)


def named_of(profile: Profile, skill: str) -> str:
    """Return the name of one of a robot's skills in a sentence, by its id."""
    found = profile.skills.get(skill)
    if found is None and skill == RESUME:
        return RESUME_SAID
    return skill.replace("_", " ") if found is None or not found.titles else named(found)


def label(skill: Skill) -> str:
    """Return a skill's name as a button shows it."""
    return titled(skill.title or spoken(skill).capitalize(), skill.titles)


def button_label(skill: Skill) -> str:
    """Return a skill's name as its own button shows it, with its sign."""
    return joined(" ", (skill.icon, label(skill))) if skill.icon else label(skill)


def parameter_label(name: str, parameter: Parameter) -> str:
    """Return a parameter's name as a form shows it: its title, or the common name that it has."""
    title, common = parameter.title, known_name(name)
    if not title or (common is not name and title.casefold() == common and not parameter.titles):
        title = capital(shown_name(name))
    return titled(title, parameter.titles)


def parameter_hint(name: str, parameter: Parameter) -> str:
    """Return a parameter with its bounds: ``distance 0.01 to 5 m``."""
    if parameter.choices is not None:
        choices = joined(", ", map(shown_name, parameter.choices))
        return joined("", (shown_name(name), " (", choices, ")"))
    if parameter.text:
        return shown_name(name)
    least, most, unit = parameter.min or 0.0, parameter.max or 0.0, parameter.unit
    hint = said(
        "{name} {least} to {most}",
        name=shown_name(name),
        least=bound_in_words(least, unit, upper=False, with_unit=False),
        most=bound_in_words(most, unit, upper=True),
    )
    if not isinstance(parameter.default, int | float):
        return hint
    default = bound_in_words(parameter.default, unit, upper=True, with_unit=False)
    return said("{hint}, else {default}", hint=hint, default=default)


UNSTOPPABLE = said("cannot be stopped from here: stay beside it")


STILL_MOVES = said("STOP not confirmed: it moves")


BY_YOU: Final = said("you")


def by_whom(who: PrincipalId, reader: PrincipalId, name_of: Callable[[PrincipalId], str]) -> str:
    """Return who did something, as it stands behind "by"; empty: nobody, or nobody knows."""
    if not who:
        return ""
    return BY_YOU if who == reader else name_of(who)


def status_line(
    profile: Profile, presence: Presence, *, holder: str, stopped_by: str | None, waiting: int
) -> str:
    """Return one robot's state in one line."""
    parts = _state(profile, presence, holder, stopped_by)
    if profile.unstoppable:
        parts.append(UNSTOPPABLE)
    if waiting:
        parts.append(said("{waiting} waiting", waiting=waiting))
    parts.extend(_values(profile, presence))
    return joined(
        "", (joined("", (profile.shown, ": ")), joined(" · ", (part for part in parts if part)))
    )


def robot_line(profile: Profile, presence: Presence, holder: str, stopped_by: str | None) -> str:
    """Return one robot of a list: what it is called, what to say, and whether it can be had."""
    typed = profile.shown.casefold() == profile.id
    name = profile.shown if typed else said("{shown} ({id})", shown=profile.shown, id=profile.id)
    return joined(
        "", (name, ": ", joined(" · ", filter(None, _state(profile, presence, holder, stopped_by))))
    )


def _state(profile: Profile, presence: Presence, holder: str, stopped_by: str | None) -> list[str]:
    parts = [_link(presence)]
    if stopped_by is not None:
        parts.append(
            said("stopped by {stopped_by}", stopped_by=stopped_by)
            if stopped_by
            else said("stopped")
        )
        if presence.moves:
            parts.append(STILL_MOVES)
        elif presence.doubt:
            parts.append(unmeasured(presence))
    elif presence.doing:
        parts.append(said("doing {what}", what=named_of(profile, presence.doing)))
    elif presence.moves:
        parts.append(said("moves"))
    elif presence.at_rest:
        parts.append(said("at rest"))
    elif rest_unmeasured(profile, presence):
        parts.append(unmeasured(presence))
    return [*parts, _taken(holder)]


def _taken(holder: str) -> str:
    if holder is BY_YOU:  # not what somebody is called: in German it has another case here
        return said("taken by you")
    return said("taken by {holder}", holder=holder) if holder else said("free")


def rest_unmeasured(profile: Profile, presence: Presence) -> bool:
    """Tell whether a robot is heard, but not what shows whether it rests."""
    return profile.measures_rest and presence.online is True and presence.at_rest is None


def unmeasured(presence: Presence) -> str:
    """Return that rest is not measured, and why if that is known."""
    if not presence.doubt:
        return REST_UNMEASURED
    return said("whether it rests is not measured: {why}", why=presence.doubt)


def _link(presence: Presence) -> str:
    if presence.online is False:
        age = (
            ""
            if presence.age_s is None
            else said(", last heard {age_s:.0f} s ago", age_s=presence.age_s)
        )
        return said("not there{age}", age=age)
    return "" if presence.online else said("link not known")


def _values(profile: Profile, presence: Presence) -> Iterable[str]:
    for name, described in profile.telemetry.items():
        value = presence.values.get(name)
        text: str
        if name in presence.no_number:
            text = NO_NUMBER
        elif value is None:
            continue
        elif isinstance(value, str):
            text = value
        else:
            shown = f"{value:.0f}" if described.unit == "%" else f"{value:z.2f}"
            text = measured(f"{shown} {described.unit}".rstrip(), value, described.unit)
        reading, age_s = joined(" ", (shown_name(name), text)), presence.ages_s.get(name, 0.0)
        yield joined(", ", (reading, ago(age_s))) if age_s >= STALE_S else reading


def ago(seconds: float) -> str:
    """Return how long ago something was."""
    for length, unit in ((DAY_S, "d"), (HOUR_S, "h"), (MINUTE_S, "min")):
        if seconds >= length:
            return said("{seconds:.0f} {unit} ago", seconds=seconds // length, unit=unit)
    return said("{seconds:.0f} s ago", seconds=max(seconds, 0))


def rests(profiles: Mapping[str, Profile], found: Iterable[RestReport]) -> str:
    """Return the answer to a stop, once everything was measured or given up on."""
    rests = tuple(found)
    if len(rests) > NAMED_AT_MOST:
        return joined("", ("STOP: ", joined(" ", _counted(profiles, rests))))
    confirmed: list[str] = []
    missing: list[str] = []
    for rest in rests:
        shown = profiles[rest.robot].shown
        if rest.confirmed:
            took = figure(f"{rest.seconds:.2f} s")
            confirmed.append(
                joined("", (shown, " ", rest.note or said("at rest"), " (", took, ")."))
            )
        else:
            missing.append(_unconfirmed(shown))
    answers = [_own_stop(profiles[rest.robot].shown, rest) for rest in rests if _odd(rest)]
    return joined("", ("STOP: ", joined(" ", [*missing, *confirmed, *answers])))


def _counted(profiles: Mapping[str, Profile], rests: Sequence[RestReport]) -> Iterable[str]:
    """Yield the answer to a stop of more robots than can be named: those that matter by name."""
    missing = [rest for rest in rests if not rest.confirmed]
    yield from (_unconfirmed(profiles[rest.robot].shown) for rest in missing[:NAMED_AT_MOST])
    if len(missing) > NAMED_AT_MOST:
        yield said(
            "{count} more have not confirmed the stop. Use their own stop buttons.",
            count=len(missing) - NAMED_AT_MOST,
        )
    if len(missing) < len(rests):
        yield said(
            "{count} of {all} robots have confirmed that they are at rest, within {seconds:.2f} s.",
            count=len(rests) - len(missing),
            all=len(rests),
            seconds=max(rest.seconds for rest in rests if rest.confirmed),
        )


def _unconfirmed(shown: str) -> str:
    return said("{shown} has not confirmed the stop. Use its own stop button.", shown=shown)


def _odd(rest: RestReport) -> bool:
    """Tell whether something has to be said of its own stop; a robot not at rest is said enough."""
    return bool(rest.declined) or (rest.unanswered and rest.confirmed)


def _own_stop(shown: str, rest: RestReport) -> str:
    if not rest.declined:
        return said("{shown}'s own stop did not answer.", shown=shown)
    return said(
        "{shown}'s own stop answered that it failed: {words}.",
        shown=shown,
        words=rest.declined.rstrip("."),
    )


def _names(shown: Sequence[str]) -> str:
    if len(shown) > NAMED_AT_MOST:
        return said("{count} robots", count=len(shown))
    return ", ".join(shown)


def stopping(shown: Sequence[str]) -> str:
    """Return what is said while rest is being measured."""
    return said("STOP sent to {robots}.", robots=_names(shown))


def stopped_unseen(shown: Sequence[str]) -> str:
    """Return what a stop is answered with by a run that did not see it end."""
    return said(
        "STOP was sent to {robots}. ROSIC was interrupted before rest was seen; please look.",
        robots=_names(shown),
    )


def resumed(shown: Sequence[str]) -> str:
    """Return the answer to a resume."""
    if len(shown) > NAMED_AT_MOST:
        return said("{count} robots are ready again.", count=len(shown))
    return joined(" ", (said("{name} is ready again.", name=name) for name in shown))


def not_resumed_as_it_moves(shown: str) -> str:
    """Return why a stop is not undone yet."""
    return said(
        "{shown} still moves: its stop is not confirmed yet, and is applied again every second.",
        shown=shown,
    )


def not_resumed_in_doubt(shown: str) -> str:
    """Return why a stop is not undone of a robot that may still move, where nobody sees it."""
    return said("{shown} is not there; its stop was never confirmed.", shown=shown)


def at_rest_now(shown: str) -> str:
    """Return what is said once a stop was confirmed later than its answer."""
    return said("{shown} is at rest now.", shown=shown)


def still_stopped(shown: Sequence[str]) -> str:
    """Return what is said of robots that a resume did not come to, "" if there are none."""
    if len(shown) > NAMED_AT_MOST:
        return said("{count} robots are still stopped.", count=len(shown))
    return said("Still stopped: {names}.", names=joined(", ", shown)) if shown else ""


def unknown_after_restart(title: str) -> str:
    """Return what is said about an order whose end nobody saw."""
    interrupted = said(
        "ROSIC was interrupted. It may or may not have been carried out; please look. "
        "The robot stays stopped until someone who may resumes it."
    )
    return joined("\n", (title, interrupted))


def said_again(text: str) -> str:
    """Mark an answer that may have been given before an interruption."""
    return joined("\n", (text, said("(Said again: ROSIC was restarted.)")))


def perhaps_twice(text: str) -> str:
    """Mark what may have arrived before, though nobody can know."""
    return joined("\n", (text, said("(This may stand here twice: the connection broke.)")))


def left_out(count: int) -> str:
    """Say that answers to somebody gave way to newer ones."""
    return said_n(
        "({n} earlier answer to you was left out: too much waited to be said here.)",
        "({n} earlier answers to you were left out: too much waited to be said here.)",
        count,
    )
