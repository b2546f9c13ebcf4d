"""What a skill takes, as JSON Schema: for programs, and for forms that are made from it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rosic.core.i18n import plain

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.robot.skill import Parameter, Skill


def schema_of(skill: Skill) -> dict[str, Any]:
    """Return the JSON Schema of the arguments of a skill, each in its declared unit."""
    return object_schema(
        {name: _property(parameter) for name, parameter in skill.parameters.items()},
        [name for name, parameter in skill.parameters.items() if parameter.default is None],
    )


def object_schema(properties: dict[str, Any], required: Sequence[str] = ()) -> dict[str, Any]:
    """Return the JSON Schema of an object that has these properties and no others."""
    return {
        "type": "object",
        "properties": properties,
        "required": list(required),
        "additionalProperties": False,
    }


def _property(parameter: Parameter) -> dict[str, Any]:
    if parameter.choices is not None:
        found: dict[str, Any] = {"type": "string", "enum": list(parameter.choices)}
        parts = []
    elif parameter.text:
        found, parts = {"type": "string", "minLength": 1}, ["One line of text."]
    else:
        kind: type[int | float] = int if parameter.integer else float
        found = {
            "type": "integer" if parameter.integer else "number",
            "minimum": kind(parameter.min or 0.0),
            "maximum": kind(parameter.max or 0.0),
        }
        unit = f"In {parameter.unit}, from" if parameter.unit else "From"
        parts = [f"{unit} {parameter.min:g} to {parameter.max:g}."]
    if parameter.default is not None:
        found["default"] = parameter.default
    title = plain(parameter.title) if parameter.title else ""
    about = " ".join(filter(None, (f"{title}." if title else "", *parts)))
    return {**found, "description": about} if about else found
