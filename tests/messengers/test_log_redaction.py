from __future__ import annotations

import io
import logging
from typing import TYPE_CHECKING

import pytest

from rosic.core.secret import Secret
from rosic.messengers.telegram.errors import hide, scrub

if TYPE_CHECKING:
    from collections.abc import Iterator

HALF = "a-half-that-must-not-be-seen"
TOKEN = f"998877:{HALF}"


@pytest.fixture
def log() -> Iterator[tuple[logging.Logger, io.StringIO]]:
    """A logger whose handler was there before the secret, as handlers of an application are."""
    written = io.StringIO()
    handler = logging.StreamHandler(written)
    logger = logging.getLogger("some.library.deep.inside")
    logger.addHandler(handler)
    logger.setLevel(logging.DEBUG)
    hide(Secret(TOKEN))
    yield logger, written
    logger.removeHandler(handler)


def rejected() -> None:
    raise KeyError("outer") from ValueError(f"the token {TOKEN} was rejected")


def test_a_message_is_scrubbed(log: tuple[logging.Logger, io.StringIO]) -> None:
    logger, written = log
    logger.info("POST %s/getMe", f"https://api.telegram.org/bot{TOKEN}")
    assert written.getvalue() == "POST https://api.telegram.org/bot998877:***/getMe\n"


def test_an_argument_is_scrubbed(log: tuple[logging.Logger, io.StringIO]) -> None:
    logger, written = log
    logger.info("asked %r", {"url": TOKEN})
    assert HALF not in written.getvalue()
    assert "998877:***" in written.getvalue()


def test_a_trace_is_scrubbed(log: tuple[logging.Logger, io.StringIO]) -> None:
    logger, written = log
    try:
        rejected()
    except KeyError:
        logger.exception("failed")
    assert HALF not in written.getvalue()
    assert "the token 998877:*** was rejected" in written.getvalue()
    assert "KeyError" in written.getvalue()


def test_what_holds_no_secret_is_left_as_it_was(
    log: tuple[logging.Logger, io.StringIO], caplog: pytest.LogCaptureFixture
) -> None:
    logger, _ = log
    logger.info("got %d of %s", 3, "x")
    assert caplog.records[-1].args == (3, "x")


def test_a_broken_format_is_logged_as_always(log: tuple[logging.Logger, io.StringIO]) -> None:
    logger, _ = log
    factory = logging.getLogRecordFactory()
    record = factory(logger.name, logging.INFO, "f", 1, "%d", ("x",), None)
    assert record.args == ("x",)


def test_hiding_twice_wraps_once() -> None:
    hide(Secret(TOKEN))
    factory = logging.getLogRecordFactory()
    hide(Secret("5:another-half"))
    assert logging.getLogRecordFactory() is factory
    assert scrub("5:another-half") == "5:***"


def test_what_is_too_short_to_be_a_secret_spoils_no_log() -> None:
    hide(Secret("1:x"))
    assert scrub("1:x, extra") == "1:x, extra"
