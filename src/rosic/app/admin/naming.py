"""People as the operator of the machine names and lists them."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import TYPE_CHECKING

from rosic.core.language import clean
from rosic.core.time_units import SECOND_NS
from rosic.errors import NotUnderstood
from rosic.features.access import messages

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rosic.app.admin.api import AdminContext
    from rosic.authoriser.directory import Directory
    from rosic.core.identity import Principal

MOST_KNOWN = 20
CONFIGURED = "configured"
"""Of somebody whom the configuration names and the first start takes over."""


def people_lines(books: AdminContext) -> tuple[str, ...]:
    """Return a line for everybody: name, what they may until when, addresses, id."""
    found = sorted(books.authoriser.directory.people(), key=lambda p: (p.name.casefold(), p.id))
    waiting = [
        messages.waits(clean(a.name), a.pending.given.words, a.words)
        for a in books.access.enrolment.applicants.all()
    ]
    return (*(_person(books, person) for person in found), *waiting)


def people_listed(books: AdminContext) -> tuple[dict[str, object], ...]:
    """Return everybody, and whoever waits to come in, for programs."""
    found = sorted(books.authoriser.directory.people(), key=lambda p: (p.name.casefold(), p.id))
    waiting: Iterator[dict[str, object]] = (
        {
            "name": clean(a.name),
            "state": "waiting",
            "address": str(a.address),
            "given": a.pending.given.words,
        }
        for a in books.access.enrolment.applicants.all()
    )
    return (*(_listed(books, person) for person in found), *waiting)


def _listed(books: AdminContext, person: Principal) -> dict[str, object]:
    good = books.authoriser.directory.has_good_key(person.id)
    key = books.access.keys.current(person.id) if good else None
    now_ns = books.clock.wall_ns()
    grants = [
        {
            "roles": [held.role] if held.role else [],
            "scopes": held.scopes,
            "robots": held.robots,
            "limits": [str(limit) for limit in held.limits],
            "until": utc(held.expires_ns),
        }
        for held in books.authority.grants_book.grants_of(person.id)
        if held.id and (held.expires_ns is None or held.expires_ns > now_ns)
    ]
    return {
        "id": person.id,
        "name": clean(person.name),
        "state": "ended" if key is None else _lock_state(books, person),
        "roles": person.roles,
        "grants": grants,
        "addresses": [str(address) for address in person.addresses],
        "until": None if key is None else utc(books.access.keys.ends_ns(key)),
    }


def _lock_state(books: AdminContext, person: Principal) -> str:
    return "locked" if books.access.locks.locked(person.id) else "good"


def utc(at_ns: int | None) -> str | None:
    """Return a moment for programs: ISO 8601, of UTC, whole seconds; None for no end."""
    if at_ns is None:
        return None
    return datetime.fromtimestamp(at_ns // SECOND_NS, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def _person(books: AdminContext, person: Principal) -> str:
    locked = "locked · " if books.access.locks.locked(person.id) else ""
    addresses = ", ".join(clean(str(a)) for a in person.addresses) or "no address"
    return f"{clean(person.name)}: {locked}{_access(books, person)} · {addresses} · {person.id}"


def _access(books: AdminContext, person: Principal) -> str:
    if not books.authoriser.directory.has_good_key(person.id):
        return "access ended"
    key = books.access.keys.current(person.id)
    if key is None:
        return "access ended by itself"
    said = [*_own(person), *_grants(books, person)]
    text = f"as {'; '.join(said)}" if said else "has no rights now"
    ends_ns = books.access.keys.ends_ns(key)
    return text if ends_ns is None else f"{text} · access until {books.moment(ends_ns)}"


def _own(person: Principal) -> list[str]:
    return [", ".join(map(clean, person.roles))] if person.roles else []


def _grants(books: AdminContext, person: Principal) -> list[str]:
    """Return what somebody was given besides their own roles, and until when."""
    now_ns = books.clock.wall_ns()
    return [
        messages.grant(
            held, held.limits, "" if held.expires_ns is None else books.moment(held.expires_ns)
        )
        for held in books.authority.grants_book.grants_of(person.id)
        if held.id and (held.expires_ns is None or held.expires_ns > now_ns)
    ]


def the_one(directory: Directory, name: str) -> Principal:
    """Return the person who is called so, or who has that id.

    Raises:
        NotUnderstood: Nobody, or more than one.
    """
    found = directory.called(name)
    if len(found) == 1:
        return found[0]
    said = clean(name)
    if found:
        ids = ", ".join(person.id for person in found)
        raise NotUnderstood(f"Several people are called {said}. Say which by its id: {ids}.")
    raise NotUnderstood(f"Nobody is called {said}. There are: {_known(directory.people())}.")


def _known(people: Iterable[Principal]) -> str:
    names = sorted(clean(person.name) for person in people)
    more = f" and {len(names) - MOST_KNOWN} more" if len(names) > MOST_KNOWN else ""
    return (", ".join(names[:MOST_KNOWN]) + more) or "nobody yet"
