"""Topics over WebSockets: ours beside rosbridge_server, a bare echo and bare rclpy, in one run.

Every server, the clients and the robot's side are processes of their own; each case is measured
with one server right after the other, so that what others do on the machine meets both. Ours is a
whole gateway: authentication, scopes and the record on disk.
"""

from __future__ import annotations

import time
from contextlib import ExitStack
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec
from websockets.sync.client import connect

from rosic.bench.api_servers import BridgeServer, echo, gateway, rosbridge_server, script_of
from rosic.bench.report import BenchCase, BenchReport, machine
from rosic.bench.socket_process import ClientsWanted
from rosic.bench.topic_process import FROM_ROS, TO_ROS, StreamFigures
from rosic.console.pages import page_files
from rosic.errors import ConfigurationError, how_to_install
from rosic.testing.ros2.graph import RosGraph, RosProcess, why_missing

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rosic.bench.recorder import BenchRecorder


SMALL, LARGE = 64, 65_536
MANY: Final = 100
RUNS, QUICK_RUNS = 3, 1
LASTS_S, QUICK_LASTS_S = 3.0, 0.5
FLOODS_S: Final = 20.0
IDLE_S, QUICK_IDLE_S = 10.0, 1.0
HEARD_WITHIN_S: Final = 60.0
ANSWERED_WITHIN_S: Final = 200.0
NODE: Final = "rosic.bench.topic_process"
PACED: Final = 200.0
OFFERED: Final = 1_500.0
TO_MANY, TO_MANY_OFFERED = 10.0, 100.0
"""Messages a second where each goes to a hundred clients."""
P50_SHARE: Final = 0.25
RATE_TIMES: Final = 1.5
STALLED_TIMES: Final = 2.0
IDLE_MOST: Final = 0.01
PAGE_BYTES: Final = 250_000

METHOD: Final = (
    "std_msgs/msg/String between a ROS 2 node and WebSocket clients, each in a process of its own; "
    "{runs} runs of {lasts:g} s, medians. Times: from the moment that a message was made until it "
    "was taken on the other side. Rate: messages taken a second. Processor: of the server, for "
    "each message that was offered. Ours: a whole gateway with authentication, scopes and its "
    "record on disk.{beside}"
)
NO_BESIDE: Final = " Without --rosbridge nothing is compared with rosbridge_server."
RATIO: Final = (
    "{name}: p50 {p50:.2f}, rate {rate:.2f}, processor {busy:.2f} times rosbridge_server's."
)
IDLE: Final = "Idle, with the events of a page open: {share:.2%} of a processor; {memory:.0f} MB."
PAGE: Final = "All of the page: {size:.0f} kB compressed."
STALLED: Final = "A client that takes nothing beside it: p50 {times:.2f} times as long."


class TopicCase(NamedTuple):
    """One case.

    Attributes:
        to_ros: From WebSockets to the topic; else from the topic to them.
        rate_per_s: 0: as fast as it goes.
        most: So many messages at most.
        stalled: How many clients beside the others take nothing of what they are sent.
    """

    to_ros: bool
    size: int
    rate_per_s: float
    most: int
    clients: int = 1
    stalled: int = 0

    @property
    def name(self) -> str:
        """Return it in words."""
        way = "to ROS" if self.to_ros else "from ROS"
        size = f"{self.size} B" if self.size < 1024 else f"{self.size // 1024} KiB"  # noqa: PLR2004
        rate = f"{self.rate_per_s:g}/s" if self.rate_per_s else "flooded"
        many = f"{self.clients} clients" if self.clients > 1 else "1 client"
        stalled = f" and {self.stalled} stalled" if self.stalled else ""
        return f"{way}, {size}, {rate}, {many}{stalled}"


def cases(*, quick: bool) -> Iterator[TopicCase]:
    """Yield what is measured."""
    if quick:
        yield TopicCase(True, SMALL, PACED, 100)
        yield TopicCase(True, SMALL, 0, 1_000)
        yield TopicCase(False, SMALL, PACED, 100)
        return
    for clients in (1, MANY):
        for size, flood in ((SMALL, 20_000), (LARGE, 2_000)):
            yield TopicCase(True, size, PACED, 10_000, clients)
            yield TopicCase(True, size, 0, flood, clients)
    for size in (SMALL, LARGE):
        yield TopicCase(False, size, PACED, 10_000)
        yield TopicCase(False, size, PACED, 10_000, stalled=1)
        yield TopicCase(False, size, OFFERED, 10_000)
        yield TopicCase(False, size, TO_MANY, 10_000, MANY, 1)
        yield TopicCase(False, size, TO_MANY_OFFERED, 10_000, MANY, 1)


class CaseRun(NamedTuple):
    """One run of a case with one server."""

    sent: int
    seen: StreamFigures
    busy_s: float

    @property
    def lost(self) -> float:
        """Return the share of what was sent that did not come."""
        return 1 - self.seen.count / self.sent if self.sent else 1.0


