"""The ``rosic`` commands against a gateway elsewhere, over HTTP, from a folder without a file."""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING, NamedTuple

import pytest
from msgspec.structs import replace

from rosic.api.schemas import OrderOut
from rosic.cli.main import main
from rosic.cli.remote import is_news
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
        assert (await run("stop", "x" * 70)).status == 0
        assert (await run("stop", "")).status == 0
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


async def test_pictures_and_files_are_saved_and_nothing_is_replaced(
    run: Run, tmp_path: Path
) -> None:
    notes = tmp_path / "notes.txt"
    notes.write_bytes(b"one two three\n" * 1_000)
    async with served() as place:
        where = ("--url", place.url, "--key-file", str(await key_file(place, tmp_path, "operator")))
        shown = await run("picture", "omni", "map.png", "--map", *where)
        assert (shown.status, shown.err) == (0, "")
        assert (tmp_path / "map.png").read_bytes()[:4] in {b"\x89PNG", b"\xff\xd8\xff\xe0"}
        assert (tmp_path / "map.png").stat().st_mode & 0o777 == 0o600
        again = await run("picture", "omni", "map.png", "--map", *where)
        assert (again.status, "is there already" in again.err) == (2, True)
        none = await run("picture", "kuka1", "none.png", "--map", *where)
        assert (none.status, (tmp_path / "none.png").exists()) == (1, False)

        sent = await run("file", "send", "notes.txt", *where)
        assert (sent.status, "notes.txt" in sent.out) == (0, True), sent
        assert "notes.txt" in (await run("file", "list", *where)).out
        [listed] = json.loads((await run("file", "list", "--json", *where)).out)
        got = await run("file", "get", "notes.txt", "copy.txt", *where)
        assert got.status == 0, got
        assert (tmp_path / "copy.txt").read_bytes() == notes.read_bytes()
        for words, why in {
            ("file", "get", "notes.txt", "copy.txt"): "copy.txt is there already",
            ("file", "get", "other.txt", "x.txt"): "You keep no file 'other.txt' there",
            ("file", "send", "missing.txt"): "missing.txt cannot be read",
            ("file", "send", "."): "cannot be read",
        }.items():
            refused = await run(*words, *where)
            assert refused.status in {1, 2}, words
            assert why in refused.err
            assert refused.err.count("\n") == 1
        assert (await run("file", "delete", listed["id"], *where)).status == 0
        assert (await run("file", "list", *where)).out == ""


async def test_the_past_is_shown_as_lines_for_programs_and_as_a_table(
    run: Run, tmp_path: Path
) -> None:
    async with served() as place:
        where = ("--url", place.url, "--key-file", str(await key_file(place, tmp_path, "senior")))
        await run(*MOVE, "--wait", *where)
        shown = await run("history", "--robot", "omni", "--since", "1h", *where)
        assert "move, 0.10 m left  done" in shown.out
        [moved] = json.loads((await run("history", "--robot", "omni", "--json", *where)).out)
        assert moved["skill"] == "move"
        table = await run("history", "--csv", *where)
        assert table.out.startswith("at,who,kind,robot,skill,asked")
        assert "--csv is for a gateway elsewhere" in (await run("history", "--csv", "-c", "x")).err
        assert "nobody else's by name" in (await run("history", "--person", "Bo", *where)).err


@pytest.mark.parametrize(
    "words", [("people",), ("invite",), ("lock", "Bo"), ("unlock", "Bo"), ("doctor",)]
)
async def test_what_no_key_may_is_not_asked_of_a_gateway_elsewhere(
    run: Run, words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        await run(*words, "--url", "https://robots.example.org")
    assert "unrecognized arguments: --url" in capsys.readouterr().err


def test_how_far_an_order_is_is_shown_once_a_second_and_another_stage_at_once() -> None:
    runs = OrderOut("1", "omni", "move", "running", over=False, fraction=0.1)
    further = replace(runs, fraction=0.2)
    assert is_news(runs, None, 0.0)
    assert not is_news(further, runs, 0.9)
    assert is_news(further, runs, 1.0)
    assert not is_news(runs, runs, 5.0)
    assert is_news(replace(further, state="done", over=True), further, 0.0)
