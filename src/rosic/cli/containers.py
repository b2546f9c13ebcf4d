"""``rosic container list``, ``show``, ``export``, ``limit`` and ``erase``: what is kept."""

from __future__ import annotations

import argparse
import os
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.cli.client import add_where, changed, looked_up
from rosic.container import export
from rosic.errors import ConfigurationError, OutOfBounds
from rosic.features.personal_data import operator_view as words
from rosic.features.personal_data.operator_view import ListedContainer, ShownContainer, shown, table

if TYPE_CHECKING:
    from collections.abc import Sequence


# ---- ``rosic container list`` ----

LIST_ABOUT = """Every container: robots', people's, and those of chats whose messages are kept.
Works with and without a running gateway."""


def list_containers(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs.

    Raises:
        RosicError: Why not.
    """
    parser = argparse.ArgumentParser(prog="rosic container list", description=LIST_ABOUT)
    parser.add_argument("--json", action="store_true", help="one list, for programs")
    add_where(parser)
    options = parser.parse_args(arguments)
    answers = looked_up(options, AdminRequest(AdminVerb.CONTAINERS), robots=True)
    found = [
        one for text in answers for one in msgspec.json.decode(text, type=list[ListedContainer])
    ]
    print(msgspec.json.encode(found).decode() if options.json else table(found))
    return 0


# ---- ``rosic container show`` ----

SHOW_ABOUT = """How much of what one container holds, and what it may keep. Works with and without a
running gateway."""


def show(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs.

    Raises:
        RosicError: Why not.
    """
    parser = argparse.ArgumentParser(prog="rosic container show", description=SHOW_ABOUT)
    parser.add_argument("name", metavar="NAME", help="a robot, a person, or an id of the list")
    parser.add_argument("--json", action="store_true", help="one object, for programs")
    add_where(parser)
    options = parser.parse_args(arguments)
    [text] = looked_up(options, AdminRequest(AdminVerb.CONTAINER, (options.name,)), robots=True)
    print(text if options.json else shown(msgspec.json.decode(text, type=ShownContainer)))
    return 0


# ---- ``rosic container export`` ----

EXPORT_ABOUT = """Everything in a container, unsealed, as a file that only you can read. Nothing
that exists is written over. As JSON lines, as lines of text or as a spreadsheet. Works with and
without a running gateway; without one it takes the root key in the data folder."""
CHAT = "chat-"


def export_container(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs, and write the file.

    Raises:
        RosicError: Why not; there is no file.
    """
    parser = argparse.ArgumentParser(prog="rosic container export", description=EXPORT_ABOUT)
    parser.add_argument("name", metavar="NAME", help="a robot, a person, or an id of the list")
    parser.add_argument("--as", dest="form", choices=tuple(export.ENDINGS), default="jsonl")
    parser.add_argument("-o", dest="file", metavar="FILE", help="instead of NAME and its ending")
    add_where(parser)
    options = parser.parse_args(arguments)
    named = None if options.file is None else Path(options.file)
    if named is not None:
        _check_free(named)
    container, *texts = looked_up(
        options, AdminRequest(AdminVerb.CONTENT, (options.name,)), robots=True
    )
    lines = [line for text in texts for line in text.split("\n")]
    content = _made(container, lines, options.form)
    path = named or Path(f"{container}.{export.ENDINGS[options.form]}")
    _write(path, content)
    print(words.written(str(path), len(lines)))
    return 0


def _made(container: str, lines: Sequence[str], form: str) -> bytes:
    """Return what goes into the file."""
    if form == "jsonl":
        return "".join(f"{line}\n" for line in lines).encode()
    if container.startswith(CHAT):
        made = export.archive_as(form, [export.read_row(line) for line in lines])
    else:
        made = export.container_as(form, map(export.read_thing, lines))
    return made if isinstance(made, bytes) else f"{made}\n".encode()


def _check_free(path: Path) -> None:
    if os.path.lexists(path):
        raise ConfigurationError(
            f"{path} exists. Nothing was written.", hint="Name another file with -o."
        )


def _write(path: Path, content: bytes) -> None:
    _check_free(path)
    try:
        opened = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600)
    except OSError as error:
        raise ConfigurationError(f"{path} cannot be written ({error.strerror}).") from error
    try:
        with os.fdopen(opened, "wb") as file:
            file.write(content)
    except OSError as error:
        path.unlink(missing_ok=True)
        raise ConfigurationError(f"{path} cannot be written ({error.strerror}).") from error


# ---- ``rosic container limit`` ----

LIMIT_ABOUT = """Say how much shared data one container may keep, from now on; no other is touched.
Works with and without a running gateway."""
_SIZE = re.compile(r"(\d{1,12})\s*(bytes|b|kib|k|mib|m)?", re.IGNORECASE)
_UNITS = {"": 1, "b": 1, "bytes": 1, "k": 1024, "kib": 1024, "m": 1024**2, "mib": 1024**2}


def limit(arguments: Sequence[str]) -> int:
    """Ask the gateway, or write it into its data when none runs.

    Raises:
        RosicError: Why not; nothing was changed.
    """
    parser = argparse.ArgumentParser(prog="rosic container limit", description=LIMIT_ABOUT)
    parser.add_argument("name", metavar="NAME", help="a robot, a person, or an id of the list")
    parser.add_argument("--names", metavar="N", help="different names at most")
    parser.add_argument("--size", metavar="SIZE", help="of everything at most: 64KiB, 1MiB")
    add_where(parser)
    options = parser.parse_args(arguments)
    if options.names is None and options.size is None:
        raise OutOfBounds("Say what the limit is, with --names 64 or --size 64KiB.")
    asked = {
        "names": None if options.names is None else _count("--names", options.names),
        "most_bytes": None if options.size is None else _count("--size", options.size),
    }
    body = msgspec.Raw(msgspec.json.encode(asked))
    print(
        "\n".join(
            changed(options, AdminRequest(AdminVerb.LIMIT, (options.name,), body), robots=True)
        )
    )
    return 0


def _count(option: str, text: str) -> int:
    found = _SIZE.fullmatch(text.strip())
    unit = "" if found is None or found[2] is None else found[2].casefold()
    if found is None or (unit and option == "--names"):
        like = "64" if option == "--names" else "64KiB"
        raise OutOfBounds(f"I cannot read {option} {text!r}. Write {option} {like}.")
    return int(found[1]) * _UNITS[unit]


# ---- ``rosic container erase`` ----

ERASE_ABOUT = """Erase a container for good, by its key. With a person's goes every right of theirs:
what they move comes to rest first. Ids and numbers stay in the record of decisions. Needs a running
gateway."""


def erase(arguments: Sequence[str]) -> int:
    """Ask once, then ask the gateway.

    Raises:
        RosicError: Why not; nothing was erased, unless the sentence says so.
    """
    parser = argparse.ArgumentParser(prog="rosic container erase", description=ERASE_ABOUT)
    parser.add_argument("name", metavar="NAME", help="a robot, a person, or an id of the list")
    parser.add_argument("--yes", action="store_true", help="do not ask whether it is meant")
    add_where(parser)
    options = parser.parse_args(arguments)
    if not options.yes and not _meant(options.name):
        raise ConfigurationError(
            "Nothing was erased.", hint=f"rosic container erase {options.name} --yes does not ask."
        )
    print("\n".join(changed(options, AdminRequest(AdminVerb.ERASE, (options.name,)), robots=True)))
    return 0


def _meant(name: str) -> bool:
    """Ask somebody at a terminal to write the name once more."""
    if not sys.stdin.isatty():
        return False
    try:
        return input(f"Erase everything of {name}, for good? Write the name again: ") == name
    except EOFError:
        print()
        return False
