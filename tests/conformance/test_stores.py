"""Every store and every latch here keeps every rule, and every rule catches its faulty one."""

from __future__ import annotations

import copy
import shutil
from itertools import count
from typing import TYPE_CHECKING

import pytest

from rosic.errors import RosicError
from rosic.stores.data_dir import LOCK
from rosic.stores.database import DatabaseStore
from rosic.stores.memory import MemoryStore
from rosic.stores.stop_latch import FileLatch, MemoryLatch
from rosic.testing.clock import ManualClock
from rosic.testing.faulty.stores import FAULTS_BY_RULE, FaultyStoreFixture
from rosic.testing.stop_latches import LATCH_FAULTS_BY_RULE, FaultyLatchFixture, LatchConformance
from rosic.testing.stores import StoreConformance

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.contracts.store import StopLatch, Store

CAUGHT = (AssertionError, RosicError, KeyError, pytest.fail.Exception)


class MemoryStoreFixture:
    def make(self) -> MemoryStore:
        return MemoryStore()

    def survivor(self, store: Store) -> MemoryStore:
        assert isinstance(store, MemoryStore)
        return copy.deepcopy(store)


class DatabaseFixture:
    """What survives is what is in the folder, not what is in the process."""

    def __init__(self, root: Path) -> None:
        self._root = root
        self._names = count()
        self._folders: dict[Store, Path] = {}

    def make(self) -> DatabaseStore:
        folder = self._root / str(next(self._names))
        store = DatabaseStore(folder, clock=ManualClock())
        self._folders[store] = folder
        return store

    def survivor(self, store: Store) -> DatabaseStore:
        made = self.make()
        shutil.copytree(
            self._folders[store], self._folders[made], ignore=shutil.ignore_patterns(LOCK)
        )
        return made


class TestMemoryStore(StoreConformance):
    @pytest.fixture
    def fixture(self) -> MemoryStoreFixture:
        return MemoryStoreFixture()


class TestDatabaseStore(StoreConformance):
    @pytest.fixture
    def fixture(self, tmp_path: Path) -> DatabaseFixture:
        return DatabaseFixture(tmp_path)


class MemoryLatchFixture:
    def make(self) -> MemoryLatch:
        return MemoryLatch()

    def survivor(self, latch: StopLatch) -> MemoryLatch:
        assert isinstance(latch, MemoryLatch)
        return copy.deepcopy(latch)


class FileLatchFixture:
    def __init__(self, root: Path) -> None:
        self._root = root
        self._names = count()
        self._files: dict[StopLatch, Path] = {}

    def make(self) -> FileLatch:
        path = self._root / str(next(self._names))
        latch = FileLatch(path)
        self._files[latch] = path
        return latch

    def survivor(self, latch: StopLatch) -> FileLatch:
        made = self.make()
        shutil.copy(self._files[latch], self._files[made])
        return made


class TestMemoryLatch(LatchConformance):
    @pytest.fixture
    def fixture(self) -> MemoryLatchFixture:
        return MemoryLatchFixture()


class TestFileLatch(LatchConformance):
    @pytest.fixture
    def fixture(self, tmp_path: Path) -> FileLatchFixture:
        return FileLatchFixture(tmp_path)


def rules(suite: type) -> set[str]:
    return {name for name in dir(suite) if name.startswith("test_")}


def test_no_rule_lacks_its_fault() -> None:
    assert rules(StoreConformance) == set(FAULTS_BY_RULE)
    assert rules(LatchConformance) == set(LATCH_FAULTS_BY_RULE)


@pytest.mark.parametrize("rule", sorted(FAULTS_BY_RULE))
async def test_the_fault_is_caught(rule: str) -> None:
    fixture = FaultyStoreFixture(MemoryStoreFixture(), FAULTS_BY_RULE[rule])
    with pytest.raises(CAUGHT):
        await getattr(StoreConformance(), rule)(fixture)


@pytest.mark.parametrize("rule", sorted(LATCH_FAULTS_BY_RULE))
async def test_the_faulty_latch_is_caught(rule: str) -> None:
    fixture = FaultyLatchFixture(MemoryLatchFixture(), LATCH_FAULTS_BY_RULE[rule])
    with pytest.raises(CAUGHT):
        await getattr(LatchConformance(), rule)(fixture)
