"""The forms and bounds of what a profile says, for the check and for the published schema."""

from __future__ import annotations

from typing import Final

from rosic.contracts.file_rules import Field, FieldForm, NumberBounds
from rosic.core.robot.alert_config import AlertConfig
from rosic.core.robot.benchmark import Benchmark, ErrorBound
from rosic.core.robot.geography import GeographicFrame
from rosic.core.robot.profile import Files, Link, Profile, Telemetry
from rosic.core.robot.skill import COST_MAX, Parameter, Skill, Strategy
from rosic.core.time_units import HOUR_S

_NAME = r"[a-z][a-z0-9_]{0,31}"
NAMED = FieldForm(
    _NAME, "a name", "Use small letters, digits and _, a letter first, at most 32 characters."
)
WORD = FieldForm(
    r"[^\sA-Z,;=:]{1,32}( [^\sA-Z,;=:]{1,32}){0,3}",
    "a word people type",
    "Use at most four words in small letters, each of at most 32 characters.",
)
_FOLDER = FieldForm(
    r"/[^\x00-\x1f\x7f]{1,500}",
    "a folder's full path",
    "Begin with a slash: /srv/omni/inbox.",
    empty=True,
)
_SORT = FieldForm(
    "png|jpeg|pdf|pgm|zip|gzip|mcap|db3|yaml|json|csv|text",
    "a kind of file",
    "Use png, jpeg, pdf, pgm, zip, gzip, mcap, db3, yaml, json, csv or text.",
)
_LINE = FieldForm(
    r"[^\x00-\x1f\x7f]{1,120}", "a line of text", "Use 1 to 120 characters of one line."
)
_LENGTH = FieldForm(
    r" *\d+(\.\d+)? *[a-z]+ *", "a length of time", "Write a number and a unit: 10 s, 2 min."
)

FORMS: Final[dict[Field, FieldForm]] = {
    (AlertConfig, "name"): NAMED,
    (AlertConfig, "when"): _LINE,
    (AlertConfig, "clear"): _LINE._replace(empty=True),
    (AlertConfig, "lasting"): _LENGTH,
    (AlertConfig, "say"): _LINE._replace(empty=True),
    (AlertConfig, "escalate_after"): _LENGTH._replace(empty=True),
    (AlertConfig, "run"): _LINE._replace(empty=True),
    (AlertConfig, "author"): _LINE._replace(empty=True),
    (AlertConfig, "run_every"): _LENGTH,
    (Benchmark, "per_s"): NAMED,
    (Benchmark, "battery"): NAMED,
    (Benchmark, "errors"): NAMED,
    (ErrorBound, "measured"): FieldForm(
        rf"{_NAME}|pose\.(x|y|yaw)",
        "something that is measured",
        "Write a fact that the robot reports, as distance_m, or pose.x, pose.y, pose.yaw.",
    ),
    (Profile, "id"): NAMED,
    (Profile, "groups"): NAMED,
    (Profile, "words"): WORD,
    (Profile, "go_to"): FieldForm(
        rf"{_NAME} {_NAME} {_NAME}",
        "a skill and two of its parameters",
        "Write the skill, then what it calls x and y: goto x y.",
        empty=True,
    ),
    (Profile, "skills"): NAMED,
    (Profile, "telemetry"): NAMED,
    (Skill, "words"): WORD,
    (Skill, "parameters"): NAMED,
    (Parameter, "choices"): WORD,
    (Parameter, "means"): WORD._replace(empty=True),
    (Profile, "strategies"): NAMED,
    (Strategy, "parameters"): NAMED,
    (Link, "kind"): NAMED,
    (Files, "accept"): _SORT,
    (Files, "inbox"): _FOLDER,
    (Files, "outbox"): _FOLDER,
}

BOUNDS: Final[dict[Field, NumberBounds]] = {
    (GeographicFrame, "latitude"): NumberBounds(-85, 85),
    (GeographicFrame, "longitude"): NumberBounds(-180, 180),
    (GeographicFrame, "heading_deg"): NumberBounds(-360, 360),
    (Profile, "queue_length"): NumberBounds(1, 10_000),
    (Profile, "watchdog_s"): NumberBounds(0.05, 5),
    (Profile, "rest_timeout_s"): NumberBounds(0.1, 120),
    (Link, "heartbeat_s"): NumberBounds(0.1, HOUR_S),
    (Files, "max_mb"): NumberBounds(0.001, 2_000),
    (Benchmark, "late"): NumberBounds(1.01, 1000),
    (Telemetry, "full"): NumberBounds(1, 1000),
    (Skill, "lifetime_s"): NumberBounds(0.1, HOUR_S),
    (Skill, "cost"): NumberBounds(1, COST_MAX),
}

HIDDEN: Final[frozenset[Field]] = frozenset({(Skill, "id")})
