"""Every sentence about roles that are made in a chat."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.authoriser.messages import listed
from rosic.core.i18n import joined, said
from rosic.core.language.sanitise import quote
from rosic.core.policy.limits import limit_in_words
from rosic.core.policy.scope import FLEET
from rosic.core.role_names import role_shown
from rosic.features.access.messages import can_do
from rosic.gateway.person_argument import roles_listed

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rosic.core.policy.roles import Role

ALL: Final = "*"
MAKE_IT: Final = said("Make it so")
HOW: Final = said(
    "To make one, write for example: /role guest may ROBOT:SKILL with speed <= 0.2 m/s. To take "
    "it back: /role guest off"
)
TOO_MANY: Final = said("There are as many roles of your own as can be. Nothing was done.")
YOUR_OWN: Final = said(
    "What you have rests on that role, and nobody gives a right to themselves. Somebody else who "
    "gives rights can change it. Nothing was done."
)
NO_FLEET: Final = said(
    "Rights about the place as a whole are not given through a role from a chat. Nothing was done."
)


def not_yours(helpers: Sequence[str]) -> str:
    """Return why somebody does not see the roles, and what they may look at instead."""
    return said(
        "Roles are for whoever gives rights here. {can} Nothing was done. What you may do says: me",
        can=can_do(helpers),
    )


def for_good(helpers: Sequence[str]) -> str:
    """Return why somebody whose right to give rights ends makes and changes no roles."""
    return said(
        "A role stays for good, and your own right to give it ends. {can} Nothing was done.",
        can=can_do(helpers),
    )


def gives(role: Role) -> str:
    """Return what a role gives: ``operator, omni:move with speed <= 0.2 m/s``."""
    what = joined(", ", (*map(role_shown, role.includes), *map(_scope_shown, role.scopes)))
    if not role.limits:
        return what
    return said(
        "{what} with {limits}", what=what, limits=joined(", ", map(limit_in_words, role.limits))
    )


def _scope_shown(scope: str) -> str:
    """Return a scope as it is typed, save for the signs that stand for all of something."""
    robot, _, skill = scope.partition(":")
    if (robot, skill) == (ALL, ALL):
        return said("every robot, everything")
    if (robot, skill) == (FLEET, ALL):
        return said("everything about the place as a whole")
    if robot == ALL:
        return said("{skill} on every robot", skill=skill)
    return said("everything on {robot}", robot=robot) if skill == ALL else scope


def line(name: str, role: Role, *, own: bool) -> str:
    """Return one line of the list."""
    if own:
        return said("{role} (made in a chat): {what}", role=role_shown(name), what=gives(role))
    return said("{role}: {what}", role=role_shown(name), what=gives(role))


def listing(lines: Iterable[str]) -> str:
    """Return the list."""
    return joined("\n", (said("Roles here, and what they give:"), *lines, HOW))


def no_name(name: str) -> str:
    """Return that a role cannot be called so."""
    return said(
        "A role cannot be called {name}: take a short plain word that is no robot's. Nothing was "
        "done.",
        name=quote(name),
    )


def unknown(name: str) -> str:
    """Return that there is no such role."""
    return said("No role is called {name}. Nothing was done.", name=quote(name))


def of_the_file(name: str) -> str:
    """Return that a role is not to be changed here."""
    return said(
        "The role {role} is one of this place's configuration, so it cannot be changed from a "
        "chat. Nothing was done.",
        role=role_shown(name),
    )


def question(name: str, role: Role, before: Role | None, people: Sequence[str]) -> str:
    """Return what will be so, and for whom."""
    whom = (
        said("It changes what {names} may do.", names=listed(people))
        if people
        else said("Nobody has it now.")
    )
    if before is None:
        return said("Make the role {role}: {what}? {whom}", role=name, what=gives(role), whom=whom)
    return said(
        "Change the role {role} from {before} to {what}? {whom}",
        role=name,
        before=gives(before),
        what=gives(role),
        whom=whom,
    )


def to_make(name: str, scope: str) -> str:
    """Return how a role that is not there is made, by a line that works as it is."""
    return said(
        "To make such a role, for example: /role {role} may {scope}", role=name, scope=scope
    )


def make_a_role(name: str) -> str:
    """Return the button that begins to make a role; it asks before anything is done."""
    return said("Make the role {role}", role=name)


def made(name: str, role: Role) -> str:
    """Return that a role is so now."""
    return said("The role {role} gives now: {what}.", role=name, what=gives(role))


def was_made(by: str, name: str, role: Role) -> str:
    """Return what others read about it."""
    return said("{by} made the role {role}: {what}.", by=by, role=name, what=gives(role))


def taken(name: str) -> str:
    """Return that a role is gone."""
    return said("There is no role {role} any more.", role=name)


def still_held(name: str, people: Sequence[str]) -> str:
    """Return who keeps a role from being taken back."""
    return said(
        "The role {role} is still held by {names}. Take it from them first. Nothing was done.",
        role=name,
        names=listed(people),
    )


def still_invited(name: str, people: Sequence[str]) -> str:
    """Return whose open invitations keep a role from being taken back."""
    return said(
        "The role {role} is named in an open invitation of {names}. Nothing was done.",
        role=name,
        names=listed(people),
    )


def still_included(name: str, roles: Sequence[str]) -> str:
    """Return which roles keep a role from being taken back."""
    return said(
        "The role {role} is included in {roles}. Nothing was done.",
        role=role_shown(name),
        roles=roles_listed(roles),
    )
