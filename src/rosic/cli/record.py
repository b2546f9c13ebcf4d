"""``rosic record FILE``: what is asked of robots beside what moves, as an MCAP file."""

from __future__ import annotations

import argparse
import asyncio
import os
import signal
import sys
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Final

import msgspec

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.admin.control_client import attach_to_gateway
from rosic.cli.client import add_where, data_of, joined, seconds
from rosic.container.file_messages import amount
from rosic.errors import ConfigurationError
from rosic.foxglove.recorder import recorder

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Record what is asked of robots of the running gateway beside what moves: an MCAP file
that Foxglove opens. Without --for it goes on until Ctrl-C. Only the owner of the file may read it:
orders of people stand in it."""
PIECE_BYTES: Final = 262_144
MAGIC: Final = b"\x89MCAP0\r\n"
LONGEST_S: Final = 86_400.0
REPAIRED_AT_MOST: Final = 256_000_000


def run(arguments: Sequence[str]) -> int:
    """Record into a file. Return 0 if it is whole, else 1.

    Raises:
        RosicError: Why not; no file was left.
    """
    parser = argparse.ArgumentParser(prog="rosic record", description=ABOUT)
    parser.add_argument("file", metavar="FILE", help="is made; nothing is replaced")
    parser.add_argument(
        "--robot", metavar="ROBOT", action="append", default=[], help="or a group; again for more"
    )
    parser.add_argument("--for", dest="lasts", metavar="5min", help="how long, a day at most")
    parser.add_argument("--camera", action="store_true", help="with what their cameras show")
    add_where(parser)
    options = parser.parse_args(joined(arguments, ("--for",)))
    for_s = LONGEST_S if options.lasts is None else seconds("--for", options.lasts)
    if for_s > LONGEST_S:
        raise ConfigurationError(f"--for {options.lasts} is longer than a day.")
    body = msgspec.Raw(msgspec.json.encode({"for_s": for_s, "pictures": options.camera}))
    ask = AdminRequest(AdminVerb.RECORD, names=tuple(options.robot), body=body)
    path, data = Path(options.file), data_of(options)
    with _made(path) as file:
        try:
            whole = asyncio.run(_recorded(data, ask, file))
        except BaseException:
            if not file.tell():
                path.unlink(missing_ok=True)
            raise
        size = file.tell()
    if whole:
        print(f"{path}: {amount(size)}. Foxglove opens it.")
        return 0
    print(_broken_off(path, size), file=sys.stderr)
    return 1


def _made(path: Path) -> BinaryIO:
    """Return a new file that nobody else may read.

    Raises:
        ConfigurationError: It is there already, or cannot be made.
    """
    try:
        number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except FileExistsError as error:
        raise ConfigurationError(
            f"{path} is there already. Nothing was recorded.", hint="Name another file."
        ) from error
    except OSError as error:
        raise ConfigurationError(f"{path} cannot be made ({error.strerror}).") from error
    return os.fdopen(number, "wb")


async def _recorded(data: Path, ask: AdminRequest, file: BinaryIO) -> bool:
    """Write what comes until it ends. Return whether it ends as a whole file does."""
    reader, writer = await attach_to_gateway(data, ask)
    loop, tail = asyncio.get_running_loop(), b""
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, _end, writer)
    print("Recording. Ctrl-C ends it.", file=sys.stderr, flush=True)
    try:
        while piece := await reader.read(PIECE_BYTES):
            file.write(piece)
            file.flush()  # what is here outlives this command
            tail = (tail + piece)[-len(MAGIC) :]
    except OSError as error:
        print(f"It could not be written any further ({error.strerror}).", file=sys.stderr)
        return False
    finally:
        writer.close()
    return tail == MAGIC and file.tell() > len(MAGIC)


def _end(writer: asyncio.StreamWriter) -> None:
    if writer.can_write_eof() and not writer.is_closing():
        writer.write_eof()


def _broken_off(path: Path, size: int) -> str:
    """Make a whole file of one that was broken off, if that can be; return what became of it."""
    able = recorder()
    if able is not None and 0 < size <= REPAIRED_AT_MOST:
        whole = able.repair(path.read_bytes())
        if whole:
            beside = path.with_name(f".{path.name}.whole")
            try:
                with _made(beside) as file:
                    file.write(whole)
                beside.replace(path)
            except (OSError, ConfigurationError):
                beside.unlink(missing_ok=True)
            else:
                return f"{path} was broken off. What was written before is whole in it now."
    return f"{path} was broken off. It can be read up to its last part: mcap recover {path}."
