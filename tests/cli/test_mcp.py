"""`rosic mcp` as programs use it: the official client, a process of its own, a running gateway."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import time
from contextlib import AsyncExitStack
from typing import TYPE_CHECKING

import anyio
import msgspec
import pytest
from mcp import Client, ClientSession, stdio_client
from mcp.client.streamable_http import streamable_http_client
from mcp.shared._httpx_utils import create_mcp_http_client
from mcp_types import CallToolResult

from tests.cli.programs import (
    Progress,
    at_rest,
    client,
    free,
    key_of,
    number_of,
    resumed,
    said,
    served_by,
    state,
)
from tests.cli.running import CONFIG, environment, gateway, rosic, write_config
from tests.messengers.test_add_a_messenger import free_port
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from tests.cli.running import Gateway

SERVED = """
[gateway]
lease_idle_s = 1

[[messenger]]
kind = "mcp"
port = {port}
wait_s = 20

[[care]]
scopes = ["kuka1:*"]
confirm = true

[role.slow]
scopes = ["omni:*"]
rate = "2/h"
"""


@pytest.fixture(scope="module")
def port() -> int:
    return free_port()


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory, port: int) -> Path:
    # Everybody of a terminal's platform reads the one terminal: one of them alone may confirm here.
    people = CONFIG.replace('role = "operator"', 'role = "viewer"')
    return write_config(tmp_path_factory.mktemp("programs"), people + SERVED, port=str(port))


@pytest.fixture(scope="module")
def running(config: Path) -> Iterator[Gateway]:
    with gateway(config) as opened:
        yield opened


@pytest.mark.usefixtures("running")
async def test_tools_are_made_from_the_profiles_that_a_key_may_see(config: Path) -> None:
    async with client(key_of("Lister", config, "--robot", "omni"), config) as session:
        tools = {tool.name: tool for tool in (await session.list_tools()).tools}
        assert {"stop", "cancel", "list_robots", "status", "omni-move"} <= set(tools)
        assert not any("kuka1" in name for name in tools)
        move = tools["omni-move"].input_schema
        assert move["required"] == ["distance"]
        distance = move["properties"]["distance"]
        assert (distance["minimum"], distance["maximum"]) == (0.01, 5.0)
        assert "In m, from 0.01 to 5." in distance["description"]
        assert move["properties"]["direction"]["enum"] == ["forward", "back", "left", "right"]
        robots = said(await session.call_tool("list_robots", {}))
        assert "omni: at rest" in robots
        assert "KUKA" not in robots
        hidden = await session.call_tool("kuka1-grasp", {"force": 10})
        assert hidden.is_error
        assert said(hidden) == "There is no such robot or skill here. Nothing was done."


@pytest.mark.usefixtures("running")
async def test_a_call_moves_the_robot_and_its_statuses_are_progress(config: Path) -> None:
    async with client(key_of("Mover", config), config) as session:
        before = at_rest("omni", config)["values"]
        told = Progress()
        result = await session.call_tool(
            "omni-move", {"distance": 0.3, "direction": "left"}, progress_callback=told
        )
        assert not result.is_error
        assert said(result).startswith("omni: move, 0.30 m left\n")
        assert re.search(r"done [\d:]+: moved 0.30 m left", said(result))
        assert "\nsent " in "".join(told.texts)
        assert told.steps == sorted(set(told.steps)), "it only grows"
        after = at_rest("omni", config)["values"]
        assert isinstance(before, dict)
        assert isinstance(after, dict)
        moved = abs(after["x"] - before["x"]) + abs(after["y"] - before["y"])
        assert 0.25 < moved < 0.45
        history = rosic("history", "-c", config).out
        assert "Mover" in history


@pytest.mark.usefixtures("running")
@pytest.mark.parametrize(
    ("tool", "values", "why"),
    [
        ("omni-move", {"distance": 50}, "omni: one move may be at most 5 m. Nothing was done."),
        ("omni-move", {}, "distance has to be said, too."),
        ("omni-move", {"distance": 1, "height": 2}, "There is no parameter"),
        ("omni-move", {"distance": "1; stop"}, "is no such number"),
        ("omni-move", {"distance": True}, "is no such number"),
        ("omni-move", {"distance": 1, "direction": "up"}, "direction is one of forward, back"),
        ("omni-fly", {}, "There is no such robot or skill here. Nothing was done."),
        ("fly", {}, "There is no tool 'fly' here. Nothing was done."),
        ("status", {"robot": "omni\nomni move 1 m"}, "There is no robot"),
    ],
)
async def test_what_is_refused_is_refused_in_a_sentence(
    config: Path, tool: str, values: dict[str, object], why: str
) -> None:
    if "Wrong" not in KEYS:
        KEYS["Wrong"] = key_of("Wrong", config)
    async with client(KEYS["Wrong"], config) as session:
        result = await session.call_tool(tool, values)
        assert result.is_error
        assert why in said(result)
        assert state("omni", config)["doing"] == ""


KEYS: dict[str, str] = {}


@pytest.mark.usefixtures("running")
async def test_each_program_has_its_own_rate_and_every_call_is_answered(config: Path) -> None:
    async with client(key_of("Hasty", config), config) as session:
        results = [await session.call_tool("status", {"robot": "omni"}) for _ in range(40)]
        refused = [said(result) for result in results if result.is_error]
        assert refused
        assert all("Again in" in text for text in refused), refused
        stopped = await session.call_tool("stop", {"robots": ["kuka1"]})
        assert not stopped.is_error, "a stop is never counted"
        assert "STOP: KUKA iiwa at rest" in said(stopped)
    async with client(key_of("Calm", config), config) as session:
        assert not (await session.call_tool("status", {"robot": "omni"})).is_error
    rosic("resume", "kuka1", "-c", config)


@pytest.mark.usefixtures("running")
async def test_a_role_of_programs_may_be_slower(config: Path) -> None:
    free("omni", config)
    async with client(key_of("Slow", config, role="slow"), config) as session:
        for _ in range(2):
            assert not (await session.call_tool("omni-move", {"distance": 0.05})).is_error
        third = await session.call_tool("omni-move", {"distance": 0.05})
        assert third.is_error
        assert "slow" in said(third)


async def test_what_has_to_be_confirmed_a_person_confirms_in_the_chat(
    running: Gateway, config: Path
) -> None:
    async with client(key_of("Asker", config), config) as session:
        told, answer = Progress(), list["CallToolResult"]()

        async def grasp() -> None:
            done = await session.call_tool("kuka1-grasp", {"force": 12}, progress_callback=told)
            answer.append(done)

        for button, ends in (("No", "does not agree"), ("I agree", "done")):
            before = len(running.out())
            async with anyio.create_task_group() as group:
                group.start_soon(grasp)
                await told.hears("A person has to confirm that first. I have asked Ada")
                await anyio.to_thread.run_sync(asked, running, before)
                assert not state("kuka1", config)["doing"], "nothing before somebody agrees"
                running.say(number_of(button, running.out()[before:]))
            result = answer.pop()
            assert result.is_error is (button == "No")
            assert ends in said(result), running.out()
            told.texts.clear()


def asked(running: Gateway, before: int) -> None:
    end_s = time.monotonic() + 60 * pace()
    while "Asker wants: KUKA iiwa: grasp, 12 N." not in running.out()[before:]:
        assert time.monotonic() < end_s, running.out()
        time.sleep(0.02)


async def test_cancelling_a_call_cancels_its_order(config: Path, running: Gateway) -> None:
    free("omni", config)
    async with client(key_of("Fickle", config), config) as session:
        told = Progress()
        async with anyio.create_task_group() as group:

            async def move() -> None:
                await session.call_tool(
                    "omni-move", {"distance": 5, "speed": 0.05}, progress_callback=told
                )

            group.start_soon(move)
            await told.hears("received by the robot")
            group.cancel_scope.cancel()
        found = at_rest("omni", config)
        assert not found["stopped"], "a cancel latches nothing"
        status = said(await session.call_tool("status", {"robot": "omni"}))
        assert "at rest" in status
        again = await session.call_tool("omni-move", {"distance": 0.05})
        assert not again.is_error, "the robot is free at once"
    assert running.process.poll() is None


@pytest.mark.usefixtures("running")
async def test_a_program_that_leaves_ends_what_it_has_under_way(config: Path) -> None:
    told = Progress()
    key = key_of("Gone", config)
    free("omni", config)
    async with anyio.create_task_group() as group:

        async def leave_amid_motion() -> None:
            async with client(key, config) as session:
                await session.call_tool(
                    "omni-move", {"distance": 5, "speed": 0.05}, progress_callback=told
                )

        group.start_soon(leave_amid_motion)
        await told.hears("received by the robot")
        group.cancel_scope.cancel()
    assert not at_rest("omni", config)["stopped"]


async def test_stop_is_a_tool_and_a_person_resumes(config: Path, running: Gateway) -> None:
    free("omni", config)
    async with client(key_of("Stopper", config), config) as session:
        told, ended = Progress(), list["CallToolResult"]()
        async with anyio.create_task_group() as group:

            async def move() -> None:
                long = {"distance": 5, "speed": 0.05}
                ended.append(await session.call_tool("omni-move", long, progress_callback=told))

            group.start_soon(move)
            await told.hears("received by the robot")
            stopped = await session.call_tool("stop", {})
        assert not stopped.is_error
        assert re.search(r"STOP: omni at rest \(\d\.\d\d s\)", said(stopped))
        for named in ([{"id": "omni"}], [["omni"]], ["omni", {"name": "kuka1"}], ["omni"] * 99):
            again = await session.call_tool("stop", {"robots": named})
            assert not again.is_error, (named, said(again))
            assert "STOP: omni" in said(again)
        assert ended[0].is_error
        assert "stopped before it ended" in said(ended[0])
        refused = await session.call_tool("omni-move", {"distance": 0.1})
        assert refused.is_error
        assert "omni is stopped, by you" in said(refused)
    resumed(running, "omni", config)
    rosic("resume", "kuka1", "-c", config)


BEGIN = {
    "jsonrpc": "2.0",
    "id": 1,
    "method": "initialize",
    "params": {
        "protocolVersion": "2025-06-18",
        "capabilities": {},
        "clientInfo": {"name": "t", "version": "1"},
    },
}


async def over_http(port: int, key: str | None, **headers: str) -> int:
    """Return the status of a first request, however it is made."""
    shown = {} if key is None else {"Authorization": f"Bearer {key}"}
    accept = {"Accept": "application/json, text/event-stream"}
    async with create_mcp_http_client(headers={**shown, **accept, **headers}) as http:
        answer = await http.post(f"http://127.0.0.1:{port}/mcp", json=BEGIN)
        return int(answer.status_code)


@pytest.mark.usefixtures("running")
async def test_streamable_http_is_for_this_machine_and_for_good_keys(
    config: Path, port: int
) -> None:
    key = key_of("Web", config)
    assert await over_http(port, key) == 200
    assert await over_http(port, None) == 401
    assert await over_http(port, "rosic_k0_wrong") == 401
    assert await over_http(port, key, Host="robots.example:80") == 421
    assert await over_http(port, key, Origin="https://robots.example") == 403
    listening = [line.split()[1] for line in open_ports() if line.split()[3] == "0A"]
    mine = [place for place in listening if place.endswith(f":{port:04X}")]
    assert mine == [f"0100007F:{port:04X}"], "loopback alone"


@pytest.mark.usefixtures("running")
async def test_no_program_opens_all_the_sessions(config: Path, port: int) -> None:
    key = key_of("Opener", config)
    assert [await over_http(port, key) for _ in range(9)] == [200] * 8 + [429]
    version = {"MCP-Protocol-Version": "2025-06-18"}
    assert await over_http(port, key, **version) == 429, "whatever version it says it speaks"
    assert await over_http(port, key_of("Other", config)) == 200


def open_ports() -> list[str]:
    with open("/proc/net/tcp", encoding="ascii") as file:  # noqa: PTH123 - no file of ours
        return file.read().splitlines()[1:]


@pytest.mark.usefixtures("running")
async def test_streamable_http_moves_a_robot_too(config: Path, port: int) -> None:
    headers = {"Authorization": f"Bearer {key_of('Surfer', config)}"}
    free("omni", config)
    told = Progress()
    async with (
        create_mcp_http_client(headers=headers) as http,
        streamable_http_client(f"http://127.0.0.1:{port}/mcp", http_client=http) as streams,
        ClientSession(streams[0], streams[1]) as session,
    ):
        await session.initialize()
        assert "omni-move" in {tool.name for tool in (await session.list_tools()).tools}
        result = await session.call_tool("omni-move", {"distance": 0.2}, progress_callback=told)
        assert not result.is_error
        assert "moved 0.20 m forward" in said(result)
        assert told.texts
        assert "STOP" in said(await session.call_tool("stop", {"robots": ["omni"]}))
    rosic("resume", "omni", "-c", config)


@pytest.mark.usefixtures("running")
def test_no_key_or_a_wrong_one_is_one_sentence(config: Path, tmp_path: Path) -> None:
    none = rosic("mcp", "-c", config, env={"ROSIC_KEY": ""})
    assert (none.status, none.out) == (2, "")
    assert none.err == (
        "rosic: There is no key. Make one with rosic key create, and give it as ROSIC_KEY.\n"
    )
    wrong = rosic("mcp", "-c", config, env={"ROSIC_KEY": "rosic_k1_x"})
    assert (wrong.status, wrong.out) == (1, "")
    assert wrong.err.startswith("rosic: That is no key of a program here")
    open_file = tmp_path / "key"
    open_file.write_text("rosic_k1_x")
    open_file.chmod(0o644)
    readable = rosic("mcp", "-c", config, "--key-file", open_file)
    assert readable.status == 2
    assert "Others may read" in readable.err
    open_file.chmod(0o600)
    assert "That is no key" in rosic("mcp", "-c", config, "--key-file", open_file).err


@pytest.mark.usefixtures("running")
async def test_a_key_that_is_replaced_or_taken_back_is_good_no_longer(config: Path) -> None:
    old = key_of("Renewed", config)
    async with client(old, config) as session:
        answer = rosic("key", "rotate", "Renewed", "-c", config).out
        new = answer.splitlines()[-1]
        assert "The new one is shown once:" in answer
        assert (await session.call_tool("status", {})).is_error
    assert rosic("mcp", "-c", config, env={"ROSIC_KEY": old}).status == 1
    async with client(new, config) as session:
        assert not (await session.call_tool("status", {})).is_error
        assert rosic("key", "revoke", "Renewed", "-c", config).status == 0
        over = await session.call_tool("omni-move", {"distance": 0.1})
        assert over.is_error
        assert "has ended" in said(over)


@pytest.mark.usefixtures("running")
def test_a_program_gives_nobody_rights_and_bears_a_name_of_its_own(config: Path) -> None:
    admin = rosic("key", "create", "Boss", "--role", "admin", "-c", config)
    assert admin.status == 1
    assert "A program gives nobody rights" in admin.err
    same = rosic("key", "create", "Bob", "--role", "operator", "-c", config)
    assert same.status == 1
    assert "Somebody is called Bob already" in same.err
    assert "Boss" not in rosic("people", "-c", config).out


def test_without_a_messenger_for_programs_it_says_what_to_add(tmp_path: Path) -> None:
    config = write_config(tmp_path)
    with gateway(config):
        key = key_of("Early", config)
        refused = rosic("mcp", "-c", config, env={"ROSIC_KEY": key})
    assert refused.status == 1
    assert 'Add [[messenger]] with kind = "mcp"' in refused.err
    off = rosic("mcp", "-c", config, env={"ROSIC_KEY": key})
    assert off.err.startswith("rosic: No gateway is running on")
    assert rosic("key", "create", "Offline", "--role", "operator", "-c", config).status == 0


@pytest.mark.usefixtures("running")
@pytest.mark.parametrize("by", ["stdio", "http"])
@pytest.mark.parametrize("mode", ["legacy", "auto"])
async def test_both_eras_of_the_protocol_are_spoken(
    config: Path, port: int, by: str, mode: str
) -> None:
    """A handshake, or none; over HTTP without one, whoever closes the stream has cancelled."""
    key = key_of(f"Era {by} {mode}", config)
    async with AsyncExitStack() as stack:
        if by == "stdio":
            transport = stdio_client(served_by(key, config))
        else:
            headers = {"Authorization": f"Bearer {key}"}
            http = await stack.enter_async_context(create_mcp_http_client(headers=headers))
            transport = streamable_http_client(f"http://127.0.0.1:{port}/mcp", http_client=http)
        speaking = await stack.enter_async_context(Client(transport, mode=mode))
        modern = str(speaking.session.protocol_version) >= "2026"
        assert modern is (mode == "auto")
        assert "stop" in {tool.name for tool in (await speaking.list_tools()).tools}
        free("omni", config)
        told = Progress()
        result = await speaking.call_tool("omni-move", {"distance": 0.1}, progress_callback=told)
        assert isinstance(result, CallToolResult)
        assert "done" in said(result)
        assert told.texts
        long, told = {"distance": 5, "speed": 0.05}, Progress()
        async with anyio.create_task_group() as group:

            async def move() -> None:
                await speaking.call_tool("omni-move", long, progress_callback=told)

            group.start_soon(move)
            await told.hears("received by the robot")
            group.cancel_scope.cancel()
        rested = await anyio.to_thread.run_sync(at_rest, "omni", config)  # it is said meanwhile
        assert not rested["stopped"]


def test_what_is_no_message_hurts_nobody_and_the_gateway_ends_in_time(tmp_path: Path) -> None:
    config = write_config(tmp_path, CONFIG + SERVED, port=str(free_port()))
    with gateway(config) as running:
        with subprocess.Popen(  # noqa: S603 - our own command
            [sys.executable, "-m", "rosic", "mcp", "-c", str(config)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=environment({"ROSIC_KEY": key_of("Raw", config)}),
        ) as raw:
            assert raw.stdin is not None
            assert raw.stdout is not None
            begin = msgspec.json.encode(BEGIN)
            raw.stdin.write(
                b'hello\n\n{"jsonrpc": 1}\n\xff\xfe\n[' + b"[" * 5000 + b"\n" + begin + b"\n"
            )
            raw.stdin.flush()
            while (line := json.loads(raw.stdout.readline())).get("id") != 1:
                assert "error" in line
            assert line["result"]["serverInfo"]["name"] == "rosic"
            assert running.end(within_s=10) == 0
            assert raw.wait(30 * pace()) == 1
            assert raw.stderr is not None
            assert raw.stderr.read() == b"rosic: The gateway has ended.\n"
        assert "Traceback" not in running.err()
