"""Features are found in their folder, and what one provides is there for whoever needs it."""

from __future__ import annotations

import asyncio
import inspect
from graphlib import CycleError
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType

import pytest

import rosic.app.features
from rosic import features
from rosic.app.features import Features, in_order, setups
from rosic.errors import RecordUnavailable
from rosic.features.fleet import FleetFeature
from rosic.gateway.feature import ErasureParticipants, Feature, Provided, SharedParts
from rosic.testing.clock import settle
from tests.gateway.place import Place


def package(provides: tuple[str, ...] = (), needs: tuple[str, ...] = ()) -> ModuleType:
    made = ModuleType("feature")
    vars(made).update(PROVIDES=provides, NEEDS=needs)
    return made


def test_what_provides_a_part_is_set_up_before_whoever_needs_it() -> None:
    packages = {
        "a": package(needs=("camera", "nothing that anybody provides")),
        "b": package(provides=("fleet",), needs=("camera",)),
        "c": package(provides=("camera",)),
        "d": package(needs=("fleet",)),
    }
    order = in_order(packages)
    assert sorted(order) == ["a", "b", "c", "d"]
    assert order.index("c") < order.index("b") < order.index("d")
    assert order.index("c") < order.index("a")
    with pytest.raises(CycleError):
        in_order({"a": package(("x",), ("y",)), "b": package(("y",), ("x",))})


def test_every_package_says_rightly_what_it_needs_and_provides() -> None:
    shared = vars(SharedParts())
    found = {setup.__module__: import_module(setup.__module__) for setup in setups()}
    assert len(found) == len(list(iter_modules(features.__path__)))
    for name, made in found.items():
        source = inspect.getsource(made)
        needs, provides = getattr(made, "NEEDS", ()), getattr(made, "PROVIDES", ())
        assert {*needs, *provides} <= shared.keys(), name
        taken = {part for part in shared if f"shared.{part}.get()" in source}
        assert taken <= set(needs), name
        given = {part for part in shared if f"shared.{part}.provide(" in source}
        assert given <= set(provides), name
        assert all(source.count(part) > 1 for part in (*needs, *provides)), name


def test_a_part_is_provided_once_and_missed_by_name() -> None:
    part: Provided[str] = Provided("dashboards")
    assert part.find() is None
    with pytest.raises(RuntimeError, match="no feature provides dashboards yet"):
        part.get()
    part.provide("made")
    assert part.get() == part.find() == "made"
    with pytest.raises(RuntimeError, match="two features provide dashboards"):
        part.provide("another")


async def test_whoever_is_erased_ends_with_every_feature_that_takes_part() -> None:
    erasure, ended = ErasureParticipants(), list[str]()

    async def end(principal: str) -> None:
        ended.append(principal)

    erasure.join(records=lambda _who: ())
    erasure.join(end=end)
    erasure.join(end=end)
    assert list(erasure.records("p-1")) == []
    await erasure.end("p-1")
    assert ended == ["p-1", "p-1"]


class Unknown(Feature):
    """No gateway has it."""


async def test_a_gateway_says_which_feature_it_lacks() -> None:
    async with Place().open() as place:
        found = place.gateway.features
        assert found.get(FleetFeature) is found.find(FleetFeature)
        assert found.find(Unknown) is None
        with pytest.raises(LookupError, match="there is no Unknown here"):
            found.get(Unknown)


class Failing(Feature):
    """Ends at once, and cannot leave."""

    async def run(self) -> None:
        raise ValueError("broken")

    async def leave(self) -> None:
        await asyncio.Event().wait()


class Steady(Feature):
    """Runs until it is cancelled."""

    def __init__(self) -> None:
        self.said: list[str] = []

    async def run(self) -> None:
        try:
            await asyncio.Event().wait()
        finally:
            self.said.append("cancelled")

    async def leave(self) -> None:
        self.said.append("left")


async def test_a_feature_that_fails_or_hangs_keeps_no_other_from_running_and_leaving(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    steady = Steady()
    monkeypatch.setattr(
        rosic.app.features, "setups", lambda: (lambda _: steady, lambda _: Failing())
    )
    async with Place().open() as place:
        made = Features(place.gateway.kernel)
        running = asyncio.create_task(made.run())
        await settle()
        assert "Failing does nothing on its own any more" in caplog.text
        assert not running.done()
        running.cancel()
        await settle()
        leaving = asyncio.create_task(made.leave())
        await settle()
        leaving.cancel()
        assert steady.said == ["cancelled", "left"]


class Hindered(Feature):
    """Can do nothing of what is due, and does not end well."""

    async def each_minute(self) -> None:
        raise ValueError("broken")

    async def each_day(self) -> None:
        raise RecordUnavailable("the disk")

    async def close(self) -> None:
        raise ValueError("broken")


class Due(Steady):
    """Notes what it has done."""

    async def each_minute(self) -> None:
        self.said.append("minute")

    async def each_day(self) -> None:
        self.said.append("day")

    async def close(self) -> None:
        await settle()
        self.said.append("closed")


async def test_what_one_feature_cannot_do_every_other_does_when_it_is_due(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    due = Due()
    async with Place().open() as place:
        two = (lambda _: Hindered(), lambda _: due)
        monkeypatch.setattr(rosic.app.features, "setups", lambda: two)
        made = Features(place.gateway.kernel)
        await made.each_minute()
        with pytest.raises(RecordUnavailable, match="the disk"):
            await made.each_day()
        await made.close()
        assert due.said == ["minute", "day", "closed"]
        assert "Hindered has not done what was due" in caplog.text
        assert "Hindered did not end well" in caplog.text
