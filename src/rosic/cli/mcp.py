"""``rosic mcp``: standard input and output of a program, joined to the running gateway."""

from __future__ import annotations

import argparse
import asyncio
import os
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.admin.control_client import attach_to_gateway
from rosic.cli.client import add_where, data_of
from rosic.config.source_map import readable_by_others
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

ABOUT = """Let one program ask for what its key allows, over the Model Context Protocol: it writes
to this command's standard input, and reads its standard output. The gateway has to run, with a
messenger of kind mcp. The key is that of rosic key create."""
KEY: Final = "ROSIC_KEY"
PIECE_BYTES: Final = 65_536


def run(arguments: Sequence[str]) -> int:
    """Pass lines on both ways until one side ends. Return 0 if the program left, else 1.

    Raises:
        RosicError: Why not; nothing was passed on.
    """
    parser = argparse.ArgumentParser(prog="rosic mcp", description=ABOUT)
    parser.add_argument("--key-file", metavar="FILE", help=f"holds the key; else {KEY} does")
    add_where(parser)
    options = parser.parse_args(arguments)
    body = msgspec.Raw(msgspec.json.encode({"secret": _key(options.key_file)}))
    return asyncio.run(_joined(data_of(options), AdminRequest(AdminVerb.ATTACH, body=body)))


def _key(file: str | None) -> str:
    """Return the secret of a program's key.

    Raises:
        ConfigurationError: There is none, or others on this machine can read it.
    """
    if file is None:
        found = os.environ.get(KEY, "").strip()
    else:
        try:
            if readable_by_others(Path(file)):
                raise ConfigurationError(
                    f"Others may read {file}, which holds a key.", hint=f"Run: chmod 600 {file}"
                )
            found = Path(file).read_text(encoding="utf-8").strip()
        except (OSError, ValueError) as error:
            raise ConfigurationError(f"The key file {file} cannot be read.") from error
    if not found:
        raise ConfigurationError(
            "There is no key.", hint=f"Make one with rosic key create, and give it as {KEY}."
        )
    return found


async def _joined(data: Path, ask: AdminRequest) -> int:
    reader, writer = await attach_to_gateway(data, ask)
    asks: asyncio.Queue[bytes] = asyncio.Queue()
    loop = asyncio.get_running_loop()

    def take(piece: bytes) -> None:
        loop.call_soon_threadsafe(asks.put_nowait, piece)

    # A thread: standard input may be anything, and whoever waits for it is not waited for.
    threading.Thread(target=_read, args=(take,), daemon=True).start()
    asking = asyncio.create_task(_pass_on(asks, writer))
    answering = asyncio.create_task(_answers(reader))
    try:
        await asyncio.wait((asking, answering), return_when=asyncio.FIRST_COMPLETED)
        left = asking.done()
        if left:
            await answering  # what is under way is ended first, and said
        else:
            print("rosic: The gateway has ended.", file=sys.stderr)
        return 0 if left else 1
    finally:
        asking.cancel()
        answering.cancel()
        writer.close()


def _read(take: Callable[[bytes], None]) -> None:
    while piece := os.read(sys.stdin.fileno(), PIECE_BYTES):
        take(piece)
    take(b"")


async def _pass_on(asks: asyncio.Queue[bytes], writer: asyncio.StreamWriter) -> None:
    while piece := await asks.get():
        writer.write(piece)
        await writer.drain()
    writer.write_eof()


async def _answers(reader: asyncio.StreamReader) -> None:
    while piece := await reader.read(PIECE_BYTES):
        sys.stdout.buffer.write(piece)
        sys.stdout.buffer.flush()
