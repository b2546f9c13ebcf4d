"""What the operator asks about containers: looking in, taking out, limiting, erasing."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import msgspec

from rosic.container import archive_records, export
from rosic.container.export import ContainerSummary
from rosic.container.messages import size
from rosic.container.shared_data import SharedDataQuota
from rosic.core.i18n import said, said_n
from rosic.core.records import Decided
from rosic.errors import NotUnderstood, OutOfBounds
from rosic.features.personal_data import messages as words
from rosic.features.personal_data.archive_commands import all_facts, rows_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from rosic.core.identity import PrincipalId
    from rosic.core.records import Fact
    from rosic.features.personal_data.erasure import ErasureCommands
    from rosic.gateway.container_context import ContainerContext


# ---- sentences and tables ----

NEGATIVE: Final = said("A limit cannot be less than nothing. Nothing was changed.")
NO_SHELF: Final = said(
    "A chat keeps messages alone, for as many days as was said there with /archive on."
)


def limit_set(name: str, names: int, most_bytes: int) -> str:
    """Return what a container may keep from now on."""
    return said_n(
        "{name} may keep {n} name and {size} from now on.",
        "{name} may keep {n} names and {size} from now on.",
        names,
        name=name,
        size=size(most_bytes),
    )


def emptied(name: str) -> str:
    """Return that what a robot or a chat kept was erased."""
    return said(
        "What {name} kept is erased. Copies of the record made before stay readable with their "
        "key.",
        name=name,
    )


def table(listed: Sequence[ListedContainer]) -> str:
    """Return a line for each container: kind, id, name."""
    wide = max((len(one.container) for one in listed), default=0)
    named = (one.name if one.name != one.container else "" for one in listed)
    return "\n".join(
        f"{one.kind:<6}  {one.container:<{wide}}  {name}".rstrip()
        for one, name in zip(listed, named, strict=True)
    )


def shown(what: ShownContainer) -> str:
    """Return how much of what a container holds, aligned."""
    rows = [(each.kind, str(each.count), size(each.size)) for each in what.holds]
    wide = max((len(kind) for kind, _, _ in rows), default=0)
    counts = max((len(count) for _, count, _ in rows), default=0)
    lines = [f"  {kind:<{wide}}  {count:>{counts}}  {bytes_}" for kind, count, bytes_ in rows]
    kept = (
        f"shared data: {what.names} of {what.names_most} names, "
        f"{size(what.kept_bytes)} of {size(what.kept_most)}"
    )
    title = what.name if what.name == what.container else f"{what.name} ({what.container})"
    return "\n".join([f"{what.kind} {title}", *(lines or ["  nothing"]), f"  {kept}"])


def written(path: str, lines: int) -> str:
    """Return where an export lies, and what to mind."""
    return said_n(
        "{n} entry in {path}. It is not sealed: whoever has it can read it.",
        "{n} entries in {path}. It is not sealed: whoever has it can read it.",
        lines,
        path=path,
    )


# ---- what the operator asks ----

ROBOT: Final = "robot"
PERSON: Final = "person"
CHAT: Final = "chat"
LINES_AT_ONCE: Final = 500
_CHAT: Final = "chat-"


class ListedContainer(msgspec.Struct, frozen=True):
    """One container.

    Attributes:
        kind: ``robot``, ``person`` or ``chat``.
        container: Its id.
        name: How whoever it belongs to is shown.
    """

    kind: str
    container: str
    name: str


class ShownContainer(msgspec.Struct, frozen=True, kw_only=True):
    """How much of what a container holds.

    Attributes:
        names: Of shared data, now; then the most.
        kept_bytes: Of shared data, now; then the most.
    """

    kind: str
    container: str
    name: str
    holds: tuple[ContainerSummary, ...]
    names: int
    names_most: int
    kept_bytes: int
    kept_most: int


async def list_containers(data_context: ContainerContext) -> list[ListedContainer]:
    """Return every container, robots' first.

    Raises:
        StoreFault: They cannot be read now.
    """
    kept = await data_context.container_store.containers()
    others = [_listed(data_context, name) for name in kept if name not in data_context.robots]
    robots = [_listed(data_context, robot) for robot in sorted(data_context.robots)]
    order = [ROBOT, PERSON, CHAT]
    return sorted([*robots, *others], key=lambda one: (order.index(one.kind), one.name.casefold()))


async def show_container(data_context: ContainerContext, container: str) -> ShownContainer:
    """Return how much of what a container holds.

    Raises:
        NotUnderstood: There is none.
        StoreFault: It cannot be read now.
    """
    found = await _found(data_context, container)
    quota, (names, kept) = data_context.shelf.quota(container), data_context.shelf.used(container)
    listed = _listed(data_context, container)
    return ShownContainer(
        kind=listed.kind,
        container=container,
        name=listed.name,
        holds=export.summary(found),
        names=names,
        names_most=quota.names,
        kept_bytes=kept,
        kept_most=quota.most_bytes,
    )


async def export_container(data_context: ContainerContext, container: str) -> Iterator[str]:
    """Return JSON lines, many at a time: a chat's messages, or everything else's content.

    Secrets are not among it. They are made as they are asked for: no long export holds up a stop.

    Raises:
        NotUnderstood: There is none.
        StoreFault: It cannot be read now.
    """
    if container.startswith(_CHAT):
        await _found(data_context, container)
        rows = await rows_of(data_context.container_store, container.removeprefix(_CHAT))
        return together(map(export.row_as_json, rows))
    found = await _found(data_context, container)
    return together(map(export.thing_as_json, map(export.thing_of, found)))


def together(lines: Iterable[str]) -> Iterator[str]:
    """Yield lines, many at a time."""
    held: list[str] = []
    for line in lines:
        held.append(line)
        if len(held) >= LINES_AT_ONCE:
            yield "\n".join(held)
            held.clear()
    if held:
        yield "\n".join(held)


async def limit_container(
    data_context: ContainerContext,
    container: str,
    by: PrincipalId,
    *,
    names: int | None = None,
    most_bytes: int | None = None,
) -> str:
    """Say what one container may keep, from now on; the others are not touched.

    Args:
        data_context: The books.
        container: Whose.
        by: Who decides.
        names: At most so many; None leaves it.
        most_bytes: At most so many; None leaves it.

    Raises:
        NotUnderstood: There is none, or a chat's, which keeps no shared data.
        OutOfBounds: A number is negative.
        RecordUnavailable: Nothing was changed.
    """
    if min(names or 0, most_bytes or 0) < 0:
        raise OutOfBounds(NEGATIVE)
    if container.startswith(_CHAT):
        raise NotUnderstood(NO_SHELF)
    await _known(data_context, container)
    before = data_context.shelf.quota(container)
    quota = SharedDataQuota(
        names=before.names if names is None else names,
        history=before.history,
        most_bytes=before.most_bytes if most_bytes is None else most_bytes,
    )
    now_ns = data_context.clock.wall_ns()
    async with data_context.changes.turn() as turn:
        decided = Decided(act="limit", by=by, about=container, at_ns=now_ns)
        await turn.write((decided, *data_context.shelf.limit(container, quota)))
    name = _listed(data_context, container).name
    return limit_set(name, quota.names, quota.most_bytes)


async def erase_container(
    data_context: ContainerContext, erasing: ErasureCommands, container: str, by: PrincipalId
) -> str:
    """Erase a container for good: a person's with all their rights, a robot's or a chat's data.

    Raises:
        NotUnderstood, NotPermitted, RobotBusy, RecordUnavailable: As `ErasureCommands.erase`.
    """
    if container in data_context.robots or container.startswith(_CHAT):
        name = _listed(data_context, container).name
        await erasing.erase_other(container, by)
        return emptied(name)
    erased = await erasing.erase(container, by)
    return words.erased(erased.name, at_rest=erased.at_rest)


async def _known(data_context: ContainerContext, container: str) -> None:
    """See that there is such a container, without looking into it.

    Raises:
        NotUnderstood: There is none.
    """
    if (
        container not in data_context.robots
        and container not in await data_context.container_store.containers()
    ):
        raise NotUnderstood(words.NO_SUCH_CONTAINER)


async def _found(data_context: ContainerContext, container: str) -> tuple[Fact, ...]:
    """Return what a container holds; of a chat, all its entries, whoever sealed them."""
    found = await data_context.container_store.container_facts(container)
    if container.startswith(_CHAT):
        key = container.removeprefix(_CHAT)
        known = {(fact.kind, fact.key) for fact in found}
        entries = await all_facts(data_context.container_store, archive_records.ENTRY, f"{key}.")
        found = (*found, *(_open(f) for f in entries if (f.kind, f.key) not in known))
    if not found and container not in data_context.robots:
        raise NotUnderstood(words.NO_SUCH_CONTAINER)
    return found


def _open(fact: Fact) -> Fact:
    """Return what a chat's own container shows of an entry that is sealed in a person's."""
    return msgspec.structs.replace(fact, letter=None)


def _listed(data_context: ContainerContext, container: str) -> ListedContainer:
    if container in data_context.robots:
        return ListedContainer(ROBOT, container, data_context.shown(container))
    if not container.startswith(_CHAT):
        return ListedContainer(PERSON, container, data_context.name(container))
    kept = data_context.archive.all().get(container.removeprefix(_CHAT))
    venue = None if kept is None else kept.venue
    if venue is None:
        return ListedContainer(CHAT, container, container)
    where = f"{venue.messenger} {venue.chat.kind.value} {venue.chat.id}"
    return ListedContainer(CHAT, container, where)
