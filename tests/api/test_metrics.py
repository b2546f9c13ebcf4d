"""What monitoring reads: true counts, in Prometheus' format, of nobody by name, on its own port."""

from __future__ import annotations

import asyncio
import re
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING

import httpx
import pytest

from rosic.api.metrics.endpoint import MetricsEndpoint, MetricsSettings
from rosic.api.metrics.exposition import COUNTER, HISTOGRAM, Histogram, Metric, Sample, page
from rosic.api.settings import HostPort
from rosic.app.config import read_config
from rosic.stores.memory import MemoryStore
from tests.gateway.place import BO, VI, Place
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

ANYWHERE = HostPort("127.0.0.1", 0)
LINE = re.compile(r'[a-z_]+(\{[a-z]+="[^"\n]*"(,[a-z]+="[^"\n]*")*\})? [0-9.e+-]+\Z')


@asynccontextmanager
async def measured(
    place: Place, settings: MetricsSettings | None = None
) -> AsyncIterator[httpx.AsyncClient]:
    listen = settings or MetricsSettings(listen=ANYWHERE)
    endpoint = MetricsEndpoint(place.gateway.kernel, listen)
    running = asyncio.create_task(endpoint.run())
    try:
        async with asyncio.timeout(30 * pace()):
            while not endpoint.port:  # noqa: ASYNC110 - nobody is told
                await asyncio.sleep(0.005)
        async with httpx.AsyncClient(
            base_url=f"http://127.0.0.1:{endpoint.port}", timeout=30 * pace()
        ) as client:
            yield client
    finally:
        running.cancel()
        with suppress(asyncio.CancelledError):
            await running


async def values(client: httpx.AsyncClient) -> dict[str, float]:
    """Return every sample; each line is as the format has it, and each metric is explained once."""
    answer = await client.get("/metrics")
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/plain; version=0.0.4")
    lines = answer.text.splitlines()
    explained = [line.split()[2] for line in lines if line.startswith("# TYPE")]
    assert len(explained) == len(set(explained))
    samples = [line for line in lines if not line.startswith("#")]
    for line in samples:
        assert LINE.match(line), line
    return {name: float(value) for name, _, value in (one.rpartition(" ") for one in samples)}


async def test_orders_stops_refusals_and_links_are_counted_as_they_are() -> None:
    async with Place().open() as place, measured(place) as client:
        before = await values(client)
        assert before['rosic_robot_stopped{robot="omni"}'] == 0
        assert before['rosic_robot_up{robot="omni"}'] == 1
        assert before['rosic_robot_queue_length{robot="kuka1"}'] == 0
        await place.say("omni wave", account=BO, chat=BO)
        await place.say("omni wave", account=VI, chat=VI)
        await place.say("stop omni", account=BO, chat=BO)
        after = await values(client)
        assert after['rosic_orders_total{robot="omni",outcome="done"}'] == 1
        assert after['rosic_order_hop_seconds_count{hop="accepted-ended"}'] == 1
        assert after['rosic_order_hop_seconds_bucket{hop="accepted-ended",le="+Inf"}'] == 1
        assert after['rosic_refusals_total{code="not-permitted"}'] == 1
        stops = 'rosic_stops_total{robot="omni"}'
        assert after[stops] == before[stops] + 1
        assert after['rosic_robot_stopped{robot="omni"}'] == 1
        received = 'rosic_messenger_messages_total{messenger="memory",direction="received"}'
        assert after[received] == before[received] + 3
        assert after['rosic_robot_messages_total{robot="omni",direction="sent"}'] >= 1
        assert 'rosic_robot_bytes_total{robot="omni",direction="sent"}' not in after
        assert after["rosic_orders_under_way"] == 0
        place.robot("omni").online = False
        assert (await values(client))['rosic_robot_up{robot="omni"}'] == 0


async def test_nobody_is_named() -> None:
    async with Place().open() as place, measured(place) as client:
        await place.say("omni wave", account=BO, chat=BO)
        text = (await client.get("/metrics")).text
        people = place.gateway.rooms.authoriser.directory.people()
        assert people
        for person in people:
            assert person.id not in text
            assert not re.search(rf"\b{person.name}\b", text)


