"""What decides beside the way of an order is there from the start; what is not refuses (I18)."""

from __future__ import annotations

import inspect
from typing import NoReturn

import pytest

from rosic.core.identity import Address, Caller
from rosic.core.language.command import NO_COMMANDS
from rosic.core.message import Chat, Inbound
from rosic.gateway import Pipeline
from rosic.gateway.hooks import PipelineHooks
from rosic.testing.clock import ManualClock
from tests.gateway.place import edited

DECIDING = ("confirmation_of", "stepped_up", "proof_used", "refused", "changes_late")
INBOUND = Inbound(
    sender=Address("memory", "1"),
    chat=Chat("memory", "1"),
    message="m",
    text="7-code",
    sent_ns=0,
    received_ns=0,
)


def never(*_: object) -> NoReturn:
    raise AssertionError("nobody asks this")


@pytest.mark.parametrize("left_out", DECIDING)
def test_it_is_not_made_without_what_decides(left_out: str) -> None:
    given = {name: never for name in DECIDING if name != left_out}
    with pytest.raises(TypeError, match=left_out):
        PipelineHooks(commands=NO_COMMANDS, **given)


def test_a_pipeline_is_not_made_without_it() -> None:
    parameter = inspect.signature(Pipeline).parameters["hooks"]
    assert parameter.default is inspect.Parameter.empty


async def test_until_it_is_known_who_is_let_in_nobody_is_and_nothing_is_taken() -> None:
    hooks = PipelineHooks(
        confirmation_of=never,
        stepped_up=never,
        proof_used=never,
        refused=never,
        changes_late=never,
        commands=NO_COMMANDS,
    )
    messenger = edited(ManualClock())
    assert await hooks.newcomer(messenger, INBOUND, "7-code") is None
    caller = Caller("p-1", "Ada", INBOUND.sender, "k", "s")
    hooks.enclosed(messenger, INBOUND, caller)
    assert hooks.view_buttons("omni") == []
    for late in (hooks.newcomer, hooks.enclosed, hooks.view_buttons):
        late.bind(never)
        with pytest.raises(RuntimeError):
            late.bind(never)  # nobody takes it from whoever has it
