"""``rosic container export``: what a container holds, as a file."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.cli.client import add_where
from rosic.cli.desk import looked_up
from rosic.container import export
from rosic.errors import ConfigurationError
from rosic.features.personal_data import operator_view as words

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Everything in a container, unsealed, as a file that only you can read. Nothing that
exists is written over. As JSON lines, as lines of text or as a spreadsheet. Works with and without
a running gateway; without one it takes the root key in the data folder."""
CHAT = "chat-"


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs, and write the file.

    Raises:
        RosicError: Why not; there is no file.
    """
    parser = argparse.ArgumentParser(prog="rosic container export", description=ABOUT)
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
