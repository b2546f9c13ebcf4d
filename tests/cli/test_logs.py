"""The log of a gateway: one line each, and no secret in any of them."""

from __future__ import annotations

import io
import logging
import re
import sys
from contextlib import redirect_stderr
from typing import TYPE_CHECKING

import pytest

from rosic.app.logging import log_to_standard_error
from rosic.core.secret import Secret

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture(autouse=True)
def restored() -> Iterator[None]:
    root = logging.getLogger()
    handlers, level, own = root.handlers[:], root.level, logging.getLogger("rosic").level
    yield
    root.handlers[:] = handlers
    root.setLevel(level)
    logging.getLogger("rosic").setLevel(own)


def said(level: str, *secrets: Secret) -> str:
    """Return what is on standard error after some things were logged."""
    err = io.StringIO()
    log_to_standard_error(level, lambda _at_ns: "14:02:07", secrets)
    log = logging.getLogger("rosic.delivery")
    with redirect_stderr(err):
        log.info("not told\nyet: %s", "4242:a-long-token")
        log.debug("details")
        logging.getLogger("httpx").info("GET /bot4242:a-long-token/getMe")
        try:
            int("a-long-token")
        except ValueError:
            log.exception("it broke")
    return err.getvalue()


def test_one_line_each_without_traces() -> None:
    lines = said("info").splitlines()

    assert lines[0] == "14:02:07 info rosic.delivery: not told yet: 4242:a-long-token"
    assert lines[1].startswith(
        "14:02:07 error rosic.delivery: it broke (ValueError: invalid literal"
    )
    assert lines[1].endswith(")")
    assert len(lines) == 2


def test_secrets_are_masked_in_lines_and_in_traces() -> None:
    for level in ("info", "debug"):
        text = said(level, Secret("4242:a-long-token"))
        assert "a-long-token" not in text
        assert "4242:***" in text
    assert "Traceback" in said("debug")


def test_a_fault_is_looked_for_in_microseconds() -> None:
    assert re.match(
        r"14:02:07\.\d{6} debug rosic\.delivery: details$", said("debug").splitlines()[1]
    )


def test_it_follows_whoever_replaces_standard_error() -> None:
    log_to_standard_error("info", lambda _at_ns: "14:02:07")
    before = sys.stderr

    with redirect_stderr(io.StringIO()) as prompt:
        logging.getLogger("rosic").info("above the prompt")

    assert "above the prompt" in prompt.getvalue()
    assert sys.stderr is before
