"""Tools as a client lists them: one for each skill of each robot, and a few that always are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from mcp_types import Tool, ToolAnnotations

from rosic.core.i18n import plain
from rosic.core.robot.skill import SkillClass
from rosic.core.robot.skill_schema import object_schema, schema_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rosic.contracts.programs import OfferedSkill

STOP: Final = "stop"
CANCEL: Final = "cancel"
LIST_ROBOTS: Final = "list_robots"
STATUS: Final = "status"
BETWEEN: Final = "-"
"""Between robot and skill: it is in no name of a robot, and in none of the tools above."""


def tools_of(robots: Mapping[str, str], skills: Sequence[OfferedSkill]) -> list[Tool]:
    """Return every tool of a program.

    Args:
        robots: Those that it may see: id, and as people read it.
        skills: What it may ask for.
    """
    return [*_always(robots), *map(_tool, skills)]


def robot_and_skill(tool: str) -> tuple[str, str] | None:
    """Return whose skill a tool is; None: it is none of these."""
    robot, between, skill = tool.partition(BETWEEN)
    return (robot, skill) if between else None


def _always(robots: Mapping[str, str]) -> Iterator[Tool]:
    names = {"type": "string", "enum": sorted(robots)} if robots else {"type": "string"}
    one = object_schema({"robot": {**names, "description": "Left out: all of them."}})
    some = {"type": "array", "items": {"type": "string"}, "description": "Left out: all of them."}
    looks = ToolAnnotations(read_only_hint=True, open_world_hint=False)
    ends = ToolAnnotations(read_only_hint=False, destructive_hint=False, idempotent_hint=True)
    yield Tool(
        name=STOP,
        title="Stop",
        description="Stop robots at once, and keep them stopped until a person resumes them. It is "
        "never refused, queued or counted. A name that is not known stops all of them. It is an "
        "operational stop over a network and no safety function.",
        input_schema=object_schema({"robots": some}),
        annotations=ends,
    )
    yield Tool(
        name=CANCEL,
        title="Cancel",
        description="End what you have under way yourself, with one robot or with all. Nothing "
        "stays stopped.",
        input_schema=one,
        annotations=ends,
    )
    yield Tool(
        name=LIST_ROBOTS,
        title="Robots",
        description="Which robots there are for you.",
        input_schema=object_schema({}),
        annotations=looks,
    )
    yield Tool(
        name=STATUS,
        title="Status",
        description="How robots are: what they do, whether they rest, who has them.",
        input_schema=one,
        annotations=looks,
    )


def _tool(offered: OfferedSkill) -> Tool:
    skill = offered.skill
    title = f"{plain(offered.shown)}: {plain(skill.shown)}"
    moves = skill.kind in (SkillClass.MOTION, SkillClass.TASK)
    parts = [f"{title}."]
    parts += ["The robot moves."] if skill.kind is SkillClass.MOTION else []
    parts += ["A person is asked first, in their chat."] if offered.asks else []
    parts.append("Values are refused beyond their bounds; narrower ones may hold for you.")
    return Tool(
        name=f"{offered.robot}{BETWEEN}{skill.id}",
        title=title,
        description=" ".join(parts),
        input_schema=schema_of(skill),
        annotations=ToolAnnotations(
            read_only_hint=skill.kind is SkillClass.OBSERVE,
            destructive_hint=moves,
            idempotent_hint=False,
        ),
    )
