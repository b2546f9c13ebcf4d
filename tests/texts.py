"""Keeps the catalogues: what the code says, in every language under ``src/rosic/locale``.

``make texts`` brings each ``rosic.po`` up to date with the code and compiles its ``rosic.mo``.
``make texts LANGUAGE=fr`` begins another language.
"""

from __future__ import annotations

import ast
import io
import sys
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from babel.messages.catalog import Catalog
from babel.messages.mofile import write_mo
from babel.messages.pofile import read_po, write_po

if TYPE_CHECKING:
    from collections.abc import Iterator

SOURCE = Path(__file__).parents[1] / "src"
LOCALE = SOURCE / "rosic" / "locale"
DOMAIN = "rosic"

Template = str | tuple[str, str]


class NotLiteral(Exception):
    """A sentence whose template is not written out, so that nobody can collect it."""


@cache
def templates() -> dict[Template, list[str]]:
    """Return every template in the code, and the files it is in; in the order of the files."""
    found: dict[Template, list[str]] = {}
    for path in sorted(SOURCE.rglob("*.py")):
        for template in templates_in(path.read_text(encoding="utf-8"), str(path)):
            where = found.setdefault(template, [])
            if (name := path.relative_to(SOURCE).as_posix()) not in where:
                where.append(name)
    return found


def templates_in(text: str, name: str) -> Iterator[Template]:
    """Yield the templates of one module.

    Raises:
        NotLiteral: One of them is not written out.
    """
    calls = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call)]
    for call in sorted(calls, key=lambda call: (call.lineno, call.col_offset)):
        if not isinstance(call.func, ast.Name) or call.func.id not in ("said", "said_n"):
            continue
        forms = [
            arg.value
            for arg in call.args[: 1 if call.func.id == "said" else 2]
            if isinstance(arg, ast.Constant) and isinstance(arg.value, str) and arg.value
        ]
        if len(forms) != (1 if call.func.id == "said" else 2):
            raise NotLiteral(f"{name}:{call.lineno}")
        yield forms[0] if len(forms) == 1 else (forms[0], forms[1])


def po_of(language: str) -> Path:
    """Return where the texts of a language are kept."""
    return LOCALE / language / "LC_MESSAGES" / f"{DOMAIN}.po"


def read(language: str) -> Catalog:
    """Read the texts of a language."""
    with po_of(language).open("rb") as file:
        return read_po(file, locale=language, domain=DOMAIN)


def renewed(catalogue: Catalog) -> Catalog:
    """Return the texts with what the code says now: what is new is empty, what is gone is gone."""
    fresh = Catalog(
        locale=catalogue.locale,
        domain=DOMAIN,
        project="ROSIC",
        version="1",
        msgid_bugs_address="the project",
        header_comment="# What ROSIC says. Fields in braces stay as they are; so do commands.",
        creation_date=catalogue.creation_date,
        revision_date=catalogue.revision_date,
        last_translator="The ROSIC authors",
        language_team="The ROSIC authors",
        fuzzy=False,
    )
    for template, files in templates().items():
        one = template if isinstance(template, str) else template[0]
        before = catalogue.get(one)
        said = before.string if before is not None and before.id == template else ""
        fresh.add(
            template,
            said or (() if isinstance(template, tuple) else ""),
            locations=[(file, 1) for file in files],
        )
    return fresh


def written(catalogue: Catalog) -> bytes:
    """Return the text file of a catalogue."""
    file = io.BytesIO()
    write_po(file, catalogue, width=100, include_lineno=False)
    return file.getvalue()


def compiled(catalogue: Catalog) -> bytes:
    """Return what ships: what ``gettext`` reads."""
    file = io.BytesIO()
    write_mo(file, catalogue)
    return file.getvalue()


def languages() -> list[str]:
    """Return every language there is a file for."""
    return sorted(path.parents[1].name for path in LOCALE.glob(f"*/LC_MESSAGES/{DOMAIN}.po"))


def renew(language: str) -> Catalog:
    """Bring a language up to date, and compile it."""
    po = po_of(language)
    po.parent.mkdir(parents=True, exist_ok=True)
    fresh = renewed(read(language) if po.exists() else Catalog(locale=language, domain=DOMAIN))
    po.write_bytes(written(fresh))
    po.with_suffix(".mo").write_bytes(compiled(fresh))
    return fresh


def main() -> None:
    """Renew every language, and those that are named."""
    for language in sorted({*languages(), *sys.argv[1:]}):
        texts = [message for message in renew(language) if message.id]
        empty = sum(
            not (m.string if isinstance(m.string, str) else all(m.string or [""])) for m in texts
        )
        print(f"{language}: {len(texts)} texts, {empty} without a translation")  # noqa: T201


if __name__ == "__main__":
    main()
