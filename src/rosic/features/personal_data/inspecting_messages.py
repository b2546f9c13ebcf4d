"""Every sentence and every table that the operator is shown about containers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.container.messages import size
from rosic.core.i18n import said, said_n

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.features.personal_data.operator_view import ListedContainer, ShownContainer

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
    return "\n".join(
        f"{one.kind:<6}  {one.container:<{wide}}  {one.name if one.name != one.container else ''}"
        .rstrip()
        for one in listed
    )  # fmt: skip


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