class ApiBench:
    """Runs cases against servers.

    Args:
        graph: The ROS graph that all of them are on.
        lasts_s: How long a stream is sent.
    """

    def __init__(self, graph: RosGraph, lasts_s: float) -> None:
        self._graph, self._lasts_s = graph, lasts_s
        self._node = graph.start("-m", NODE, TO_ROS, FROM_ROS)
        self._clients = graph.start("-m", "rosic.bench.socket_process")

    def run(self, server: BridgeServer, case: TopicCase) -> CaseRun:
        """Run a case."""
        wanted = ClientsWanted(
            url=server.url,
            headers=server.headers,
            clients=case.clients,
            stalled=case.stalled,
            subscribes="" if case.to_ros else FROM_ROS,
            publishes=TO_ROS if case.to_ros else "",
        )
        self._connect(wanted)
        sender, taker = self._clients, self._node
        if not case.to_ros:
            sender, taker = taker, sender
        self._meet(sender, taker)
        found = self._stream(sender, taker, case, server)
        self._ask(self._clients, "close", "closed")
        return found

    def _connect(self, wanted: ClientsWanted) -> None:
        self._ask(self._clients, f"open {msgspec.json.encode(wanted).decode()}", "opened")

    @staticmethod
    def _ask(process: RosProcess, line: str, answer: str) -> str:
        process.say(line)
        return process.expect(answer, timeout_s=ANSWERED_WITHIN_S)

    def _meet(self, sender: RosProcess, taker: RosProcess) -> None:
        """Say hello until it is heard: what is said before nobody can take."""
        self._ask(taker, "clear", "cleared")
        end_s = time.monotonic() + HEARD_WITHIN_S
        while time.monotonic() < end_s:
            sender.say("hello")
            time.sleep(0.05)
            if self._ask(taker, "heard", "heard") == "true":
                return
        raise ConfigurationError("The two sides of the bench did not find each other.")

    def _stream(
        self, sender: RosProcess, taker: RosProcess, case: TopicCase, server: BridgeServer
    ) -> CaseRun:
        self._ask(taker, "clear", "cleared")
        before_s = server.busy_s()
        lasts_s = self._lasts_s if case.rate_per_s else FLOODS_S
        sender.say(f"publish {case.size} {case.rate_per_s} {lasts_s} {case.most}")
        sent = int(sender.expect("published", timeout_s=ANSWERED_WITHIN_S))
        seen = self._ask(taker, f"report {sent}", "seen")
        figures = msgspec.json.decode(seen, type=StreamFigures)
        return CaseRun(sent, figures, server.busy_s() - before_s)

    def echoed(self, server: BridgeServer, case: TopicCase) -> CaseRun:
        """Have what is sent come back to whoever sent it."""
        self._connect(ClientsWanted(url=server.url))
        found = self._stream(self._clients, self._clients, case, server)
        self._ask(self._clients, "close", "closed")
        return found

    def plain(self, case: TopicCase) -> CaseRun:
        """Publish from one plain node to another."""
        listener = self._graph.start("-m", NODE, FROM_ROS, f"{FROM_ROS}/nothing")
        server = BridgeServer("bare rclpy", "", {}, listener)
        self._meet(self._node, listener)
        found = self._stream(self._node, listener, case, server)
        listener.stop()
        return found


def measure(recorder: BenchRecorder, *, rosbridge: Path | None = None) -> BenchReport:
    """Measure ours, and beside it what is here to compare with.

    Args:
        recorder: Hears how far it is.
        rosbridge: A checkout of rosbridge_suite.

    Raises:
        ConfigurationError: ROS 2 is not here, or a server does not start.
    """
    if sentence := why_missing():
        raise ConfigurationError(sentence, hint=f"Run: {how_to_install('ros2,api')}")
    if rosbridge is not None:
        script_of(rosbridge)
    runs, lasts_s = (QUICK_RUNS, QUICK_LASTS_S) if recorder.quick else (RUNS, LASTS_S)
    wanted = tuple(cases(quick=recorder.quick))
    with (
        TemporaryDirectory(prefix="rosic-api-") as folder,
        RosGraph(Path(folder)) as graph,
        ExitStack() as stack,
    ):
        bench = ApiBench(graph, lasts_s)
        servers = [stack.enter_context(gateway(graph, Path(folder)))]
        if rosbridge is not None:
            servers.append(stack.enter_context(rosbridge_server(graph, rosbridge)))
        seen = []
        for case in wanted:
            rows = []
            for _ in range(runs):
                with recorder.turn(case.name, of=runs):
                    rows.append([bench.run(server, case) for server in servers])
            seen.append(rows)
            recorder.see(
                _case(f"{server.name}: {case.name}", [run[at] for run in rows])
                for at, server in enumerate(servers)
            )
        by_server = [
            {case: [run[at] for run in rows] for case, rows in zip(wanted, seen, strict=True)}
            for at in range(len(servers))
        ]
        idle = _idle(servers[0], quick=recorder.quick)
        bare = stack.enter_context(echo(graph))
        paced, flood = wanted[0], wanted[1]
        floors = [
            (f"bare echo, there and back: {case.name}", [bench.echoed(bare, case)])
            for case in (paced, flood)
        ]
        floors += [
            (f"bare rclpy: {case.name}", [bench.plain(case)])
            for case in (paced._replace(to_ros=False), flood._replace(to_ros=False))
        ]
    beside = "" if len(servers) > 1 else NO_BESIDE
    method = METHOD.format(runs=runs, lasts=lasts_s, beside=beside)
    return _report(servers, by_server, floors, idle, method)


