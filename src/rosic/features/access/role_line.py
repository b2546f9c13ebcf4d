"""``guest may omni:move omni:wave with omni:move speed <= 0.2 m/s``: what a role shall be.

Scopes, limits and the names of included roles are written as in the file. Total and linear.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from rosic.core.language import clean
from rosic.core.language.option_words import OPTIONS
from rosic.core.language.sanitise import fold_word
from rosic.core.policy.roles import Role
from rosic.core.policy.scope import FLEET
from rosic.core.role_names import role_typed
from rosic.errors import NotUnderstood
from rosic.features.access import roles_messages
from rosic.features.access.limit_line import limit_typed
from rosic.gateway.office import check_length

if TYPE_CHECKING:
    from collections.abc import Container

    from rosic.core.policy.scope import Fleet

LONGEST_LINE: Final = 300
MAY, WITH, OFF = "may", "with", "off"
_NAME = re.compile(r"[a-z][a-z0-9_-]{0,31}\Z")
_LIMITS = re.compile(r"\s*,\s+|,(?!\d)|(?<!\d),|\s+(?:and|with|und|mit)\s+", re.IGNORECASE)
_FILLERS = frozenset({"and", ",", "&", "und"})
_WITH = re.compile(r"\s(?:with|mit)\s")
# Words that mean something else where roles are named: in /grant, /invite and here.
_TAKEN = frozenset(
    {
        "a", "an", "and", "as", "at", "back", "code", "confirm", "everywhere", FLEET,
        "for", "limit", MAY, OFF, "on", "the", WITH, *OPTIONS,
    }
)  # fmt: skip


def said_line(text: str) -> str:
    """Return a line as it is read.

    Raises:
        OutOfBounds: It is too long.
    """
    said = " ".join(clean(text).split())
    check_length(said, LONGEST_LINE)
    return said


def can_be_a_role(name: str, fleet: Fleet) -> bool:
    """Whether a name would be read as a role's and as nothing else."""
    other = name in _TAKEN or name in fleet.skills or name in fleet.groups
    return bool(_NAME.match(name)) and not other


def check_name(name: str, fleet: Fleet) -> None:
    """See that a role can be called so.

    Raises:
        NotUnderstood: It cannot: it would be read as something else.
    """
    if not can_be_a_role(name, fleet):
        raise NotUnderstood(roles_messages.no_name(name))


def read_role(text: str, fleet: Fleet, known: Container[str] = ()) -> Role:
    """Read what stands after ``may``. Whether it makes sense, the check of the rulebook says.

    Args:
        text: The words.
        fleet: Whose parameters may be limited.
        known: The roles of this place, which other languages may have words for.
    """
    said, *after = _WITH.split(text, maxsplit=1)
    limits = after[0] if after else ""
    named = [fold_word(word).casefold() for word in said.replace(",", " , ").split()]
    given = [word for word in dict.fromkeys(named) if word not in _FILLERS]
    return Role(
        scopes=tuple(word for word in given if ":" in word),
        includes=tuple(role_typed(word, known) for word in given if ":" not in word),
        limits=tuple(
            dict.fromkeys(
                limit_typed(each, fleet) for each in _LIMITS.split(limits) if each.strip()
            )
        ),
    )
