"""Another chat bot in a process of its own: `rosic.bench.peers` runs this file by its path.

The interpreter is that of the bot's own environment, so nothing of ROSIC is imported, and of the
bots only the one that is asked for. Messages are handed over in memory, and answers taken so.

Arguments: the bot, how many skills it has (0 makes a bot of Telegram whose handler does nothing),
and its event loop, ``asyncio`` or ``uvloop``. It prints its version as JSON, and then, for each
line of two numbers (how many messages, how many in flight), what `rosic.bench.orders.OrderTurn`
holds.
"""

from __future__ import annotations

import asyncio
import json
import sys
import tempfile
import time
from collections import deque
from contextlib import asynccontextmanager
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

    Send = Callable[[int], Awaitable[int]]
    """Send the message of a number; return how long it took until it was answered, in ns."""

PEOPLE = 10
TOKEN = "1:bench"  # noqa: S105 - of nobody
WITHIN_S = 60
SAID = "robot0 skill0 0.5 m forward"
ASKED = r"robot0 skill{} (?P<distance>\d+(\.\d+)?) m (?P<direction>forward|back)"


class AnswerCount:
    """How many messages were answered, or came to a handler that does nothing."""

    def __init__(self) -> None:
        self.made = 0

    def add(self) -> None:
        """Count one."""
        self.made += 1

    def restart(self) -> None:
        """Count from none again."""
        self.made = 0


def update(number: int) -> dict[str, Any]:
    """Return an update of Telegram's Bot API, taken apart."""
    person = 7_000_000_001 + number % PEOPLE
    who = {"id": person, "is_bot": False, "first_name": "Person", "language_code": "en"}
    return {
        "update_id": 1_000 + number,
        "message": {
            "message_id": 1_000 + number,
            "date": int(time.time()),
            "from": who,
            "chat": {"id": person, "type": "private", "first_name": "Person"},
            "text": SAID,
        },
    }


def payload(number: int) -> bytes:
    """Return the answer of Telegram's that brings an update, as a connection gives it."""
    return json.dumps({"ok": True, "result": [update(number)]}).encode()


def answered(method: str) -> dict[str, Any]:
    """Return what Telegram answers to what a bot asks of it."""
    bot = {"id": 1, "is_bot": True, "first_name": "bench", "username": "bench_bot"}
    if method == "getMe":
        return {"ok": True, "result": bot}
    chat = {"id": 7_000_000_001, "type": "private", "first_name": "Person"}
    sent = {"message_id": 1, "date": int(time.time()), "from": bot, "chat": chat, "text": "done"}
    return {"ok": True, "result": sent}


# ---- bots on asyncio ----


def memory_request(answers: AnswerCount) -> Any:
    """Return what stands for a connection of python-telegram-bot."""
    from telegram.request import BaseRequest

    class MemoryRequest(BaseRequest):
        read_timeout = 5.0

        async def initialize(self) -> None: ...
        async def shutdown(self) -> None: ...

        async def do_request(
            self, url: str, method: str, request_data: Any = None, *_more: Any, **_times: Any
        ) -> tuple[int, bytes]:
            _ = method, request_data and request_data.json_parameters
            answers.add()
            return 200, json.dumps(answered(url.rpartition("/")[2])).encode()

    return MemoryRequest()


@asynccontextmanager
async def telegram(skills: int, answers: AnswerCount) -> AsyncIterator[Send]:
    """Run an application of python-telegram-bot, its connection replaced by memory."""
    from telegram import Update
    from telegram.ext import Application, MessageHandler, filters
    from telegram.request import BaseRequest

    called_ns = 0

    async def nothing(_update: Any, _context: Any) -> None:
        nonlocal called_ns
        called_ns = time.perf_counter_ns()
        answers.add()

    async def answer(update: Any, context: Any) -> None:
        await update.message.reply_text(f"done {context.match.group('distance')}")

    builder = Application.builder().token(TOKEN).updater(None).request(memory_request(answers))
    application = builder.get_updates_request(memory_request(answers)).build()
    if not skills:
        application.add_handler(MessageHandler(filters.ALL, nothing))
    for number in range(skills):
        asked = filters.Regex(ASKED.format(number))
        application.add_handler(MessageHandler(asked, answer))

    async def send(number: int) -> int:
        raw = update(number)
        began_ns = time.perf_counter_ns()
        await application.process_update(Update.de_json(raw, application.bot))
        return time.perf_counter_ns() - began_ns

    async def receive(number: int) -> int:
        came = payload(number)
        began_ns = time.perf_counter_ns()
        (raw,) = BaseRequest.parse_json_payload(came)["result"]
        await application.process_update(Update.de_json(raw, application.bot))
        return called_ns - began_ns

    async with application:
        yield send if skills else receive


