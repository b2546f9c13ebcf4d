"""The ``rosic`` commands against a gateway elsewhere, over HTTP, from a folder without a file."""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING, NamedTuple

import pytest

from rosic.cli.main import main
from tests.api.served import served

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine
    from pathlib import Path
    from typing import TypeAlias

    from tests.api.served import ServedGateway

    Run: TypeAlias = Callable[..., Coroutine[None, None, "Ran"]]


MOVE = ("order", "omni", "move", "distance=0.1", "direction=left")


class Ran(NamedTuple):
    status: int
    out: str
    err: str


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    monkeypatch.chdir(tmp_path)
    for name in ("ROSIC_URL", "ROSIC_KEY", "ROSIC_CA"):
        monkeypatch.delenv(name, raising=False)

    async def ran(*words: str) -> Ran:
        capsys.readouterr()
        status = await asyncio.to_thread(main, words)
        return Ran(status, *capsys.readouterr())

    return ran


async def key_file(place: ServedGateway, folder: Path, *roles: str, name: str = "Hal") -> Path:
    path = folder / f"{name}.key"
    path.write_text(f"{await place.key(*roles, name=name)}\n")
    return path


async def test_robots_are_shown_ordered_stopped_and_resumed(run: Run, tmp_path: Path) -> None:
    async with served() as place:
        where = ("--url", place.url, "--key-file", str(await key_file(place, tmp_path, "operator")))
        shown = await run("status", "omni", *where)
        assert (shown.status, shown.err) == (0, "")
        assert shown.out.startswith("omni  at rest")
        [listed] = json.loads((await run("status", "omni", "--json", *where)).out)
        assert listed["id"] == "omni"
        checked = await run(
            "order", "omni", "move", "distance=0.1", "direction=left", "--check", *where
        )
        assert checked.out == "omni: move, 0.10 m left. Nothing was done.\n"
        moved = await run(
            "order", "omni", "move", "distance=0.1", "direction=left", "--wait", *where
        )
        assert moved.status == 0, moved
        assert moved.out.splitlines()[-1].endswith("  done  moved 0.10 m left"), moved.out
        assert "move, 0.10 m left" in (await run("orders", *where)).out
        assert "move, 0.10 m left" in (await run("history", "--robot", "omni", *where)).out
        stopped = await run("stop", "omni", *where)
        assert (stopped.status, stopped.err) == (0, "")
        assert "omni" in stopped.out
        refused = await run("order", "omni", "move", "distance=0.1", *where)
        assert refused.status == 1
        assert "stopped" in refused.err
        assert (await run("resume", "omni", *where)).status == 0
        assert not place.gateway.rooms.stops["omni"].latched


async def test_url_and_key_may_stand_in_the_environment(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with served() as place:
        monkeypatch.setenv("ROSIC_URL", place.url)
        monkeypatch.setenv("ROSIC_KEY", await place.key("operator"))
        assert (await run("stop")).status == 0
        assert place.gateway.rooms.stops["kuka1"].latched
        here = await run("status", "-c", "none.toml")
        assert here.status == 2
        assert "none.toml" in here.err


async def test_each_failure_is_one_sentence(run: Run, tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.key"
    wrong.write_text("rosic_k0000000000000000_notakeyofanygatewayanywhere")
    none = tmp_path / "none.key"
    none.write_text("hunter2")
    async with served() as place:
        good = str(await key_file(place, tmp_path, "viewer"))
        for words, why in {
            ("status", "--url", place.url, "--key-file", str(wrong)): "no key of a program here",
            ("stop", "--url", place.url, "--key-file", str(wrong)): "no key of a program here",
            ("status", "--url", place.url, "--key-file", str(none)): "That is no key of a gateway",
            ("status", "--url", place.url, "--key-file", "missing"): "missing cannot be read",
            ("status", "--url", place.url): "No key is named",
            ("status", "--url", "robots.lab", "--key-file", good): "is no address of a gateway",
            ("status", "--url", "http://robots.lab", "--key-file", good): "is not encrypted",
            (
                "status",
                "--url",
                "http://127.0.0.1:9",
                "--key-file",
                good,
            ): "No gateway can be",
            (
                "status",
                "--url",
                f"{place.url}/there",
                "--key-file",
                good,
            ): "nothing at this",
            ("order", "omni", "move", "--url", place.url, "--key-file", good): "distance",
            ("order", "omni", "move", "far", "--url", place.url): "is no NAME=VALUE",
            ("order", "omni", "move", "distance=1"): "No gateway is named.",
            ("status", "-c", "x", "--url", place.url): "not both",
        }.items():
            ran = await run(*words)
            assert ran.status in {1, 2}, words
            assert why in ran.err, (words, ran)
            assert ran.err.count("\n") == 1
            assert "hunter2" not in ran.err
            assert "Traceback" not in ran.err
        ordered = await run(
            "order", "omni", "move", "distance=0.1", "--url", place.url, "--key-file", good
        )
        assert ordered.status == 1
        assert not place.gateway.rooms.linker.presence("omni").doing
