"""Which robots are alike as rights see them: what somebody may do with one is kept once for all."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.core.policy.scope import FLEET, Fleet

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.skill import Skill


def kinds_of(fleet: Fleet, care: Mapping[RobotId, Mapping[str, object]]) -> dict[RobotId, int]:
    """Number the robots so that those with the same skills and the same care have one number.

    By which topic, service or action a skill is carried out is nothing to rights.
    """
    met: dict[str, int] = {}
    kinds = {FLEET: -1}
    for robot, skills in fleet.skills.items():
        plain = {name: _unbound(skill) for name, skill in skills.items()}
        mine = repr((plain, care.get(robot, {})))
        kinds[robot] = met.setdefault(mine, len(met))
    return kinds


def _unbound(skill: Skill) -> Skill:
    return msgspec.structs.replace(
        skill, topic=None, service=None, action=None, set_parameters=None
    )
