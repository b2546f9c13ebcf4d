"""People, keys, locks and plans through the socket of a running gateway."""

from __future__ import annotations

import asyncio
import json
import re
import time
from contextlib import asynccontextmanager
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING

import pytest

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.service import GREETING
from rosic.cli.client import answers
from rosic.testing.telegram import FakeTelegram
from tests.cli.running import TELEGRAM, gateway, rosic, write_config
from tests.cli.terminal import rosic_run
from tests.pace import pace, patience

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from tests.cli.running import Gateway
    from tests.cli.terminal import Terminal

CODE = re.compile(r"\b[0-9A-Z]{4}-[0-9A-Z]{4}\b")


def good(command: str, *arguments: str, config: Path) -> str:
    ran = rosic(*command.split(), *arguments, "-c", config)
    assert (ran.status, ran.err) == (0, "")
    return ran.out


@pytest.mark.usefixtures("running")
def test_where_a_terminal_is_all_no_invitation_is_made_and_a_mistake_is_one_sentence(
    config: Path,
) -> None:
    asked = ("invite", "--role", "operator", "--robot", "kuka1", "--for", "2h", "-c", config)
    refused = rosic(*asked)
    assert (refused.status, refused.out) == (1, "")
    assert refused.err.startswith("rosic: There is only this terminal to talk by, so nobody could")

    wrong = rosic("invite", "--role", "operatr", "-c", config)
    assert (wrong.status, wrong.out) == (1, "")
    assert wrong.err == "rosic: No role is called 'operatr'. Did you mean operator?\n"
    assert "operator on kuka1" not in good("security report", config=config)


@pytest.mark.usefixtures("running")
def test_keys_and_explanations_come_from_the_running_gateway(config: Path) -> None:
    assert "Bob has a new key." in good("key rotate", "Bob", "--grace", "1h", config=config)
    _, old = (line.split()[0] for line in good("key list", "Bob", config=config).splitlines())
    assert "not good any more" in good("key revoke", old, config=config)
    assert "ok  key:" in good("explain", "Bob", "kuka1 grasp force=30", config=config)
    assert json.loads(good("security report", "--json", config=config))["locks"] == []


@pytest.mark.usefixtures("running")
def test_a_plan_is_booked_and_shown_to_the_next_one(config: Path) -> None:
    day = (datetime.now(tz=UTC) + timedelta(days=7)).strftime("%Y-%m-%d")
    file = config.parent / "week.csv"
    file.write_text(
        f"person,robots,length,earliest,latest\nBob,kuka1,1 h,{day} 09:00,{day} 10:00\n"
    )
    assert good("schedule plan", str(file), "--book", config=config).endswith("Booked: 1 slot.\n")
    assert "kuka1 is booked" in good("schedule plan", str(file), config=config)


def test_whoever_is_locked_comes_to_rest_within_a_second(running: Gateway, config: Path) -> None:
    running.say("omni move 5 m speed 0.05 m/s")
    running.wait_for("driving")
    refused = rosic("explain", "Bob", "omni arm home", "-c", config)  # it is taken
    assert refused.status == 1
    assert "Bob may not." in refused.out

    begun_s = time.monotonic()
    [said] = answers(config.parent / "rosic-data", AdminRequest(AdminVerb.LOCK, ("Ada",)))
    running.wait_for("omni: stopped before it ended")
    assert time.monotonic() - begun_s < 1 * patience()
    assert said.startswith("Ada is locked")
    assert "stopped" in good("status", "omni", config=config)

    running.say("kuka1 home")
    running.wait_for("locked")
    assert "Ada: locked" in good("people", config=config)
    assert "Ada is unlocked." in good("unlock", "Ada", config=config)


# ---- the first admin ----


def test_who_sits_at_the_terminal_is_told_how_to_begin(tmp_path: Path) -> None:
    hand = rosic_run(write_config(tmp_path), types=True)
    try:
        hand.wait_for(GREETING)
        hand.type("help")
        hand.wait_for("Say what a robot should do, for example:")
    finally:
        hand.end()


def everything(folder: Path) -> bytes:
    return b"".join(p.read_bytes() for p in folder.rglob("*") if p.is_file())


async def joins(server: FakeTelegram, config: Path, who: int, code: str, as_what: str) -> None:
    """Let somebody hand a code in, and wait until they are listed."""
    server.say(who, who, f"/start {code}")
    async with asyncio.timeout(60 * pace()):
        while not (told := server.messages(who, by_bot=True)):
            await server.wait(server.seq, 1.0)
    server.tap(who, who, told[-1]["message_id"], "Join")
    listed = re.compile(rf"{as_what}.*telegram:{who} ")
    async with asyncio.timeout(60 * pace()):
        while not listed.search((await asyncio.to_thread(rosic, "people", "-c", config)).out):
            await server.wait(server.seq, 0.5)


@asynccontextmanager
async def at_terminal(config: Path, token: str) -> AsyncIterator[Terminal]:
    """Let a gateway run at a terminal while inside."""
    terminal = rosic_run(config, {"LAB_TOKEN": token}, types=False)
    try:
        yield terminal
    finally:
        await asyncio.to_thread(terminal.end)


async def invited(config: Path, *arguments: str) -> str:
    """Return the code in the link that an invitation shows."""
    ran = await asyncio.to_thread(rosic, "invite", *arguments, "-c", config)
    link = re.search(r"https://t\.me/\w+\?start=(\S+)", ran.out)
    assert link is not None, ran
    return link[1]


@pytest.mark.limit(300)
async def test_the_first_start_shows_a_code_and_whoever_sends_it_is_the_admin(
    tmp_path: Path,
) -> None:
    async with FakeTelegram(limits=None) as server:
        config = write_config(tmp_path, TELEGRAM, api_base=server.api_base)
        async with at_terminal(config, server.token) as terminal:
            await asyncio.to_thread(terminal.wait_for, "start=")
            await asyncio.to_thread(terminal.wait_for, "█")
            [code] = set(CODE.findall(terminal.shown))
            assert f"https://t.me/{server.world.bot.username}?start={code}" in terminal.shown
            assert code not in terminal.log()
            kept = everything(tmp_path)
            assert code.encode() not in kept
            assert code.replace("-", "").encode() not in kept

            await joins(server, config, server.create_user("Eve"), code, "as admin · ")
            code = await invited(
                config, "--role", "operator", "--robot", "omni", "--for", "2h", "--plain"
            )
            student = server.create_user("Cy")
            await joins(server, config, student, code, "as operator on omni, until ")

        async with at_terminal(config, server.token) as again:
            async with asyncio.timeout(60 * pace()):
                while "listening" not in again.log():  # noqa: ASYNC110
                    await asyncio.sleep(0.05)
            again.look()
            assert again.shown == ""


async def test_where_nobody_sits_no_code_is_shown(tmp_path: Path) -> None:
    async with FakeTelegram(limits=None) as server:
        config = write_config(tmp_path, TELEGRAM, api_base=server.api_base)
        with gateway(config, env={"LAB_TOKEN": server.token}, ready=False) as running:
            await asyncio.to_thread(
                running.wait_for, "nobody is admin here yet: rosic invite --role admin", log=True
            )
            assert CODE.search(running.out() + running.err()) is None

            out = (await asyncio.to_thread(rosic, "invite", "--role", "admin", "-c", config)).out
            assert f"https://t.me/{server.world.bot.username}?start=" in out
            assert "Nobody is admin here yet." in out
