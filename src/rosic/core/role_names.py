"""Roles that are there by default, as people read and type them in their own language.

A role's own name stays what it is: in the configuration, in the record, and for whoever types it.
None of the other words is reserved: where a place has a role of that name, it is meant.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from rosic.core.i18n import said

if TYPE_CHECKING:
    from collections.abc import Container, Mapping

_SHOWN: Final = {
    "viewer": said("viewer"),
    "operator": said("operator"),
    "senior": said("senior"),
    "admin": said("admin"),
}
TYPED: Final[Mapping[str, str]] = MappingProxyType(
    {"zuschauer": "viewer", "bediener": "operator", "leitung": "senior"}
)
"""What else is typed for a role, in small letters."""


def role_shown(name: str) -> str:
    """Return a role as people read it."""
    return _SHOWN.get(name) or name


def role_typed(word: str, known: Container[str]) -> str:
    """Return the role that a word of another language means here; the word where it means none.

    Args:
        word: In small letters.
        known: The roles of this place.
    """
    meant = TYPED.get(word, word)
    return word if word in known or meant not in known else meant
