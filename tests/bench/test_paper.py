"""Algorithms 9, 10 and 11 of the paper, by whatever sends; and the way of an order, hop by hop."""

from __future__ import annotations

import asyncio
import sys
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import pytest
from openpyxl import load_workbook

from rosic.bench import accounts, latency, messages
from rosic.bench.accounts import AccountSender, BotSender, from_environment, sender
from rosic.bench.bot_api_process import TOKEN, stand_in
from rosic.bench.command import main
from rosic.bench.gateway_process import free_port
from rosic.bench.hops import HOPS, hop_site, hop_times, network_ns, own_ns, simulated_omni
from rosic.bench.latency import LatencyRow, save, to_self
from rosic.bench.recorder import BenchRecorder
from rosic.bench.scale import batch_of
from rosic.bench.throughput import CONTENT, measure, sent_for
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


OTHER_TOKEN = "4242424243:of-nobody-at-all-it-opens-nothing-at-all"  # noqa: S105 - as it says


class TelethonStandIn:
    """What Algorithm 9 uses of Telethon's client.

    Args:
        done: Hears what it does.
        trouble: What sending raises, and which sending.
    """

    def __init__(
        self, done: list[tuple[str, ...]], trouble: dict[int, Exception] | None = None
    ) -> None:
        self._done = done
        self._trouble = {} if trouble is None else trouble

    async def start(self) -> None:
        self._done.append(("start",))

    async def send_message(self, entity: str, message: str) -> None:
        self._done.append(("send", entity, message))
        sent = sum(one[0] == "send" for one in self._done)
        if sent in self._trouble:
            raise self._trouble[sent]

    async def disconnect(self) -> None:
        self._done.append(("disconnect",))


# ---- Algorithm 9 ----


async def test_algorithm_9_connects_sends_to_oneself_and_disconnects_each_time() -> None:
    done: list[tuple[str, ...]] = []
    account = AccountSender(lambda: TelethonStandIn(done))

    rows = [row async for row in to_self(account, 2)]

    once = [("start",), ("send", "me", "Testing latency"), ("disconnect",)]
    assert done == once * 2
    assert len(rows) == 2
    assert all(0 < row.latency_ms < 1_000 for row in rows)


async def test_an_account_whose_message_does_not_go_through_says_why_and_disconnects() -> None:
    done: list[tuple[str, ...]] = []
    account = AccountSender(lambda: TelethonStandIn(done, {2: RuntimeError("FLOOD_WAIT_17")}))

    rows = to_self(account, 3)
    assert (await anext(rows)).latency_ms > 0
    with pytest.raises(ConnectionError, match="did not go through: FLOOD_WAIT_17"):
        await anext(rows)

    assert done[-1] == ("disconnect",)


def test_the_workbook_has_the_papers_columns_and_no_run_overwrites_another(
    tmp_path: Path,
) -> None:
    rows = [LatencyRow("2026-11-28 12:00:00", 63.2), LatencyRow("2026-11-28 12:00:01", 64.0)]

    first, second = save(rows, tmp_path), save(rows[:1], tmp_path)

    assert first.name.startswith("latency_results_20")
    assert first != second
    sheet = load_workbook(first).worksheets[0]
    assert [[cell.value for cell in row] for row in sheet] == [
        ["Timestamp", "Latency (ms)"],
        ["2026-11-28 12:00:00", 63.2],
        ["2026-11-28 12:00:01", 64],
    ]


@pytest.mark.limit(120)
def test_what_was_sent_before_the_network_went_is_saved_and_printed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[tuple[str, ...]] = []
    client = TelethonStandIn(done, {3: OSError("the network is unreachable")})
    monkeypatch.setattr(accounts, "telethon_client", lambda: client)

    status = main(
        ["latency", "--over", "account", "--messages", "9", "--runs", "1", "--out", str(tmp_path)]
    )

    said = capsys.readouterr()
    assert status == 1
    assert "to oneself" in said.out
    assert said.err.startswith(
        "failed: It ended early: A message did not go through: the network is unreachable."
    )
    [saved] = tmp_path.iterdir()
    assert load_workbook(saved).worksheets[0].max_row == 3


# ---- Algorithm 6 ----


class GroupStandIn(TelethonStandIn):
    """What Algorithm 6 uses of Telethon's client: somebody writes in the group, then it ends."""

    def __init__(self, *said: SimpleNamespace) -> None:
        super().__init__([])
        self.groups: list[object] = []
        self._said = said
        self._heard: Callable[[SimpleNamespace], Any] | None = None

    def add_event_handler(self, heard: Callable[[SimpleNamespace], Any], event: object) -> None:
        self._heard = heard
        self.groups.append(getattr(event, "chats", None))

    async def run_until_disconnected(self) -> None:
        assert self._heard is not None
        for event in self._said:
            await self._heard(event)