def _report(
    servers: Sequence[BridgeServer],
    by_server: Sequence[dict[TopicCase, list[CaseRun]]],
    floors: Sequence[tuple[str, list[CaseRun]]],
    idle: tuple[str, str],
    method: str,
) -> BenchReport:
    wanted = tuple(by_server[0])
    shown = [
        _case(f"{server.name}: {case.name}", found[case])
        for case in wanted
        for server, found in zip(servers, by_server, strict=True)
    ]
    shown += [_case(name, found) for name, found in floors]
    told = [idle, _page(), *_stalled(by_server[0]), *_lost(by_server[0])]
    if len(servers) > 1:
        told += _compared(wanted, *by_server)
    return BenchReport(
        machine=machine(),
        method=method,
        cases=tuple(shown),
        findings=tuple(finding for finding, _ in told if finding),
        failures=tuple(failure for _, failure in told if failure),
    )


def _case(name: str, found: Sequence[CaseRun]) -> BenchCase:
    return BenchCase(
        name=name,
        rate_per_s=round(median(run.seen.rate_per_s for run in found), 1),
        p50_us=round(median(run.seen.p50_us for run in found), 1),
        p99_us=round(median(run.seen.p99_us for run in found), 1),
        lost_share=round(median(run.lost for run in found), 4),
        processor_us=round(median(_each_us(run) for run in found), 1),
    )


def _each_us(run: CaseRun) -> float:
    return run.busy_s * 1e6 / max(1, run.sent)


def _compared(
    wanted: Sequence[TopicCase],
    ours: dict[TopicCase, list[CaseRun]],
    theirs: dict[TopicCase, list[CaseRun]],
) -> Iterator[tuple[str, str]]:
    """Yield how each case compares, and where that is not as promised."""
    for case in wanted:
        pairs = list(zip(ours[case], theirs[case], strict=True))
        p50 = median(_times(a.seen.p50_us, b.seen.p50_us) for a, b in pairs)
        rate = median(_times(a.seen.rate_per_s, b.seen.rate_per_s) for a, b in pairs)
        busy = median(_times(_each_us(a), _each_us(b)) for a, b in pairs)
        failure = ""
        if case.to_ros and case.size == SMALL:
            if case.rate_per_s and p50 > P50_SHARE:
                failure = (
                    f"{case.name}: p50 {p50:.2f} of rosbridge_server's, promised is a quarter."
                )
            elif not case.rate_per_s and rate < RATE_TIMES:
                failure = f"{case.name}: {rate:.2f} times its rate, promised is {RATE_TIMES:g}."
        yield RATIO.format(name=case.name, p50=p50, rate=rate, busy=busy), failure


def _times(ours: float, theirs: float) -> float:
    return ours / theirs if theirs else 0.0


def _lost(ours: dict[TopicCase, list[CaseRun]]) -> Iterator[tuple[str, str]]:
    for case, runs in ours.items():
        lost = max(run.lost for run in runs)
        if lost and (case.to_ros or case.rate_per_s == PACED):
            yield "", f"{case.name}: {lost:.2%} of the messages were lost."


def _stalled(ours: dict[TopicCase, list[CaseRun]]) -> Iterator[tuple[str, str]]:
    """Yield what a stalled client costs another one."""
    for case, runs in ours.items():
        beside = ours.get(case._replace(stalled=0))
        if not case.stalled or beside is None:
            continue
        pairs = zip(runs, beside, strict=True)
        times = median(_times(a.seen.p50_us, b.seen.p50_us) for a, b in pairs)
        told = f"{case.name}: {STALLED.format(times=times)}"
        yield told, told if times > STALLED_TIMES else ""


def _idle(server: BridgeServer, *, quick: bool) -> tuple[str, str]:
    """Return what the gateway uses while a page is open and nobody does anything.

    A second is too short to judge by: `rosic bench idle` is for that.
    """
    lasts_s = QUICK_IDLE_S if quick else IDLE_S
    url = server.url.replace("/rosbridge", "/v1/events")
    with connect(url, additional_headers=server.headers) as page:
        page.send('{"op": "subscribe", "topics": ["robots", "orders", "chat"]}')
        time.sleep(1.0)
        before_s = server.busy_s()
        time.sleep(lasts_s)
        share = (server.busy_s() - before_s) / lasts_s
    told = IDLE.format(share=share, memory=server.memory_mb())
    return told, told if share > IDLE_MOST and not quick else ""


def _page() -> tuple[str, str]:
    size = sum(len(each.packed) for each in page_files({}).values())
    told = PAGE.format(size=size / 1e3)
    return told, told if size > PAGE_BYTES else ""
