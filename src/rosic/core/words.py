"""Sentences people read that are not a refusal and not a life."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rosic.core.order import Rest
    from rosic.core.robot import Presence, Profile
    from rosic.core.skill import Parameter, Skill

HELP = """Say what a robot should do, for example:
{examples}
Say stop at any time: whatever you may see, you may stop.
Also: status, use NAME (then its name may be left out), resume NAME (after a stop), help NAME."""

# The texts of the paper's Algorithm 7.
MAY_COMMAND = "You have permission to send and receive commands."
MAY_NOT_COMMAND = "You do not have permission to send and receive commands."
INFORMATION = "Here's the information you requested."
NO_INFORMATION = "You do not have permission to access this information."

NOTHING_VISIBLE = "There is no robot here for you yet. The admin of this place can change that."


def help_for_all(examples: Sequence[str]) -> str:
    """Return the general help, with examples from the robots this person may see."""
    return HELP.format(examples="\n".join(f"  {example}" for example in examples))


def help_for(profile: Profile) -> str:
    """Return what one robot can do."""
    lines = [f"{profile.shown} can:"]
    for skill in profile.skills.values():
        wanted = ", ".join(parameter_hint(n, p) for n, p in skill.parameters.items())
        lines.append(f"  {spoken(skill)}{': ' + wanted if wanted else ''}")
    return "\n".join(lines)


def spoken(skill: Skill) -> str:
    """Return a skill's name as people type it."""
    return skill.id.replace("_", " ")


def label(skill: Skill) -> str:
    """Return a skill's name as a button shows it."""
    return skill.title or spoken(skill).capitalize()


def parameter_hint(name: str, parameter: Parameter) -> str:
    """Return a parameter with its bounds: ``distance 0.01 to 5 m``."""
    if parameter.choices is not None:
        return f"{name} ({', '.join(parameter.choices)})"
    if parameter.text:
        return name
    unit = f" {parameter.unit}" if parameter.unit else ""
    hint = f"{name} {parameter.min:g} to {parameter.max:g}{unit}"
    return hint if parameter.default is None else f"{hint}, else {parameter.default:g}"


def status_line(
    profile: Profile, presence: Presence, *, holder: str, stopped_by: str | None, waiting: int
) -> str:
    """Return one robot's state in one line."""
    parts = [_link(presence)]
    if stopped_by is not None:
        parts.append(f"stopped by {stopped_by}" if stopped_by else "stopped")
    elif presence.doing:
        parts.append(f"doing {presence.doing.replace('_', ' ')}")
    elif presence.at_rest:
        parts.append("at rest")
    parts.append(f"taken by {holder}" if holder else "free")
    if waiting:
        parts.append(f"{waiting} waiting")
    parts.extend(_values(profile, presence.values))
    return f"{profile.shown}: " + " · ".join(part for part in parts if part)


def _link(presence: Presence) -> str:
    if presence.online is False:
        age = "" if presence.age_s is None else f", last heard {presence.age_s:.0f} s ago"
        return f"not there{age}"
    return "" if presence.online else "link not known"


def _values(profile: Profile, values: Mapping[str, float | str]) -> Iterable[str]:
    for name, described in profile.telemetry.items():
        value = values.get(name)
        if isinstance(value, str):
            yield f"{name} {value}"
        elif value is not None:
            shown = f"{value:.0f}" if described.unit == "%" else f"{value + 0.0:.2f}"
            yield f"{name} {shown} {described.unit}".rstrip()


def rests(profiles: Mapping[str, Profile], found: Iterable[Rest]) -> str:
    """Return the answer to a stop, once everything was measured or given up on."""
    confirmed: list[str] = []
    missing: list[str] = []
    for rest in found:
        shown = profiles[rest.robot].shown
        if rest.confirmed:
            confirmed.append(f"{shown} {rest.note or 'at rest'} ({rest.seconds:.2f} s).")
        else:
            missing.append(f"{shown} has not confirmed the stop. Use its own stop button.")
    return "STOP: " + " ".join([*missing, *confirmed])


def stopping(shown: Sequence[str]) -> str:
    """Return what is said while rest is being measured."""
    return f"STOP sent to {', '.join(shown)}."


def resumed(shown: Sequence[str]) -> str:
    """Return the answer to a resume."""
    return " ".join(f"{name} is ready again." for name in shown)


def unknown_after_restart(title: str) -> str:
    """Return what is said about an order whose end nobody saw."""
    return (
        f"{title}\nROSIC was interrupted. It may or may not have been carried out; please look. "
        "The robot stays stopped until someone who may resumes it."
    )


def said_again(text: str) -> str:
    """Mark an answer that may have been given before an interruption."""
    return f"{text}\n(Said again: ROSIC was restarted.)"
