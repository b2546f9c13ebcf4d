"""``rosic picture``, ``rosic file``: what robots show, and files, of a gateway elsewhere."""

from __future__ import annotations

import argparse
import hashlib
import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rosic.cli.remote import add_gateway, print_json, run_there, there
from rosic.container.file_messages import amount
from rosic.core.i18n import plain
from rosic.errors import ConfigurationError, Fault, OutOfBounds

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.api.resource_schemas import FileOut
    from rosic.client import RosicClient

LARGEST: Final = 25_000_000
"""What is larger is not kept there."""

# ---- ``rosic picture`` ----

PICTURE_ABOUT = """Save what a robot of a gateway elsewhere sees, or its map, as an image."""


def picture(arguments: Sequence[str]) -> int:
    """Save a picture.

    Raises:
        RosicError: Why not; no file was left.
    """
    parser = argparse.ArgumentParser(prog="rosic picture", description=PICTURE_ABOUT)
    parser.add_argument("robot", metavar="ROBOT")
    parser.add_argument("file", metavar="FILE", help="is made; nothing is replaced")
    parser.add_argument("--map", action="store_true", help="its map, with where it is")
    parser.add_argument("--low", action="store_true", help="small, for a slow line")
    add_gateway(parser)
    options = parser.parse_args(arguments)
    return run_there(options, there(options), lambda client: _picture(client, options))


async def _picture(client: RosicClient, options: argparse.Namespace) -> int:
    path = _free(options.file)
    low = options.low
    shown = await client.picture(options.robot, "map" if options.map else "picture", low=low)
    _save(path, shown.content)
    print(plain(f"{path}: {shown.media_type}, {amount(len(shown.content))}, {shown.taken}"))
    return 0


# ---- ``rosic file`` ----

LIST_ABOUT = """The files that you keep at a gateway elsewhere."""
SEND_ABOUT = """Keep files at a gateway elsewhere, as one sends them in a chat."""
GET_ABOUT = """Save a file that you keep at a gateway elsewhere."""
DELETE_ABOUT = """Delete a file that you keep at a gateway elsewhere, for good."""
WHICH = "its name, or its id"


def list_files(arguments: Sequence[str]) -> int:
    """Print them.

    Raises:
        RosicError: Why not.
    """
    parser = argparse.ArgumentParser(prog="rosic file list", description=LIST_ABOUT)
    parser.add_argument("--json", action="store_true", help="one list, for programs")
    add_gateway(parser)
    options = parser.parse_args(arguments)
    return run_there(options, there(options), lambda client: _list(client, json=options.json))


async def _list(client: RosicClient, *, json: bool) -> int:
    found = await client.files()
    if json:
        print_json(found)
    for one in () if json else found:
        print(_line(one))
    return 0


def _line(one: FileOut) -> str:
    return plain(f"{one.at}  {one.name}  {amount(one.size)}  {one.id}")


def send_file(arguments: Sequence[str]) -> int:
    """Send files, one after another.

    Raises:
        RosicError: Why not; those before were kept.
    """
    parser = argparse.ArgumentParser(prog="rosic file send", description=SEND_ABOUT)
    parser.add_argument("files", metavar="FILE", nargs="+")
    add_gateway(parser)
    options = parser.parse_args(arguments)
    return run_there(options, there(options), lambda client: _send(client, options.files))


async def _send(client: RosicClient, names: Sequence[str]) -> int:
    for name in names:
        path = Path(name)
        kept = await client.send_file(path.name, _content(path))
        print(_line(kept), flush=True)
    return 0


def _content(path: Path) -> bytes:
    """Return what is in a file.

    Raises:
        OutOfBounds: It is too large to be kept.
        ConfigurationError: It cannot be read.
    """
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except OSError as error:
        raise ConfigurationError(f"{path} cannot be read ({error.strerror}).") from error
    if len(content) > LARGEST:
        raise OutOfBounds(f"{path} is larger than {amount(LARGEST)}. It was not sent.")
    return content


def get_file(arguments: Sequence[str]) -> int:
    """Save one.

    Raises:
        RosicError: Why not; no file was left.
    """
    parser = argparse.ArgumentParser(prog="rosic file get", description=GET_ABOUT)
    parser.add_argument("name", metavar="NAME", help=WHICH)
    parser.add_argument("file", metavar="FILE", help="is made; nothing is replaced")
    add_gateway(parser)
    options = parser.parse_args(arguments)
    return run_there(options, there(options), lambda client: _get(client, options))


async def _get(client: RosicClient, options: argparse.Namespace) -> int:
    path = _free(options.file)
    one = await _found(client, options.name)
    content = await client.file_content(one.id)
    if hashlib.sha256(content).hexdigest() != one.sha256:
        raise Fault(f"{one.name} did not come as it is kept there. Nothing was saved; try again.")
    _save(path, content)
    print(plain(f"{path}: {amount(len(content))}"))
    return 0


def delete_file(arguments: Sequence[str]) -> int:
    """Delete one.

    Raises:
        RosicError: Why not; it is kept still.
    """
    parser = argparse.ArgumentParser(prog="rosic file delete", description=DELETE_ABOUT)
    parser.add_argument("name", metavar="NAME", help=WHICH)
    add_gateway(parser)
    options = parser.parse_args(arguments)
    return run_there(options, there(options), lambda client: _delete(client, options.name))


async def _delete(client: RosicClient, name: str) -> int:
    one = await _found(client, name)
    await client.delete_file(one.id)
    print(plain(f"{one.name} is deleted."))
    return 0


async def _found(client: RosicClient, name: str) -> FileOut:
    """Return the one that is meant.

    Raises:
        OutOfBounds: There is none, or several of that name.
    """
    found = [one for one in await client.files() if name in {one.id, one.name}]
    if not found:
        raise OutOfBounds(f"You keep no file {name!r} there. See: rosic file list")
    if len(found) > 1:
        raise OutOfBounds(f"You keep {len(found)} files {name!r} there. Say the id of one.")
    return found[0]


def _free(name: str) -> Path:
    """Return where something can be saved.

    Raises:
        ConfigurationError: Something is there already.
    """
    path = Path(name)
    if path.exists():
        raise ConfigurationError(f"{path} is there already.", hint="Name another file.")
    return path


def _save(path: Path, content: bytes) -> None:
    """Write a new file that nobody else may read.

    Raises:
        ConfigurationError: It cannot be made or written; nothing is left of it.
    """
    try:
        number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except OSError as error:
        raise ConfigurationError(f"{path} cannot be made ({error.strerror}).") from error
    try:
        with os.fdopen(number, "wb") as file:
            file.write(content)
    except OSError as error:
        with suppress(OSError):
            path.unlink()
        raise ConfigurationError(f"{path} cannot be written ({error.strerror}).") from error
