"""The published JSON Schemas of profiles, missions, the configuration, and what robots say.

``python -m rosic.config.json_schema FOLDER`` writes them. Editors check and complete with them
while a file is written; ROSIC itself checks more, and says it better.
"""

from __future__ import annotations

import json
import re
import sys
from collections import Counter
from inspect import cleandoc
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
from msgspec import inspect

from rosic.config.gateway_file import BOUNDS as CONFIG_BOUNDS
from rosic.config.gateway_file import FORMS as CONFIG_FORMS
from rosic.config.gateway_file import ConfigFile
from rosic.config.missions import MISSION_BOUNDS, MISSION_FORMS
from rosic.config.plugins import profile_schema, robot_kinds
from rosic.config.profile_fields import BOUNDS, FORMS, HIDDEN
from rosic.config.validation import asked_of, opaque_fields
from rosic.contracts.adapter import EVERY_ROBOT
from rosic.core.fleet.mission import Mission
from rosic.core.robot.dialogue_protocol import Utterance

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.contracts.adapter import ProfileSchema
    from rosic.contracts.file_rules import FieldForm, NumberBounds, Rules
    from rosic.core.robot.profile import Profile

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

ROBOT_TITLE = "A robot for ROSIC"
ALL_BOUNDS = {**BOUNDS, **CONFIG_BOUNDS, **MISSION_BOUNDS}
ALL_FORMS = {**FORMS, **CONFIG_FORMS, **MISSION_FORMS}
_REF = "#/$defs/{name}"

# Fields whose name in the file is a word of Python's.
_RENAMED = {"kind": "class", "lasting": "for", "author": "as", "values": "with"}

_ENTRY = re.compile(r"^    (?P<names>\w+(?:, \w+)*): (?P<text>.+(?:\n {5,}.+)*)", re.MULTILINE)


# In core's order of the keys, those of a link's own follow this one.
_OWN_AFTER = {"Link": "kind", "Profile": "unstoppable", "Skill": "cost", "Telemetry": ""}


def robot_schema(kinds: Iterable[str]) -> dict[str, Any]:
    """Return the schema of a profile, of robot links of these kinds.

    Kinds whose profiles have the same form share it. Where there are several forms, the kind that
    a profile names decides.
    """
    forms: dict[type[Profile], tuple[ProfileSchema, list[str]]] = {}
    for kind in kinds:
        schema = profile_schema(kind)
        if schema is not None:
            forms.setdefault(schema.profile, (schema, []))[1].append(kind)
    made = [
        (_schema(top, ROBOT_TITLE, schema.rules), kinds) for top, (schema, kinds) in forms.items()
    ]
    return made[0][0] if len(made) == 1 else _by_kind(made)


def _by_kind(made: list[tuple[dict[str, Any], list[str]]]) -> dict[str, Any]:
    parts: dict[str, Any] = {}
    choices = []
    for schema, kinds in made:
        of_kind = f"{kinds[0]}.{{}}".format
        for name, part in schema.pop("$defs").items():
            parts[of_kind(name)] = _renamed(part, of_kind)
        del schema["$schema"]
        whole = of_kind("Profile")
        parts[whole] = _renamed(schema, of_kind)
        named = {"properties": {"kind": {"enum": kinds}}, "required": ["kind"]}
        choices.append(
            {
                "if": {"properties": {"link": named}, "required": ["link"]},
                "then": {"$ref": f"#/$defs/{whole}"},
            }
        )
    return {
        "$schema": DIALECT,
        "title": ROBOT_TITLE,
        "type": "object",
        "required": ["id", "link"],
        "allOf": choices,
        "$defs": dict(sorted(parts.items())),
    }


def config_schema() -> dict[str, Any]:
    """Return the schema of the configuration file."""
    schema = _schema(ConfigFile, "ROSIC's configuration")
    schema["properties"]["messenger"]["items"] = MESSENGER
    key = schema["$defs"]["LanguageTable"]["properties"]["key"]
    key["anyOf"] = [{"$ref": "#/$defs/Reference"}, {"type": "string"}]
    schema["$defs"]["Reference"] = REFERENCE
    return schema


def mission_schema() -> dict[str, Any]:
    """Return the schema of a mission."""
    return _schema(Mission, "A mission for ROSIC")


def among_schema() -> dict[str, Any]:
    """Return the schema of what a robot's nodes say to other robots."""
    ((top,), made) = msgspec.json.schema_components((Utterance,), ref_template=_REF)
    _describe(made, {})
    return {
        "$schema": DIALECT,
        **top,
        "title": "What a robot says through ROSIC",
        "$defs": dict(sorted(made.items())),
    }


def _schema(top: type, title: str, rules: Rules = EVERY_ROBOT.rules) -> dict[str, Any]:
    (_, made) = msgspec.json.schema_components((top,), ref_template=_REF, schema_hook=_opaque)
    classes = _structs(inspect.type_info(top))
    for name, cls in classes.items():
        _refine(cls, made[name], rules)
    _describe(made, classes)
    names = _names(classes)
    parts = {names.get(name, name): _renamed(part, names.get) for name, part in made.items()}
    schema = parts.pop(names.get(top.__name__, top.__name__))
    return {"$schema": DIALECT, **schema, "title": title, "$defs": dict(sorted(parts.items()))}