def written_in_group(text: str, *, username: str | None = "ada") -> SimpleNamespace:
    async def get_sender() -> SimpleNamespace:
        return SimpleNamespace(username=username)

    sent = datetime.now(UTC) - timedelta(seconds=2)
    return SimpleNamespace(sender_id=7, get_sender=get_sender, raw_text=text, date=sent)


def test_algorithm_6_appends_a_line_for_each_message_and_nobody_writes_a_second_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    client = GroupStandIn(
        written_in_group("hello"),
        written_in_group("a\nSender ID: 1, Sender Username: root, Message: b", username=None),
    )
    monkeypatch.setattr(messages, "telethon_client", lambda: client)
    file = tmp_path / "messages.txt"
    file.write_text("before\n")
    file.chmod(0o600)

    assert main(["messages", "--group", "-100123", "--file", str(file), "--seconds", "30"]) == 0

    assert client.groups == [-100123]
    assert file.read_text().splitlines() == [
        "before",
        "Sender ID: 7, Sender Username: ada, Message: hello",
        (
            "Sender ID: 7, Sender Username: None, Message: "
            "a\\nSender ID: 1, Sender Username: root, Message: b"
        ),
    ]
    assert file.stat().st_mode & 0o777 == 0o600
    said = capsys.readouterr().out
    assert f"2 messages are in {file}." in said
    assert "until it is in the file" in said


