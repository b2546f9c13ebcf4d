"""The table of commands in docs/language.md, written from what is declared.

Run as ``python -m tests.commands``; a test finds a table that is not what is declared.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from rosic.app.features import command_table

if TYPE_CHECKING:
    from rosic.core.language.command import Command

PAGE: Final = Path(__file__).parents[1] / "docs" / "language.md"
BEGIN: Final = "<!-- commands: written by make texts -->\n"
END: Final = "<!-- end of commands -->\n"


def row(command: Command) -> str:
    """Return one line of the table."""
    other = ", ".join(f"`{word}`" for word in command.aliases)
    page = command.page or (command.help.page if command.help is not None else "")
    kinds = []
    if command.redacted_unless is not None:
        kinds.append("what stands behind it is not kept")
    if command.explained:
        kinds.append("says alone how it is said")
    what = "; ".join(filter(None, (str(command.summary), *kinds)))
    return f"| `/{command.name}` | {other} | {what} | {f'`help {page}`' if page else ''} |"


def table() -> str:
    """Return the table of every command that somebody may say."""
    said = sorted((c for c in command_table() if c.spoken and " " not in c.name), key=_name)
    head = ("| say | or | what it is for | more |", "|---|---|---|---|")
    return "\n".join((*head, *map(row, said))) + "\n"


def _name(command: Command) -> str:
    return command.name


def written(page: str) -> str:
    """Return a page with the table in its place."""
    head, _, rest = page.partition(BEGIN)
    _, _, tail = rest.partition(END)
    return f"{head}{BEGIN}{table()}{END}{tail}"


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