def _opaque(_: type) -> dict[str, Any]:
    """Return the schema of what only the adapter of a link could know; its key is taken out."""
    return {"not": {}}


def _structs(kind: inspect.Type) -> dict[str, type]:
    """Return every class that stands in a type, by its name."""
    found: dict[str, type] = {}
    waiting = [kind]
    while waiting:
        one = waiting.pop()
        if isinstance(one, inspect.StructType):
            if one.cls.__name__ not in found:
                found[one.cls.__name__] = one.cls
                waiting += [field.type for field in one.fields]
        elif isinstance(one, inspect.UnionType):
            waiting += one.types
        elif isinstance(one, inspect.DictType):
            waiting.append(one.value_type)
        elif isinstance(one, inspect.ListType | inspect.VarTupleType):
            waiting.append(one.item_type)
    return found


def _lineage(cls: type) -> list[type]:
    """Return the classes that one is derived from and itself, the oldest first."""
    return [one for one in reversed(cls.__mro__) if msgspec.Struct in one.__mro__[1:]]


def _names(classes: dict[str, type]) -> dict[str, str]:
    """Return what each part is called: an adapter's as the one of core's that it is made from."""
    oldest = {name: _lineage(cls)[0].__name__ for name, cls in classes.items()}
    many = Counter(oldest.values())
    return {name: old if many[old] == 1 else name for name, old in oldest.items()}


def _renamed(part: Any, name_of: Callable[[str], str | None]) -> Any:  # noqa: ANN401 - JSON
    """Return a part of a schema with other names for what it refers to."""
    if isinstance(part, list):
        return [_renamed(one, name_of) for one in part]
    if not isinstance(part, dict):
        return part
    made = {key: _renamed(one, name_of) for key, one in part.items()}
    if isinstance(made.get("$ref"), str):
        name = made["$ref"].rpartition("/")[2]
        made["$ref"] = _REF.format(name=name_of(name) or name)
    if isinstance(made.get("title"), str) and "properties" in made:
        made["title"] = name_of(made["title"]) or made["title"]
    return made


def _refine(cls: type, part: dict[str, Any], rules: Rules) -> None:
    properties = part["properties"]
    for field in msgspec.structs.fields(cls):
        described = properties[field.encode_name]
        bounds = asked_of(cls, field.name, {**rules.bounds, **ALL_BOUNDS})
        form = asked_of(cls, field.name, {**rules.forms, **ALL_FORMS})
        if bounds is not None:
            _bound(described, bounds)
        if form is not None:
            _shape(described, form)
        hidden = any((one, field.name) in HIDDEN | rules.hidden for one in _lineage(cls))
        if hidden or field.name in opaque_fields(cls):
            del properties[field.encode_name]
    for described in properties.values():
        _without_null(described)
    part["properties"] = _in_order(cls, properties)


def _in_order(cls: type, properties: dict[str, Any]) -> dict[str, Any]:
    """Return the keys in core's order, and those of a link's own where they belong."""
    oldest = _lineage(cls)[0]
    shared = {field.encode_name for field in msgspec.structs.fields(oldest)}
    own = {key: value for key, value in properties.items() if key not in shared}
    after = _OWN_AFTER.get(oldest.__name__)
    if not own or after is None:
        return properties
    ordered = {} if after else dict(own)
    for key, value in properties.items():
        if key in shared:
            ordered[key] = value
        if key == after:
            ordered |= own
    return ordered


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


def _describe(parts: dict[str, Any], classes: dict[str, type]) -> None:
    """Take the descriptions out of the docstrings, attribute by attribute."""
    many = Counter(_lineage(cls)[0] for cls in classes.values())
    for called, part in parts.items():
        lineage = _lineage(classes[called]) if called in classes else []
        said = [one.__doc__ or "" for one in lineage] or [part.get("description", "")]
        # Python 3.13 takes the indentation out of docstrings; earlier ones leave it in.
        texts = [cleandoc(text) for text in said]
        # What several are made from describes none of them.
        own = bool(lineage) and many[lineage[0]] > 1
        summary = texts[-1 if own else 0].partition("\n\n")[0]
        if summary:
            part["description"] = _plain(summary)
        for text in texts:
            listed = text.partition("Attributes:\n")[2]
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


def published(kinds: Iterable[str]) -> dict[str, str]:
    """Return every schema by the name of its file; a profile is of one of these kinds of links."""
    return {
        "among.schema.json": render(among_schema()),
        "mission.schema.json": render(mission_schema()),
        "robot.schema.json": render(robot_schema(kinds)),
        "rosic.schema.json": render(config_schema()),
    }


def main(folder: Path) -> None:
    """Write the schemas into a folder, with every kind of robot link that is installed."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in published(robot_kinds()).items():
        (folder / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "docs/schema"))
