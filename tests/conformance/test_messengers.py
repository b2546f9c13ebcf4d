"""Every messenger here under the rules, and the rules under those who break them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.testing.faulty.messengers import FETCHING_SINNERS, FaultyMessenger, catches, rules
from rosic.testing.faulty.messengers import SINNERS as OTHER_SINNERS
from rosic.testing.messengers import MessengerConformance
from tests.conformance.messenger_stages import MemoryStage, TelegramStage, telegram_stage

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

# Some break a rule by never doing something: they are waited for in vain.
SINNERS_PATIENCE_S = 0.5
SINNERS = OTHER_SINNERS | FETCHING_SINNERS


class TestMemory(MessengerConformance):
    @pytest.fixture
    def stage(self) -> MemoryStage:
        return MemoryStage()


class TestTelegram(MessengerConformance):
    @pytest.fixture
    async def stage(self) -> AsyncIterator[TelegramStage]:
        async with telegram_stage() as stage:
            yield stage


def test_every_rule_has_its_sinner() -> None:
    assert rules() == set(SINNERS)
    assert all(SINNERS.values())


@pytest.mark.parametrize(
    ("rule", "sinner"), [(rule, sinner) for rule, all_of in SINNERS.items() for sinner in all_of]
)
async def test_a_sinner_is_caught(rule: str, sinner: type[FaultyMessenger]) -> None:
    assert await catches(rule, sinner, MemoryStage(SINNERS_PATIENCE_S))


@pytest.mark.parametrize("rule", sorted(rules()))
async def test_who_only_passes_on_is_not_caught(rule: str) -> None:
    assert not await catches(rule, FaultyMessenger, MemoryStage())
