"""What is wrong with the parameters of a mission."""

from __future__ import annotations

import re
from math import isfinite
from typing import TYPE_CHECKING, Final

from rosic.config.source_map import nearest
from rosic.config.validation import ValidationFinding
from rosic.core.fleet.template import QUANTITIES_AT_MOST, names_in

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.core.fleet.mission import Mission, MissionPart
    from rosic.core.fleet.template import Quantity
    from rosic.core.language import UnitTable

NAME: Final = re.compile(r"[a-z][a-z0-9_]*")
TIMES: Final = frozenset({"in", "at", "on", "every", "now", "next", "today", "tomorrow"})
"""What begins a time when a mission is started later."""


def quantity_findings(mission: Mission, units: UnitTable) -> Iterator[ValidationFinding]:
    """Find what is wrong with each of them."""
    place = ("parameters",)
    if len(mission.parameters) > QUANTITIES_AT_MOST:
        yield ValidationFinding(place, f"A mission has at most {QUANTITIES_AT_MOST} parameters.")
    for name, quantity in mission.parameters.items():
        if not NAME.fullmatch(name):
            yield ValidationFinding(
                (*place, name), f"{name!r} is no name for a parameter.",
                "Use small letters, digits and _, a letter first.",
            )  # fmt: skip
        elif name in TIMES:
            yield ValidationFinding(
                (*place, name), f"{name!r} begins a time here.", "Call it otherwise."
            )
        yield from (
            ValidationFinding((*place, name, *under), sentence, hint)
            for under, sentence, hint in _wrong(quantity, units)
        )


def _wrong(quantity: Quantity, units: UnitTable) -> Iterator[tuple[tuple[str, ...], str, str]]:
    if quantity.unit and units.find(quantity.unit) is None:
        yield (
            ("unit",),
            f"{quantity.unit!r} is no unit that is known here.",
            nearest(quantity.unit, units.exact, say_all=False)
            or "Write for example m, m/s, deg or s.",
        )
    if not isfinite(quantity.min) or not isfinite(quantity.max) or quantity.min > quantity.max:
        yield ("min",), "min and max have to be finite, and min not above max.", ""
        return
    if quantity.default is not None and not quantity.min <= quantity.default <= quantity.max:
        bounds = f"{quantity.min:g} and {quantity.max:g}"
        sentence = f"The default {quantity.default:g} is not between {bounds}."
        yield ("default",), sentence, "Change the default or its bounds."


def unused_findings(mission: Mission) -> Iterator[ValidationFinding]:
    """Find parameters that change nothing."""
    used = {name for part in mission.do for text in _texts(part) for name in names_in(text)}
    for name in mission.parameters:
        if name not in used:
            yield ValidationFinding(
                ("parameters", name), f"No step uses {name!r}.",
                f"Write ${name} in a step, or leave it out.",
            )  # fmt: skip


def _texts(part: MissionPart) -> Iterator[str]:
    yield from part.steps
    yield from part.values.values()
    for other in (*part.sequence, *part.together):
        yield from _texts(other)
