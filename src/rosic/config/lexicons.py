"""The lexicons that ship: ``locale/<language>/lexicon.toml``."""

from __future__ import annotations

import sys
import tomllib
from functools import cache
from pathlib import Path
from typing import Final

import msgspec

from rosic.core.language.lexicon import Lexicon, Phrasebook
from rosic.core.language.lexicon_compiler import compile_lexicons
from rosic.errors import ConfigurationError

SHIPPED: Final = Path(__file__).parents[1] / "locale"
FILE: Final = "lexicon.toml"


def read_lexicon(path: Path) -> Lexicon:
    """Read one file.

    Raises:
        ConfigurationError: It cannot be read, or says something that no lexicon has.
    """
    try:
        return msgspec.convert(tomllib.loads(path.read_text(encoding="utf-8")), Lexicon)
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError, msgspec.ValidationError) as why:
        raise ConfigurationError(f"This lexicon cannot be read: {why}", where=str(path)) from None


def read_lexicons(folder: Path) -> Phrasebook:
    """Read the lexicons of all languages below a folder, and check them against each other.

    Raises:
        ConfigurationError: One cannot be read, or two of them mean different things by a phrase.
    """
    lexicons = {path.parent.name: read_lexicon(path) for path in sorted(folder.glob(f"*/{FILE}"))}
    if not lexicons:
        raise ConfigurationError(f"There is no <language>/{FILE} here.", where=str(folder))
    try:
        return compile_lexicons(lexicons)
    except ValueError as why:
        raise ConfigurationError(f"{why}.", where=str(folder)) from None


@cache
def known_phrases() -> Phrasebook:
    """Return what ships, compiled once."""
    return read_lexicons(SHIPPED)


def main(arguments: list[str]) -> int:
    """Check the lexicons below a folder, and tell how many phrases each has."""
    folder = Path(arguments[0]) if arguments else SHIPPED
    try:
        book = read_lexicons(folder)
    except ConfigurationError as wrong:
        sys.stdout.write(f"{wrong}\n")
        return 1
    for table in book.tables:
        sys.stdout.write(f"{table.language}: {len(table.senses)} phrases\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
