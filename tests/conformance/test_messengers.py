"""Every messenger here under the rules, and the rules under those who break them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.testing.faulty.messengers import FAULTS_BY_RULE as OTHER_FAULTS_BY_RULE
from rosic.testing.faulty.messengers import FETCHING_FAULTS_BY_RULE, FaultyMessenger, catches, rules
from rosic.testing.messengers import MessengerConformance
from tests.conformance.messenger_harnesses import MemoryStage, TelegramStage, telegram_stage

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

# Some break a rule by never doing something: they are waited for in vain.
FAULTS_PATIENCE_S = 0.5
FAULTS_BY_RULE = OTHER_FAULTS_BY_RULE | FETCHING_FAULTS_BY_RULE


class TestMemory(MessengerConformance):
    @pytest.fixture
    def stage(self) -> MemoryStage:
        return MemoryStage()


class TestTelegram(MessengerConformance):
    @pytest.fixture
    async def stage(self) -> AsyncIterator[TelegramStage]:
        async with telegram_stage() as stage:
            yield stage


def test_every_rule_has_its_fault() -> None:
    assert rules() == set(FAULTS_BY_RULE)
    assert all(FAULTS_BY_RULE.values())


@pytest.mark.parametrize(
    ("rule", "faulty"),
    [(rule, faulty) for rule, all_of in FAULTS_BY_RULE.items() for faulty in all_of],
)
async def test_a_fault_is_caught(rule: str, faulty: type[FaultyMessenger]) -> None:
    assert await catches(rule, faulty, MemoryStage(FAULTS_PATIENCE_S))


@pytest.mark.parametrize("rule", sorted(rules()))
async def test_who_only_passes_on_is_not_caught(rule: str) -> None:
    assert not await catches(rule, FaultyMessenger, MemoryStage())
