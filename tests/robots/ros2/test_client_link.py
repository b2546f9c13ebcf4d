"""I1: a client that does not see who is there is made anew, unless an answer is owed to it."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.core.time_units import SECOND_NS
from rosic.core.traffic import TrafficCounter
from rosic.robots.ros2.client.actions import ActionLink
from rosic.robots.ros2.client.client_link import FOUND_S, UNSEEN_AT_MOST_S, UNSEEN_S
from rosic.robots.ros2.errors import NoAnswer, NotSent
from rosic.testing.clock import settle

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.robots.ros2.client.rclpy_import import RosObject


class Client:
    """Stands for rclpy's client of an action."""

    def __init__(self, *, sees: bool) -> None:
        self.sees = sees
        self.is_there = True

    def server_is_ready(self) -> bool:
        return self.sees

    def destroy(self) -> None:
        self.is_there = False


class Graph:
    """Stands for the link to a graph with one action on it, and for its thread and its node."""

    alive = True

    def __init__(self) -> None:
        self.thread = self.node = self
        self.traffic = TrafficCounter()
        self.time_s = 100.0
        self.offered = self.sees = True
        self.clients: list[Client] = []
        self.may_make = asyncio.Event()
        self.may_make.set()
        self.fault: Exception | None = None

    def now_ns(self) -> int:
        return int(self.time_s * SECOND_NS)

    def count_services(self, name: str) -> int:
        assert name.startswith("/grip/_action/")
        return int(self.offered and name.endswith("send_goal"))

    def count_publishers(self, _name: str) -> int:
        return 0

    async def run(self, work: Callable[[], object]) -> object:
        return work()

    async def opened(self, make: Callable[[], object]) -> object:
        await self.may_make.wait()
        return make()

    async def discard(self, destroy: Callable[[Graph], object]) -> None:
        destroy(self)

    async def ask(self, _send: object, _what: str, **_how: object) -> RosObject:
        assert self.fault is not None
        raise self.fault

    def make(self) -> Client:
        self.clients.append(Client(sees=self.sees))
        return self.clients[-1]


class Move:
    """Stands for an action whose goal has no fields."""

    class Goal:
        SLOT_TYPES = ()

        @staticmethod
        def get_fields_and_field_types() -> dict[str, str]:
            return {}


class Site:
    """An action that is on the graph, and a client that does not see it."""

    def __init__(self) -> None:
        self.graph = Graph()
        self.blind = Client(sees=False)
        runtime: RosObject = self.graph
        self.link = ActionLink(runtime, "/grip", Move, self.blind, self.graph.make)

    async def sought(self, for_s: float = 0.0) -> bool:
        """Seek it for so long, as an order does."""
        end_s = self.graph.time_s + for_s
        found = self.link.sought()
        await settle()
        while not found and self.graph.time_s < end_s:
            self.graph.time_s += 0.1
            found = self.link.sought()
            await settle()
        return found


@pytest.fixture
async def site() -> Site:
    return Site()


async def test_a_client_that_does_not_see_who_is_there_is_made_anew(site: Site) -> None:
    assert not await site.sought(UNSEEN_S - 0.2)
    assert not site.graph.clients, "discovery had not its time"
    assert await site.sought(0.5 + FOUND_S)
    assert site.link.renewed == 1
    assert not site.blind.is_there
    assert site.graph.clients[0].is_there


async def test_nothing_is_sent_before_the_other_side_could_find_it(site: Site) -> None:
    await site.sought(UNSEEN_S + 0.2)
    assert site.link.renewed == 1
    assert not site.link.ready()
    site.graph.time_s += FOUND_S
    assert site.link.ready()


async def test_nobody_there_is_no_fault_of_the_client(site: Site) -> None:
    site.graph.offered = False
    assert not await site.sought(10 * UNSEEN_S)
    assert not site.link.renewed
    assert site.blind.is_there


async def test_what_stays_unseen_is_made_anew_more_and_more_rarely(site: Site) -> None:
    site.graph.sees = False
    assert not await site.sought(UNSEEN_S * 2**5)
    assert site.link.renewed == 5
    assert not await site.sought(10 * UNSEEN_AT_MOST_S)
    assert 9 <= site.link.renewed - 5 <= 11


@pytest.mark.parametrize(("fault", "renewed"), [(NoAnswer("late"), 0), (NotSent("not taken"), 1)])
async def test_what_has_not_answered_keeps_its_client(
    site: Site, fault: Exception, renewed: int
) -> None:
    """Its acceptance may still come, and is called off by that client."""
    site.blind.sees, site.graph.fault = True, fault
    with pytest.raises(type(fault)):
        await site.link.send({}, timeout_s=1.0)
    site.blind.sees = False
    await site.sought(3 * UNSEEN_S)
    assert site.link.renewed == len(site.graph.clients) == renewed
    assert site.blind.is_there == (not renewed)


async def test_what_was_sent_while_another_was_made_keeps_its_client(site: Site) -> None:
    site.graph.may_make.clear()
    await site.sought(UNSEEN_S + 0.2)
    site.blind.sees, site.graph.fault = True, NoAnswer("late")
    with pytest.raises(NoAnswer):
        await site.link.send({}, timeout_s=1.0)
    site.blind.sees = False
    site.graph.may_make.set()
    await settle()
    assert site.blind.is_there
    assert not site.link.renewed
    assert [client.is_there for client in site.graph.clients] == [False]


async def test_what_is_seen_after_all_stays(site: Site) -> None:
    site.graph.may_make.clear()
    await site.sought(UNSEEN_S + 0.2)
    site.blind.sees = True
    assert site.link.ready()
    site.graph.may_make.set()
    await settle()
    assert site.blind.is_there
    assert not site.link.renewed
    assert [client.is_there for client in site.graph.clients] == [False], "and nothing is left"


async def test_closing_leaves_neither_client(site: Site) -> None:
    site.graph.may_make.clear()
    await site.sought(UNSEEN_S + 0.2)
    closing = asyncio.create_task(site.link.close())
    await settle()
    site.graph.may_make.set()
    await closing
    await settle()
    assert site.graph.clients
    assert not any(client.is_there for client in [site.blind, *site.graph.clients])
