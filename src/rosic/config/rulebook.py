"""What a place has written down about rights, as rights see it: its rules and its robots."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.language import skills_of
from rosic.core.policy.roles import DEFAULT_ROLES, RoleRules
from rosic.core.policy.scope import Fleet

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.policy.roles import Role, SkillPrecondition
    from rosic.core.robot.profile import Profile


def fleet_of(profiles: Iterable[Profile]) -> Fleet:
    """Return the robots there are, as rights see them."""
    groups: dict[str, list[str]] = {}
    skills = {}
    for profile in profiles:
        skills[profile.id] = skills_of(profile)
        for group in profile.groups:
            groups.setdefault(group, []).append(profile.id)
    return Fleet(skills=skills, groups={name: tuple(some) for name, some in groups.items()})


def rulebook_of(
    roles: dict[str, Role], care: tuple[SkillPrecondition, ...] = (), preempt: tuple[str, ...] = ()
) -> RoleRules:
    """Return the rules of a place: its own roles beside the default ones, or instead of them."""
    return RoleRules(roles={**DEFAULT_ROLES, **roles}, care=care, preempt=preempt)
