"""The published JSON Schemas of profiles, missions, the configuration, and what robots say.

``python -m rosic.config.json_schema FOLDER`` writes them. Editors check and complete with them
while a file is written; ROSIC itself checks more, and says it better.
"""

from __future__ import annotations

import json
import re
import sys
from inspect import cleandoc
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from rosic.config.gateway_file import BOUNDS as CONFIG_BOUNDS
from rosic.config.gateway_file import FORMS as CONFIG_FORMS
from rosic.config.gateway_file import ConfigFile
from rosic.config.missions import MISSION_BOUNDS, MISSION_FORMS
from rosic.config.profile_fields import BOUNDS, FORMS, HIDDEN
from rosic.core.fleet.mission import Mission
from rosic.core.robot.dialogue_protocol import Utterance
from rosic.core.robot.profile import Profile

if TYPE_CHECKING:
    from rosic.contracts.file_rules import FieldForm, NumberBounds

DIALECT = "https://json-schema.org/draft/2020-12/schema"

# A value that stands elsewhere, allowed for every setting of a messenger.
REFERENCE = {
    "description": "A secret that stands elsewhere.",
    "type": "object",
    "properties": {"env": {"type": "string"}, "file": {"type": "string"}},
    "minProperties": 1,
    "maxProperties": 1,
    "additionalProperties": False,
}
MESSENGER = {
    "description": "An account on a messenger; besides kind and name, what its adapter asks for.",
    "type": "object",
    "properties": {
        "kind": {"type": "string", "minLength": 1, "description": "Name of a messenger adapter."},
        "name": {"type": "string", "minLength": 1, "description": "Unique in the file."},
    },
    "required": ["kind"],
    "additionalProperties": {
        "anyOf": [
            {"$ref": "#/$defs/Reference"},
            {"type": ["string", "number", "boolean", "array", "object"]},
        ],
    },
}

# Fields whose name in the file is a word of Python's.
_RENAMED = {"kind": "class", "lasting": "for", "author": "as", "values": "with"}

_ENTRY = re.compile(r"^    (?P<names>\w+(?:, \w+)*): (?P<text>.+(?:\n {5,}.+)*)", re.MULTILINE)


def robot_schema() -> dict[str, Any]:
    """Return the schema of a profile."""
    return _schema(Profile, "A robot for ROSIC")


def config_schema() -> dict[str, Any]:
    """Return the schema of the configuration file."""
    schema = _schema(ConfigFile, "ROSIC's configuration")
    schema["properties"]["messenger"]["items"] = MESSENGER
    schema["$defs"]["Reference"] = REFERENCE
    return schema


def mission_schema() -> dict[str, Any]:
    """Return the schema of a mission."""
    return _schema(Mission, "A mission for ROSIC")


def among_schema() -> dict[str, Any]:
    """Return the schema of what a robot's nodes say to other robots."""
    ((top,), made) = msgspec.json.schema_components((Utterance,), ref_template="#/$defs/{name}")
    _describe(made)
    return {
        "$schema": DIALECT,
        **top,
        "title": "What a robot says through ROSIC",
        "$defs": dict(sorted(made.items())),
    }


def _schema(top: type, title: str) -> dict[str, Any]:
    (_, made) = msgspec.json.schema_components((top,), ref_template="#/$defs/{name}")
    for name, part in made.items():
        if "properties" in part:
            _refine(name, part)
    _describe(made)
    schema = made.pop(top.__name__)
    return {"$schema": DIALECT, **schema, "title": title, "$defs": dict(sorted(made.items()))}


def _refine(name: str, part: dict[str, Any]) -> None:
    for (owner, field), bounds in {**BOUNDS, **CONFIG_BOUNDS, **MISSION_BOUNDS}.items():
        if owner.__name__ == name:
            _bound(part["properties"][_key(owner, field)], bounds)
    for (owner, field), form in {**FORMS, **CONFIG_FORMS, **MISSION_FORMS}.items():
        if owner.__name__ == name:
            _shape(part["properties"][_key(owner, field)], form)
    for owner, field in HIDDEN:
        if owner.__name__ == name:
            del part["properties"][_key(owner, field)]
    for described in part["properties"].values():
        _without_null(described)


def _key(owner: type, field: str) -> str:
    """Return what a field is called in the file."""
    return next(f.encode_name for f in msgspec.structs.fields(owner) if f.name == field)


def _without_null(described: dict[str, Any]) -> None:
    """Take null away: a key that says nothing is left out."""
    choices = [one for one in described.get("anyOf", ()) if one != {"type": "null"}]
    if described.get("default", "") is None:
        del described["default"]
    if not choices:
        return
    del described["anyOf"]
    described.update(choices[0] if len(choices) == 1 else {"anyOf": choices})


def _bound(described: dict[str, Any], bounds: NumberBounds) -> None:
    number = next((one for one in described.get("anyOf", ()) if "type" in one), described)
    number["minimum"], number["maximum"] = bounds


def _shape(described: dict[str, Any], form: FieldForm) -> None:
    text = {"pattern": f"^(?:{form.pattern})$" if not form.empty else f"^(?:{form.pattern})?$"}
    described["description"] = f"{form.meaning[:1].upper()}{form.meaning[1:]}. {form.hint}"
    kinds = [described, *described.get("anyOf", ())]
    for kind in kinds:
        if kind.get("type") == "string":
            kind.update(text)
        elif kind.get("type") == "array":
            kind["items"].update(text)
        elif kind.get("type") == "object":
            kind["propertyNames"] = text


def _describe(parts: dict[str, Any]) -> None:
    """Take the descriptions out of the docstrings, attribute by attribute."""
    for part in parts.values():
        # Python 3.13 takes the indentation out of docstrings; earlier ones leave it in.
        summary, _, rest = cleandoc(part.get("description", "")).partition("\n\n")
        listed = rest.partition("Attributes:\n")[2]
        if summary:
            part["description"] = _plain(summary)
        for entry in _ENTRY.finditer(listed):
            for name in entry["names"].split(", "):
                properties = part.get("properties", {})
                described = properties.get(name, properties.get(_RENAMED.get(name, "")))
                if described is not None:
                    described["description"] = _plain(entry["text"])


def _plain(text: str) -> str:
    return re.sub(r"\s+", " ", text.replace("``", "")).strip()


def render(schema: dict[str, Any]) -> str:
    """Return a schema as it is published."""
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


def published() -> dict[str, str]:
    """Return every schema by the name of its file."""
    return {
        "among.schema.json": render(among_schema()),
        "mission.schema.json": render(mission_schema()),
        "robot.schema.json": render(robot_schema()),
        "rosic.schema.json": render(config_schema()),
    }


def main(folder: Path) -> None:
    """Write the schemas into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in published().items():
        (folder / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "docs/schema"))
