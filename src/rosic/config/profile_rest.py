"""What shows rest: which axes it covers of those that a skill drives along, and its deadline."""

from __future__ import annotations

import re
from math import ceil
from typing import TYPE_CHECKING, Final

from rosic.contracts.file_rules import ValidationFinding

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rosic.core.robot.profile import Profile

_AXIS: Final = re.compile(r"(?:^|\.)((?:linear|angular)\.[xyz])$")


def unseen_axes(profile: Profile) -> Iterator[ValidationFinding]:
    """Say which axes a skill sends velocities along while rest is measured along others alone."""
    if profile.at_rest is None:
        return
    seen = _axes(profile.at_rest.fields)
    for name, skill in profile.skills.items():
        if skill.topic is None or not seen:
            continue
        for axis in sorted(_axes(skill.topic.message) - seen):
            yield ValidationFinding(
                ("at_rest", "field"),
                f"'{name}' sends {axis}, which 'at_rest' does not measure: a stop could be "
                "confirmed while it still moves so.",
                f"Add the field that ends in {axis}, separated by a comma.",
            )


def _axes(paths: Iterable[str]) -> set[str]:
    return {found[1] for path in paths if (found := _AXIS.search(path))}


def enough_s(every_s: float) -> float:
    """Return an `AtRest.within_s` for what comes so often: one message may be lost, to 0.5 s."""
    return ceil(4 * every_s - 0.1) / 2