async def test_it_lives_and_is_ready_unless_the_record_is_late() -> None:
    async with Place(MemoryStore()).open() as place, measured(place) as client:
        assert (await client.get("/livez")).text == "ok\n"
        assert (await client.get("/readyz")).status_code == 200
        head = await client.head("/metrics")
        assert (head.status_code, head.content) == (200, b"")


@pytest.mark.parametrize(
    ("method", "path", "headers", "status"),
    [
        ("GET", "/", {}, 404),
        ("GET", "/metrics/../etc/passwd", {}, 404),
        ("POST", "/metrics", {}, 405),
        ("DELETE", "/livez", {}, 405),
        ("GET", "/metrics", {"Host": "evil.example"}, 421),
        ("GET", "/metrics", {"Host": "metrics.example"}, 200),
        ("GET", "/metrics", {"Host": "localhost:1"}, 200),
        ("GET", "/metrics", {"X-Much": "x" * 10_000}, 431),
    ],
)
async def test_what_is_asked_otherwise_is_answered_with_its_status(
    method: str, path: str, headers: dict[str, str], status: int
) -> None:
    settings = MetricsSettings(listen=ANYWHERE, hosts=("metrics.example",))
    async with Place().open() as place, measured(place, settings) as client:
        answer = await client.request(method, path, headers=headers)
        assert answer.status_code == status


async def test_whoever_says_nothing_or_nonsense_keeps_nobody_else_waiting() -> None:
    async with Place().open() as place, measured(place) as client:
        port = client.base_url.port
        silent = [await asyncio.open_connection("127.0.0.1", port) for _ in range(10)]
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        writer.write(b"\x16\x03\x01 nonsense\r\n\r\n")
        assert (await reader.read()).startswith(b"HTTP/1.1 400")
        assert (await client.get("/livez")).status_code == 200
        for _, other in [*silent, (reader, writer)]:
            other.close()


def test_labels_are_escaped_and_buckets_add_up() -> None:
    odd = Metric("a", COUNTER, "Odd.", (Sample({"b": 'x"\n\\'}, 1),))
    assert tuple(odd.lines())[-1] == r'a{b="x\"\n\\"} 1'
    histogram = Histogram((0.1, 1.0))
    for seconds in (0.05, 0.1, 0.5, 7.0):
        histogram.observe(seconds)
    times = Metric("t", HISTOGRAM, "Times.", (Sample({}, histogram),))
    assert page((times,)).decode().splitlines()[2:] == [
        't_bucket{le="0.1"} 2',
        't_bucket{le="1"} 3',
        't_bucket{le="+Inf"} 4',
        "t_sum 7.65",
        "t_count 4",
    ]


@pytest.mark.parametrize(
    ("table", "refused"),
    [
        ('listen = "127.0.0.1:9464"', ""),
        ('listen = "0.0.0.0:9464"', "nothing there is encrypted"),
        ('listen = "0.0.0.0:9464"\nwithout_tls = "public address, no TLS"', ""),
        ('listen = "robots.example.org:9464"', "is no address and port"),
        ('hosts = ["metrics.example.org"]', "so nothing listens"),
        ('listen = "127.0.0.1:9464"\npath = "/m"', "'path' is not known here"),
    ],
)
def test_where_it_listens_is_said_or_refused(tmp_path: Path, table: str, refused: str) -> None:
    path = tmp_path / "rosic.toml"
    path.write_text(f"[metrics]\n{table}\n")
    path.chmod(0o600)
    errors = " ".join(str(error) for error in read_config(path, environ={}).errors)
    told = ("encrypted", "no address and port", "nothing listens", "not known here")
    assert refused in errors
    assert bool(refused) == any(sentence in errors for sentence in told)


async def test_tasks_and_descriptors_are_counted_as_they_come_and_go(tmp_path: Path) -> None:
    async with Place().open() as place, measured(place) as client:
        before = await values(client)
        waiting = [asyncio.create_task(asyncio.Event().wait()) for _ in range(50)]
        files = [(tmp_path / f"{number}").open("wb") for number in range(60)]
        after = await values(client)
        for file in files:
            file.close()
        for task in waiting:
            task.cancel()
        await asyncio.gather(*waiting, return_exceptions=True)
        again = await values(client)

    for name, more in (("rosic_loop_tasks", 50), ("process_open_fds", 60)):
        assert after[name] == pytest.approx(before[name] + more, abs=5)
        assert again[name] == pytest.approx(before[name], abs=5)