def test_algorithm_6_on_a_full_disk_says_so_and_what_it_wrote_before(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    client = GroupStandIn(written_in_group("hello"))
    monkeypatch.setattr(messages, "telethon_client", lambda: client)

    assert main(["messages", "--group", "lab", "--file", "/dev/full", "--seconds", "30"]) == 1

    assert "It ended early: No space left on device." in capsys.readouterr().err


# ---- what it is sent by ----


@pytest.mark.limit(120)
async def test_a_bot_sends_what_arrives_and_one_that_there_is_not_is_told_so() -> None:
    async with stand_in() as control:
        person = await control.create_user("Person")
        account = BotSender(TOKEN, str(person), api_base=control.api_base)
        await account.connect()
        await account.send("hello")
        await control.fail("error", "sendMessage", code=400, description="Bad Request: no")
        with pytest.raises(ConnectionError, match="did not go through"):
            await account.send("again")
        await account.disconnect()

        assert [m["text"] for m in await control.messages(person, by_bot=True)] == ["hello"]
        unknown = BotSender(OTHER_TOKEN, str(person), api_base=control.api_base)
        with pytest.raises(ConfigurationError, match=r"does not know this token: .*BENCH_TOKEN"):
            await unknown.connect()
    nobody = BotSender(TOKEN, "1", api_base=f"http://127.0.0.1:{free_port()}/bot")
    with pytest.raises(ConfigurationError, match="The Bot API does not answer: "):
        await nobody.connect()


async def test_what_is_not_set_or_not_installed_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in (accounts.BOT_TOKEN, accounts.BOT_CHAT, accounts.API_ID, accounts.API_HASH):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(ConfigurationError, match="ROSIC_BENCH_TOKEN and ROSIC_BENCH_CHAT in the"):
        async with sender("bot"):
            pass
    with pytest.raises(ConfigurationError, match="ROSIC_BENCH_API_ID and ROSIC_BENCH_API_HASH"):
        async with sender("account"):
            pass
    monkeypatch.setenv(accounts.API_ID, "twelve")
    monkeypatch.setenv(accounts.API_HASH, "0" * 32)
    with pytest.raises(ConfigurationError, match="ROSIC_BENCH_API_ID is a number"):
        async with sender("account"):
            pass
    monkeypatch.setitem(sys.modules, "telethon", None)
    with pytest.raises(ConfigurationError, match="needs Telethon") as refused:
        async with sender("account"):
            pass
    assert "rosic[account]" in str(refused.value.hint)
    assert from_environment(accounts.API_ID) == ("twelve",)


async def test_a_real_account_is_made_as_the_paper_makes_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(accounts.API_ID, "12")
    monkeypatch.setenv(accounts.API_HASH, "0" * 32)
    made: list[tuple[object, ...]] = []
    telethon = SimpleNamespace(TelegramClient=lambda *given: made.append(given))
    monkeypatch.setitem(sys.modules, "telethon", telethon)

    accounts.telethon_client()

    assert made == [("rosic-bench", 12, "0" * 32)]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("latency", "--messages", "0"), "a number from 1 to"),
        (("throughput", "--duration", "nan"), "seconds, above 0"),
        (("throughput", "--interval", "-1"), "seconds, above 0"),
        (("scale", "--over", "pigeon"), "invalid choice: 'pigeon'"),
    ],
)
def test_a_wrong_option_is_said_in_a_sentence(
    options: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(options)
    assert said in capsys.readouterr().err


# ---- Algorithms 10 and 11 ----


async def test_algorithm_10_counts_what_did_not_go_through_and_goes_on() -> None:
    done: list[tuple[str, ...]] = []
    account = AccountSender(lambda: TelethonStandIn(done, {2: RuntimeError("FLOOD_WAIT_1")}))
    await account.connect()

    seen = await sent_for(account, 0.3, 0.02)

    assert seen.attempted == sum(one[0] == "send" for one in done)
    assert seen.attempted > 2
    assert seen.successful == seen.attempted - 1
    assert seen.said == ["A message did not go through: FLOOD_WAIT_1"]
    assert seen.size == len(CONTENT) * seen.successful
    assert seen.success_percent == pytest.approx(100 * (1 - 1 / seen.attempted))
    assert seen.bytes_per_s == pytest.approx(seen.size / seen.lasted_s)


@pytest.mark.limit(120)
def test_algorithm_10_stands_beside_the_papers_figures() -> None:
    report = measure(BenchRecorder("throughput"), duration=0.5, interval=0.05)

    ours, paper = report.tables[0].rows
    assert paper[1:] == (51, 51, 100.0, 195.12)
    assert ours[1] == ours[2]
    assert ours[3] == 100.0
    assert report.cases[0].p50_us > 60_000  # the network of the paper


async def test_algorithm_11_sends_a_batch_one_after_another() -> None:
    at_once = 0
    most = 0

    class Slow(TelethonStandIn):
        async def send_message(self, entity: str, message: str) -> None:
            nonlocal at_once, most
            at_once += 1
            most = max(most, at_once)
            await asyncio.sleep(0.01)
            at_once -= 1
            await super().send_message(entity, message)

    account = AccountSender(lambda: Slow([]))
    await account.connect()

    run = await batch_of(account, 5)

    assert most == 1
    assert len(run.latencies_ns) == 5
    assert run.mean_ms >= 10
    assert run.per_s == pytest.approx(5 / run.lasted_s)


# ---- hop by hop ----


def test_hops_last_from_the_one_before_and_branch_once_it_is_on_disk() -> None:
    passed = {
        "begun": 0,
        "person to server": 1,
        "server to gateway": 31,
        "decided": 32,
        "on disk": 34,
        "robot acknowledged": 40,
        "answer sent": 36,
        "person sees": 66,
    }

    assert hop_times(passed) == {
        "person to server": 1,
        "server to gateway": 30,
        "decided": 1,
        "on disk": 2,
        "robot acknowledged": 6,
        "answer sent": 2,
        "person sees": 30,
    }
    assert own_ns(passed) == 5
    assert network_ns(passed) == 61


@pytest.mark.limit(180)
async def test_an_order_passes_every_hop_in_order_over_the_papers_network() -> None:
    async with stand_in() as control, hop_site(control, simulated_omni()) as site:
        passed = [await site.order() for _ in range(2)]

    for one in passed:
        assert set(one) >= {*HOPS, "begun", "ended"} - {"robot received"}
        way = [one[hop] for hop in ("begun", "server to gateway", "decided", "on disk")]
        assert way == sorted(way)
        assert one["on disk"] <= one["robot acknowledged"] <= one["ended"]
        assert one["on disk"] <= one["answer sent"] <= one["person sees"]
        assert network_ns(one) > 55e6  # 30 ms there, 30 ms back, less what clocks differ
    assert passed[0]["ended"] < passed[1]["begun"]


def test_the_figures_of_the_paper_are_drawn_of_what_was_seen() -> None:
    seen = [[LatencyRow("", 60.0), LatencyRow("", 70.0)], [LatencyRow("", 90.0)]]

    third, fourth = latency.paper_charts(seen)

    assert third.series[0].y == (60.0, 70.0, 90.0)
    assert fourth.series[0].y == (65.0, 90.0)
    assert list(fourth.series[0].error) == pytest.approx([7.07, 0.0], abs=0.01)
