"""Which person somebody means, in a line that is not an order; and which of several, by a button.

A name is its owner's to choose, and two may share one: what decides is an id, which a button or
another program says where it can, and people may type.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.authoriser.messages import listed
from rosic.core.i18n import joined, said
from rosic.core.language.sanitise import quote
from rosic.core.message import Button
from rosic.core.role_names import role_shown
from rosic.errors import NotUnderstood
from rosic.gateway.commands import Reply, asks_first

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.identity import Principal
    from rosic.gateway.commands import CommandContext

BY_ID: Final = b"by its id"
"""What a button carries that means one person, whoever else may be called like that id."""
MOST_OFFERED: Final = 8


def which_person(
    asked: CommandContext, typed: str, found: Sequence[tuple[Principal, str, str]]
) -> Reply:
    """Ask which of several people is meant.

    Args:
        asked: By whom, where. Names are offered only where nobody else reads along.
        typed: What several are called.
        found: Who, the command that means them by their id, and what else it says.

    Raises:
        NotUnderstood: Others read along.
    """
    if not asked.private:
        raise NotUnderstood(several_in_group(len(found), typed))
    sentence = said(
        "{count} people are called {quote}. Which one?", count=len(found), quote=quote(typed)
    )
    return asks_first(sentence, tuple((_button(*one),) for one in found[:MOST_OFFERED]))


def several_in_group(count: int, given: str) -> str:
    """Return that several people are meant where others read along."""
    return said(
        "{count} people are called {quote}. Ask me in a private chat, where I can show "
        "you which. Nothing was done.",
        count=count,
        quote=quote(given),
    )


def roles_listed(names: Sequence[str]) -> str:
    """Return roles in a row, as people read them."""
    return listed(tuple(map(role_shown, names)))


def _button(person: Principal, command: str, more: str) -> Button:
    """Return the button that means one of several; what else it says stands in its label."""
    roles = person.roles
    held = roles_listed(roles) if roles else said("without a role of their own")
    label = joined(", ", (person.name, held, *((more,) if more else ())))
    return Button(label, command, act=BY_ID)
