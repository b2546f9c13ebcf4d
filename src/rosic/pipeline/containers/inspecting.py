"""What the operator asks about containers; each returns what a terminal shows or a file takes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.container import archived, export
from rosic.container.shelf import Quota
from rosic.core.record import Decided
from rosic.errors import NotUnderstood, OutOfBounds
from rosic.pipeline.containers import words_containers as words
from rosic.pipeline.containers.archiving import rows_of
from rosic.pipeline.containers.parts import all_facts

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.record import Fact
    from rosic.pipeline.containers.erasing import Erasing
    from rosic.pipeline.containers.parts import Holdings

FORMS = ("text", "jsonl", "xlsx")
_CHAT = "chat-"


async def list_containers(holdings: Holdings) -> str:
    """Return a line for each container, robots' first.

    Raises:
        StoreFault: They cannot be read now.
    """
    robots = [words.container_line("robot", holdings.shown(r), r) for r in sorted(holdings.robots)]
    others = [name for name in await holdings.vault.containers() if name not in holdings.robots]
    chats = [words.container_line("chat", "", name) for name in others if name.startswith(_CHAT)]
    people = [
        words.container_line("person", holdings.name(name), name)
        for name in others
        if not name.startswith(_CHAT)
    ]
    return "\n".join([*robots, *people, *chats])


async def show_container(holdings: Holdings, container: str) -> str:
    """Return how much of what a container holds.

    Raises:
        NotUnderstood: There is none.
        StoreFault: It cannot be read now.
    """
    found = await _found(holdings, container)
    quota, (names, kept) = holdings.shelf.quota(container), holdings.shelf.used(container)
    used = words.used(names, quota.names, kept, quota.most_bytes)
    return words.container_shown(_title(holdings, container), export.summary(found), used)


async def export_container(holdings: Holdings, container: str) -> str:
    """Return everything in a container as JSON lines; secrets are not among it.

    Raises:
        NotUnderstood: There is none.
        StoreFault: It cannot be read now.
    """
    return export.container_as_jsonl(await _found(holdings, container))


async def limit_container(
    holdings: Holdings, container: str, by: PrincipalId, *, names: int, most_bytes: int
) -> str:
    """Say what one container may keep, from now on; the others are not touched.

    Raises:
        NotUnderstood: There is none.
        OutOfBounds: A number is negative.
        RecordUnavailable: Nothing was changed.
    """
    if min(names, most_bytes) < 0:
        raise OutOfBounds(words.NO_SUCH_CONTAINER)
    await _found(holdings, container)
    before = holdings.shelf.quota(container)
    quota = Quota(names=names, history=before.history, most_bytes=most_bytes)
    now_ns = holdings.clock.wall_ns()
    async with holdings.changes.turn() as turn:
        decided = Decided(act="limit", by=by, about=container, at_ns=now_ns)
        await turn.write((decided, *holdings.shelf.limit(container, quota)))
    return words.limit_set(_title(holdings, container), names, most_bytes)


async def erase_container(
    holdings: Holdings, erasing: Erasing, container: str, by: PrincipalId
) -> str:
    """Erase a container for good: a person's with all their rights, a robot's or a chat's data.

    Raises:
        NotUnderstood, NotPermitted, RecordUnavailable: As `Erasing.erase`.
    """
    if container in holdings.robots or container.startswith(_CHAT):
        title = _title(holdings, container)
        await erasing.erase_other(container, by)
        return words.erased(title, at_rest=True)
    erased = await erasing.erase(container, by)
    return words.erased(erased.name, at_rest=erased.at_rest)


async def export_archive(holdings: Holdings, container: str, form: str) -> str | bytes:
    """Return the messages of a chat: ``text`` as in the paper, ``jsonl``, or ``xlsx``.

    Args:
        holdings: The books.
        container: As `list_containers` shows it: ``chat-…``.
        form: One of `FORMS`.

    Raises:
        NotUnderstood: There is no such chat or form.
        ConfigurationError: No spreadsheet can be made on this computer.
        StoreFault: It cannot be read now.
    """
    key = container.removeprefix(_CHAT)
    if key not in holdings.archive.all() or form not in FORMS:
        raise NotUnderstood(words.NO_SUCH_CONTAINER)
    rows = await rows_of(holdings.vault, key)
    if form == "xlsx":
        return export.archive_as_xlsx(rows)
    return export.archive_as_text(rows) if form == "text" else export.archive_as_jsonl(rows)


async def _found(holdings: Holdings, container: str) -> tuple[Fact, ...]:
    """Return what a container holds; of a chat, all its entries, whoever sealed them."""
    found = await holdings.vault.belongings(container)
    if container.startswith(_CHAT):
        key = container.removeprefix(_CHAT)
        known = {(fact.kind, fact.key) for fact in found}
        entries = await all_facts(holdings.vault, archived.ENTRY, f"{key}.")
        found = (*found, *(_open(f) for f in entries if (f.kind, f.key) not in known))
    if not found and container not in holdings.robots:
        raise NotUnderstood(words.NO_SUCH_CONTAINER)
    return found


def _open(fact: Fact) -> Fact:
    """Return what a chat's own container shows of an entry that is sealed in a person's."""
    return msgspec.structs.replace(fact, letter=None)


def _title(holdings: Holdings, container: str) -> str:
    if container in holdings.robots:
        return holdings.shown(container)
    return container if container.startswith(_CHAT) else holdings.name(container)