def memory_session(answers: AnswerCount) -> Any:
    """Return what stands for a connection of aiogram."""
    from aiogram.client.session.base import BaseSession

    class MemorySession(BaseSession):
        async def close(self) -> None: ...

        async def make_request(self, bot: Any, method: Any, timeout: Any = None) -> Any:  # noqa: ASYNC109
            del timeout
            for value in method.model_dump(warnings=False).values():
                self.prepare_value(value, bot=bot, files={})
            answers.add()
            said = json.dumps(answered(method.__api_method__))
            return self.check_response(bot=bot, method=method, status_code=200, content=said).result

        async def stream_content(self, *_args: Any, **_more: Any) -> Any:
            raise NotImplementedError
            yield b""

    return MemorySession()


@asynccontextmanager
async def aiogram(skills: int, answers: AnswerCount) -> AsyncIterator[Send]:
    """Run a dispatcher of aiogram, its connection replaced by memory."""
    from aiogram import Bot, Dispatcher, F

    called_ns = 0

    async def nothing(_message: Any) -> None:
        nonlocal called_ns
        called_ns = time.perf_counter_ns()
        answers.add()

    async def answer(message: Any, asked: Any) -> None:
        await message.answer(f"done {asked.group('distance')}")

    bot = Bot(TOKEN, session=memory_session(answers))
    dispatcher = Dispatcher()
    if not skills:
        dispatcher.message.register(nothing)
    for number in range(skills):
        dispatcher.message.register(answer, F.text.regexp(ASKED.format(number)).as_("asked"))

    async def send(number: int) -> int:
        raw = update(number)
        began_ns = time.perf_counter_ns()
        await dispatcher.feed_raw_update(bot, raw)
        return time.perf_counter_ns() - began_ns

    async def receive(number: int) -> int:
        came = payload(number)
        began_ns = time.perf_counter_ns()
        (raw,) = bot.session.json_loads(came)["result"]
        await dispatcher.feed_raw_update(bot, raw)
        return called_ns - began_ns

    yield send if skills else receive


def memory_connector(bot: Any, answers: AnswerCount) -> Any:
    """Return what stands for a connection of opsdroid."""
    from opsdroid.connector import Connector, register_event
    from opsdroid.events import Message

    class MemoryConnector(Connector):  # type: ignore[misc, unused-ignore]
        async def connect(self) -> None: ...
        async def listen(self) -> None: ...

        @register_event(Message)  # type: ignore[untyped-decorator, unused-ignore]
        async def say(self, _message: Any) -> None:
            answers.add()

    return MemoryConnector({"name": "memory"}, bot)


def opsdroid_skill(number: int) -> Any:
    """Return a skill of opsdroid."""
    from opsdroid.matchers import match_regex

    @match_regex(ASKED.format(number))  # type: ignore[untyped-decorator, unused-ignore]
    async def act(_opsdroid: Any, _config: Any, message: Any) -> None:
        await message.respond(f"done {message.get_entity('distance')}")

    return act


def opsdroid(skills: int) -> None:
    """Run opsdroid in the event loop that it makes, with a connector in memory."""
    from opsdroid.cli.utils import configure_lang
    from opsdroid.core import OpsDroid
    from opsdroid.events import Message

    configure_lang({})
    answers = AnswerCount()

    with OpsDroid(config={}) as bot:
        connector = memory_connector(bot, answers)
        bot.connectors.append(connector)
        for number in range(skills):
            bot.register_skill(opsdroid_skill(number), {"name": f"skill{number}"})

        async def send(number: int) -> int:
            person = f"person {number % PEOPLE}"
            began_ns = time.perf_counter_ns()
            await bot.parse(Message(SAID, user=person, target=person, connector=connector))
            return time.perf_counter_ns() - began_ns

        print(json.dumps(version("opsdroid")), flush=True)
        for line in sys.stdin:
            bot.eventloop.run_until_complete(take_turn(send, answers, *map(int, line.split())))


