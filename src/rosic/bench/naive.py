"""The naive sender: a plain loop that answers the same commands, to be compared with."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.bench.batches import ENDED, Batch, BatchFigures, BatchSite
from rosic.bench.stand_in import TOKEN
from rosic.messengers.telegram.bot_client import BotClient
from rosic.messengers.telegram.errors import ErrorKind, TelegramError
from rosic.messengers.telegram.settings import read_settings

if TYPE_CHECKING:
    from rosic.testing.telegram import Control


async def through_a_loop(control: Control, batch: Batch) -> BatchFigures:
    """Have a plain loop answer the same commands: it sends at once, and waits when it is told to.

    It has no commands to follow and nothing to write down; each outcome is one message.
    """
    place = BatchSite(control, batch)
    await place.prepare()
    await place.command()
    settings = read_settings("bench", {"token": TOKEN, "api_base": control.api_base})
    line = BotClient(settings)
    said = {person: await control.messages(person) for person in place.people}
    waiting = [
        (person, said[person][number]["message_id"])
        for number in range(batch.commands // batch.chats)
        for person in place.people
    ]
    async with line.held():
        for person, message in waiting:
            await _send_at_once(line, person, message)
    return await place.found((), 0, 0)


async def _send_at_once(line: BotClient, person: int, message: int) -> None:
    while True:
        try:
            await line.ask(
                lambda bot: bot.send_message(
                    person, f"robot: go\n{ENDED}now", reply_to_message_id=message
                )
            )
        except TelegramError as trouble:
            if trouble.kind is not ErrorKind.TOO_FAST:
                raise
            await asyncio.sleep(trouble.wait_s)
        else:
            return
