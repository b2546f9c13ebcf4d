"""The token appears nowhere but in the requests themselves."""

from __future__ import annotations

import logging
import traceback

import pytest

from rosic.errors import RosicError
from rosic.testing.telegram import DEFAULT_TOKEN, FakeTelegram
from tests.real.telegram.gateway import Gateway, to

HALF = DEFAULT_TOKEN.partition(":")[2]
WRONG = "4242424242:wrong-and-yet-not-to-be-seen"


def everything_about(error: BaseException) -> str:
    """Return whatever a trace, a debugger or a careless handler would show."""
    seen, texts = [error], list[str]()
    while seen:
        one = seen.pop()
        texts += [str(one), repr(one), repr(one.args), repr(vars(one))]
        seen += [other for other in (one.__cause__, one.__context__) if other is not None]
    return "\n".join(texts) + "".join(traceback.format_exception(error))


async def test_no_log_line_and_no_error_shows_it(
    server: FakeTelegram,
    gateway: Gateway,
    ada: int,
    caplog: pytest.LogCaptureFixture,
    capfd: pytest.CaptureFixture[str],
) -> None:
    caplog.set_level(logging.DEBUG)
    for library in ("telegram", "httpx", "httpcore", "asyncio"):
        caplog.set_level(logging.DEBUG, logger=library)
    errors: list[RosicError] = []

    async def attempt(outbound_text: str) -> None:
        try:
            await gateway.messenger.send(to(ada, outbound_text))
        except RosicError as error:
            errors.append(error)
            logging.getLogger("somebody").exception("could not send")

    async with gateway.listening():
        for fault in ("bad_gateway", "truncated", "reset", "too_many_requests"):
            server.fail(fault, "getUpdates")
            server.say(ada, ada, fault)
        for fault in ("bad_gateway", "truncated", "reset", "drop_answer"):
            server.fail(fault, "sendMessage")
            await attempt(fault)
        await attempt("  ")
        await gateway.hear(4)
    await server.stop()
    await attempt("nobody there")
    assert len(errors) == 6
    shown = "".join(everything_about(error) for error in errors)
    out, err = capfd.readouterr()
    logged = "\n".join([caplog.text, *[repr(vars(record)) for record in caplog.records]])
    assert "getUpdates" in logged
    for text in (shown, out, err, logged):
        assert HALF not in text


async def test_a_wrong_token_is_not_shown_either(
    server: FakeTelegram, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.DEBUG)
    gateway = Gateway(server, token=WRONG)
    with pytest.raises(RosicError) as raised:
        await gateway.messenger.run(gateway.receive)
    assert WRONG.partition(":")[2] not in everything_about(raised.value) + caplog.text


async def test_what_people_wrote_is_not_logged_when_an_answer_breaks(
    server: FakeTelegram, gateway: Gateway, ada: int, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    async with gateway.listening():
        server.fail("truncated", "getUpdates")
        await gateway.until(lambda: gateway.calls("getUpdates")[-1].get("fault"))
        server.say(ada, ada, "my private words")
        await gateway.hear(1)
    assert "is not what Telegram says" in caplog.text  # the broken answer did come
    assert "private words" not in caplog.text
