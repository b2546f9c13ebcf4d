"""`python -m rosic.testing.telegram`: the server as a program of its own."""

from __future__ import annotations

import argparse
import asyncio
import signal
import sys
from pathlib import Path

from msgspec.structs import replace

from rosic.testing.telegram.server import DEFAULT_TOKEN, FakeTelegram
from rosic.testing.telegram.settings import Limits, Settings

LOCAL_BYTES = 2000 * 1024 * 1024


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        prog="python -m rosic.testing.telegram",
        description="A strict stand-in for Telegram's Bot API, for tests. It prints `ready URL`.",
    )
    parser.add_argument("--port", type=int, default=0, help="0 takes a free one")
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument(
        "--token", default=DEFAULT_TOKEN, help="the one token that works (without it %(default)s)"
    )
    parser.add_argument("--state", type=Path, help="kept here over a restart")
    parser.add_argument("--no-limits", action="store_true", help="no flood limits")
    parser.add_argument("--no-privacy", action="store_true", help="the bot reads all of a group")
    parser.add_argument("--username", default=Settings().bot_username, help="without the @")
    parser.add_argument(
        "--local",
        type=Path,
        metavar="FOLDER",
        help="as a Bot API server of one's own: files of up to 2000 MB, left in this folder",
    )
    return parser.parse_args()


def settings_of(options: argparse.Namespace) -> Settings:
    """Return the settings that were asked for."""
    settings = Settings(privacy=not options.no_privacy, bot_username=options.username)
    if options.local is None:
        return settings
    return replace(
        settings,
        local_folder=str(options.local.absolute()),
        max_upload_bytes=LOCAL_BYTES,
        max_download_bytes=LOCAL_BYTES,
    )


async def serve(options: argparse.Namespace) -> None:
    """Serve until SIGTERM or SIGINT."""
    server = FakeTelegram(
        token=options.token,
        port=options.port,
        limits=None if options.no_limits else Limits(),
        settings=settings_of(options),
        state_file=options.state,
    )
    server.host = options.host
    stop = asyncio.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        asyncio.get_running_loop().add_signal_handler(number, stop.set)
    async with server:
        sys.stdout.write(f"ready {server.url}\n")
        sys.stdout.flush()
        await stop.wait()


if __name__ == "__main__":
    asyncio.run(serve(arguments()))
