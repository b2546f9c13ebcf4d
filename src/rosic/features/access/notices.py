"""Whoever's access changes hears of it, and so do the admins; whoever changed it, and from where.

The same for a command in a chat and for one of the machine's owner.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.authoriser import keys_messages
from rosic.core.i18n import said
from rosic.core.identity import OPERATOR
from rosic.features.access import access_messages
from rosic.features.access.admin_policy import LOCK, PEOPLE

if TYPE_CHECKING:
    from rosic.core.identity import Principal, PrincipalId
    from rosic.features.access.admin_policy import AdminPolicy
    from rosic.features.access.context import AccessContext


class AccessNotices:
    """Tells them, in private, wherever they can be reached."""

    def __init__(self, registry: AccessContext, powers: AdminPolicy) -> None:
        self._registry = registry
        self._powers = powers

    def revoked(self, person: Principal, by: PrincipalId) -> None:
        """Somebody's access has ended for good."""
        self._person(person, keys_messages.ENDED)
        self._admins(by, person, PEOPLE, access_messages.was_revoked(self._name(by), person.name))

    def key_taken(self, person: Principal, by: PrincipalId) -> None:
        """A key of somebody was taken back; perhaps it was their last one."""
        if not self._registry.authoriser.directory.has_good_key(person.id):
            self.revoked(person, by)
            return
        self._person(person, keys_messages.KEY_TAKEN)
        self._admins(by, person, PEOPLE, access_messages.was_key_taken(self._name(by), person.name))

    def locked(self, person: Principal, by: PrincipalId) -> None:
        """Somebody is locked. Nothing is told to who did it in a chat: they read the answer."""
        if by == OPERATOR:
            self._person(person, keys_messages.LOCKED)
        self._admins(by, person, LOCK, access_messages.was_locked(self._name(by), person.name))

    def unlocked(self, person: Principal, by: PrincipalId) -> None:
        """Somebody has their access back."""
        name = self._name(by)
        self._person(person, access_messages.you_are_unlocked(name))
        self._admins(by, person, LOCK, access_messages.was_unlocked(name, person.name))

    def _name(self, by: PrincipalId) -> str:
        """Return who it was, as a sentence begins with it."""
        return said("The operator") if by == OPERATOR else self._registry.name(by)

    def _person(self, person: Principal, text: str) -> None:
        self._registry.reach.tell((person.id,), text)

    def _admins(self, by: PrincipalId, person: Principal, verb: str, text: str) -> None:
        """Tell everybody else who looks after people: whoever it is about has heard of it."""
        others = [who for who in self._powers.holders(verb, besides=by) if who != person.id]
        self._registry.reach.tell(others, text, urgent=True)
