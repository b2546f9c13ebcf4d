"""How ``rosic`` commands ask the gateway that runs on a data folder of the same machine."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.control_socket import ANSWER_BYTES, AdminAnswer, encode, socket_path
from rosic.errors import Fault, Refusal

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable
    from pathlib import Path

    from rosic.app.admin.api import AdminRequest

ANSWER_WITHIN_S = 60.0
AGAIN_EVERY_S = 0.1
STAND_STILL = "If a robot has to stand still now, use the switch on the robot itself."
# A gateway says at once that it has heard, however long the answer takes.
SLOW_AFTER_S = 2.0
HEARD_WITHIN_S = 10.0
# One whose socket was removed makes another by then.
SOCKET_WITHIN_S = 4.0

_decode_answer = msgspec.json.Decoder(AdminAnswer).decode


class NotRunning(Fault):
    """No gateway listens on this data."""

    code = "not-running"


async def ask_gateway(
    data: Path, ask: AdminRequest, tell: Callable[[str], object]
) -> AsyncIterator[AdminAnswer]:
    """Ask the gateway that runs on a data folder; yield its answers as they come.

    Args:
        data: The folder.
        ask: What.
        tell: Is told once when it does not even say that it has heard.

    Raises:
        NotRunning: None runs there.
        Fault: It runs and did not answer. Once it goes on it may still do what it was asked.
    """
    reader, writer = await _connection(data)
    try:
        async with asyncio.timeout(ANSWER_WITHIN_S):
            writer.write(encode(ask) + b"\n")
            await writer.drain()
            line = await _heard(reader, tell)
            while line:
                answer = _decode_answer(line)
                if answer.text:
                    yield answer
                if not answer.more:
                    return
                line = await reader.readline()
        raise Fault("The gateway turned this away: it belongs to another user, or it is closing.")
    except (OSError, TimeoutError, ValueError, msgspec.MsgspecError) as error:
        raise Fault("The gateway did not answer.") from error
    finally:
        writer.close()


async def attach_to_gateway(
    data: Path, ask: AdminRequest
) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    """Return a connection to the gateway of a data folder, which serves a program over it.

    Raises:
        NotRunning: None runs there.
        Refusal: It said why not.
        Fault: It runs and did not answer.
    """
    reader, writer = await _connection(data)
    try:
        writer.write(encode(ask) + b"\n")
        await writer.drain()
        async with asyncio.timeout(HEARD_WITHIN_S):
            answer = _decode_answer(await reader.readline())
        if answer.good:
            return reader, writer
    except (OSError, TimeoutError, ValueError, msgspec.MsgspecError) as error:
        writer.close()
        raise Fault("The gateway did not answer.") from error
    writer.close()
    raise Refusal(answer.text)


async def _connection(data: Path) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    """Return a connection to the gateway; one whose socket was removed is given time to mend it.

    Raises:
        NotRunning: None runs there.
        Fault: It runs and cannot be reached.
    """
    path = socket_path(data)
    end_s = time.monotonic() + SOCKET_WITHIN_S
    while True:
        try:
            return await asyncio.open_unix_connection(str(path), limit=ANSWER_BYTES)
        except (FileNotFoundError, NotADirectoryError, ConnectionRefusedError):
            from rosic.stores.data_dir import holder_of  # noqa: PLC0415 - a stop need not wait for it

            holder = holder_of(data)
            if not holder:
                raise NotRunning(f"No gateway is running on {data}.") from None
            if time.monotonic() > end_s:
                raise Fault(
                    f"The gateway on {data} (process {holder}) has no control socket, and makes "
                    f"none. {STAND_STILL}"
                ) from None
            await asyncio.sleep(AGAIN_EVERY_S)
        except OSError as error:
            raise Fault(f"The gateway cannot be asked ({error.strerror}).") from error


async def _heard(reader: asyncio.StreamReader, tell: Callable[[str], object]) -> bytes:
    """Return the first line of the gateway: that it has heard, or why it does not listen.

    Raises:
        Fault: It does not.
    """
    hearing = asyncio.ensure_future(reader.readline())
    try:
        await asyncio.wait((hearing,), timeout=SLOW_AFTER_S)
        if not hearing.done():
            tell(f"The gateway has not answered for {SLOW_AFTER_S:g} s. {STAND_STILL}")
            await asyncio.wait((hearing,), timeout=HEARD_WITHIN_S - SLOW_AFTER_S)
        if hearing.done():
            return hearing.result()
        raise Fault(
            f"The gateway has not answered for {HEARD_WITHIN_S:g} s: it hangs, or was halted. Once "
            "it goes on it may still do what it was asked."
        )
    finally:
        hearing.cancel()
