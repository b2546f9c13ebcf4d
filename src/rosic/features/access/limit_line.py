"""``Tempo <= 0,2 m/s``: a limit as people type it, in the words and numbers that are kept of it."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from rosic.core.language.keywords import decimals_typed, parameter_typed

if TYPE_CHECKING:
    from rosic.core.policy.scope import Fleet

_SIGN: Final = re.compile(r"\s*[<>=≤≥]")


def limit_typed(text: str, fleet: Fleet) -> str:
    """Return a limit with the name of its parameter in small letters; a unit keeps its letters.

    Args:
        text: ``omni:move Tempo <= 0,2 m/s``.
        fleet: Whose parameters there are.
    """
    sign = _SIGN.search(text)
    if sign is None:
        return text.casefold().strip()
    *scope, name = text[: sign.start()].casefold().split() or [""]
    skills = (skill for skills in fleet.skills.values() for skill in skills.values())
    known = {parameter for skill in skills for parameter in skill.parameters}
    rest = decimals_typed(text[sign.start() :])
    return f"{' '.join([*scope, parameter_typed(name, known)])}{rest}".strip()