async def take_turn(send: Send, answers: AnswerCount, messages: int, in_flight: int) -> None:
    """Send messages, so many at the same time, and print what was seen.

    Raises:
        RuntimeError: Not each of them was answered.
    """
    answers.restart()
    times_ns: list[int] = []
    numbers = iter(range(messages))

    async def lane() -> None:
        for number in numbers:
            times_ns.append(await send(number))  # noqa: PERF401 - lanes share it

    began, began_processor = time.perf_counter(), time.process_time()
    if in_flight == 1:
        await lane()
    else:
        await asyncio.gather(*(lane() for _ in range(in_flight)))
    if answers.made != messages:
        raise RuntimeError(f"{answers.made} of {messages} were answered")
    tell(times_ns, began, began_processor)


def tell(times_ns: list[int], began: float, began_processor: float) -> None:
    """Print what was seen of one turn."""
    seen = {
        "seconds": time.perf_counter() - began,
        "processor_s": time.process_time() - began_processor,
        "times_ns": times_ns,
    }
    print(json.dumps(seen), flush=True)


async def run(name: str, opened: Callable[[int, AnswerCount], Any], skills: int) -> None:
    """Run a bot in this event loop, and let it take turns; between them everything waits."""
    answers = AnswerCount()
    async with opened(skills, answers) as send:
        print(json.dumps(version(name)), flush=True)
        for line in sys.stdin:
            await take_turn(send, answers, *map(int, line.split()))


# ---- a bot on threads ----

ERRBOT_PLUGIN = """\
from errbot import BotPlugin, botcmd


class Walk(BotPlugin):
    @botcmd
    def go(self, msg, args):
        return f"done {args}"
"""
ERRBOT_PLUG = """\
[Core]
Name = Walk
Module = walk

[Python]
Version = 3
"""


def errbot(_skills: int) -> None:
    """Run errbot with its back end in memory, and the threads that it has unless told otherwise."""
    import logging

    from errbot.backends.test import TestBot

    with tempfile.TemporaryDirectory(prefix="rosic-bench-") as folder:
        Path(folder, "walk.py").write_text(ERRBOT_PLUGIN, encoding="utf-8")
        Path(folder, "walk.plug").write_text(ERRBOT_PLUG, encoding="utf-8")
        bot = TestBot(extra_plugin_dir=folder, loglevel=logging.ERROR)
        bot.start()
        print(json.dumps(version("errbot")), flush=True)
        for line in sys.stdin:
            errbot_turn(bot, *map(int, line.split()))
        bot.stop()


def errbot_turn(bot: Any, messages: int, in_flight: int) -> None:
    """Keep so many messages under way until all are answered.

    An answer counts for the message that waits longest: errbot's threads share one renderer, and
    now and then one of them gives the text of another's answer.
    """
    times_ns: list[int] = []
    began_ns: deque[int] = deque()
    numbers = iter(range(messages))

    def push() -> None:
        for number in numbers:
            began_ns.append(time.perf_counter_ns())
            bot.push_message(f"!go {number}")
            return

    began, began_processor = time.perf_counter(), time.process_time()
    for _ in range(in_flight):
        push()
    while began_ns:
        bot.pop_message(timeout=WITHIN_S)
        times_ns.append(time.perf_counter_ns() - began_ns.popleft())
        push()
    tell(times_ns, began, began_processor)


def main(name: str, skills: int, loop: str) -> None:
    """Run a bot."""
    if name == "errbot":
        errbot(skills)
        return
    if loop == "uvloop":
        import uvloop

        asyncio.set_event_loop_policy(uvloop.EventLoopPolicy())
    if name == "opsdroid":
        opsdroid(skills)
        return
    opened = {"python-telegram-bot": telegram, "aiogram": aiogram}[name]
    asyncio.run(run(name, opened, skills))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), sys.argv[3])
