"""docs/howto/add-a-robot-link.md, followed word by word: a folder and an entry point suffice."""

from __future__ import annotations

import asyncio
import json
import os
import re
import signal
import subprocess
import sys
from contextlib import asynccontextmanager, suppress
from importlib import import_module, invalidate_caches
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jsonschema
import pytest
import yaml

from rosic.config.profiles import shipped_profiles
from rosic.testing.robots import RobotConformance
from tests.cli.running import ROSIC, cold_rosic, environment
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

PAGE = Path(__file__).parents[2] / "docs" / "howto" / "add-a-robot-link.md"
FILE = re.compile(r"^`([\w./-]+)`[^\n]*:\n\n```\w+\n(.*?)^```", re.MULTILINE | re.DOTALL)
TABLE = re.compile(r"```toml\n(.*?)```", re.DOTALL)
SAID = re.compile(r"```text\n(crawler\.yaml.*?)```", re.DOTALL)
DRIVEN = re.compile(r"```text\n(> .*?)```", re.DOTALL)
PYTEST = re.compile(r"`pytest (-o asyncio_mode=auto test_crawler\.py)`")
# Nothing here uses these, and what they bring takes longer to load than a rule to be tried.
UNUSED = ("-pno:cacheprovider", "-pno:faker", "-pno:schemathesis")
RULES = sum(name.startswith("test_") for name in vars(RobotConformance))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Write the files of the page, as it names them."""
    for name, content in FILE.findall(PAGE.read_text(encoding="utf-8")):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
    return tmp_path


def with_it(folder: Path) -> dict[str, str]:
    """Return an environment in which the example is installed: its folder is on the path."""
    return {"PYTHONPATH": f"{environment()['PYTHONPATH']}{os.pathsep}{folder}"}


def checked(folder: Path, *changes: tuple[str, str]) -> str:
    """Change the profile, look at it with the command, and return what that says."""
    text = (folder / "crawler.yaml").read_text(encoding="utf-8")
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    (folder / "crawler.yaml").write_text(text, encoding="utf-8")
    ran = cold_rosic("robot", "check", "crawler.yaml", cwd=folder, env=with_it(folder))
    assert (ran.status == 0) == (not ran.err), ran
    return ran.out + ran.err


def conforming(folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """Run the tests of the page as it says; options are added."""
    [words] = PYTEST.findall(PAGE.read_text(encoding="utf-8"))
    return subprocess.run(  # noqa: S603 - our own tests
        [sys.executable, "-m", "pytest", "-q", *UNUSED, *words.split(), *options],
        cwd=folder,
        env=environment(with_it(folder)),
        capture_output=True,
        text=True,
        check=False,
        timeout=300 * pace(),
    )


def test_its_robot_keeps_every_rule(folder: Path) -> None:
    ran = conforming(folder)
    assert f"{RULES} passed" in ran.stdout, ran.stdout + ran.stderr


LOST = 'raise RobotUnreachable(f"{self.profile.shown} does not answer. It may have moved.")'
HALTED_LOST = "        await self._to_rest()  # what is not heard may hear\n"
# Told whenever it comes: the order may have ended before.
AT = "self._answers.put_nowait(float(line[3:]))"
TOLD_AT_ONCE = "self._tell(StageReport(OrderStage.RUNNING, min(1.0, max(0.0, float(line[3:])))))"
MEASURED = "rested, _seconds = await self._to_rest(halt=False)"
UNHEARD = "test_nothing_is_received_or_done_without_the_robots_word"
SILENT = "test_a_silent_robot_is_offline_and_is_sent_nothing"
VANISHED = "test_a_robot_lost_while_it_moves_is_stopped_and_ends_in_doubt"
CLOSED = "test_closing_brings_the_robot_to_rest"
DONE = "test_done_is_said_only_of_a_robot_at_rest"
PROGRESS = "test_progress_is_checked_and_ends_with_the_order"


@pytest.mark.parametrize(
    ("rule", "changes"),
    [
        (
            "test_a_stop_is_latched_at_once",
            [("        self.gate.apply_stop(stop)  #", "        #")],
        ),
        (
            "test_a_stop_ends_what_is_under_way",
            [("self._send(self.profile.stop.line)", "pass")],
        ),
        (
            "test_the_same_order_again_does_nothing",
            [("self.gate.pass_order(order, ", "print(order, ")],
        ),
        (
            UNHEARD,
            [("(OrderStage.SENT))", "(OrderStage.SENT)); tell(StageReport(OrderStage.RECEIVED))")],
        ),
        (UNHEARD, [(LOST, "return Outcome(OrderEnding.DONE)")]),
        (CLOSED, [("        if self._doing:\n            await self._to_rest()\n", "")]),
        (SILENT, [("online=age_s is not None and age_s < ", "online=age_s is not None or ")]),
        (SILENT, [("if not self.presence().online:  #", "if self._writer is None:  #")]),
        (VANISHED, [(HALTED_LOST, "")]),
        (VANISHED, [(LOST, "return Outcome(OrderEnding.CANCELLED)")]),
        (DONE, [(MEASURED, "rested = True")]),
        (PROGRESS, [("progress.reported(answer)", "answer")]),
        (PROGRESS, [("progress.reported(answer)", "max(0.0, min(1.0, answer))")]),
        (
            PROGRESS,
            [
                ("        self._doing = order.skill.id\n", "        self._tell = tell\n"),
                (AT, TOLD_AT_ONCE),
            ],
        ),
    ],
)
def test_a_robot_that_breaks_a_rule_is_caught(
    folder: Path, rule: str, changes: list[tuple[str, str]]
) -> None:
    robot = folder / "crawler_link" / "__init__.py"
    text = robot.read_text(encoding="utf-8")
    for right, wrong in changes:
        assert text.count(right) == 1, right
        text = text.replace(right, wrong)
    robot.write_text(text, encoding="utf-8")
    tests = folder / "test_crawler.py"  # what never comes is not waited for as long
    text = tests.read_text(encoding="utf-8").replace(
        "    short, ", "    bound_s = 10.0\n    short, "
    )
    tests.write_text(text, encoding="utf-8")
    ran = conforming(folder, "-k", rule)
    assert f"FAILED test_crawler.py::TestCrawler::{rule}" in ran.stdout, ran.stdout


def test_its_profile_is_good_and_without_a_rest_it_is_not(folder: Path) -> None:
    good, wrong = SAID.findall(PAGE.read_text(encoding="utf-8"))
    assert checked(folder) == good
    assert checked(folder, ("at_rest: { below_m_s: 0.01 }\n", "")) == wrong
    said = checked(folder, ("stop: { line: HALT }\n", "unstoppable: true\n"))
    assert said == good


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("port: 4711", "port: 70000", "crawler.yaml:3: 'port' must be between 1 and 65535."),
        (
            "port: 4711",
            "port: 4711, namespace: /x",
            "crawler.yaml:3: 'namespace' is not known here. Known here: heartbeat_s, host, kind",
        ),
        ("{ line: HALT }", "{ service: /halt }", "crawler.yaml:4: 'service' is not known here."),
        ("below_m_s: 0.01", "below_m_s: 2", "crawler.yaml:5: 'below_m_s' must be between 0.001"),
        (
            "$speed]",
            "$sped]",
            "crawler.yaml:8: $sped is not a parameter of this skill. Did you mean speed?",
        ),
        (
            ", $speed]",
            "]",
            "crawler.yaml:11: 'speed' is asked of people but never sent to the robot.",
        ),
        (
            "[GO, $distance, $speed]",
            "[]",
            "crawler.yaml:7: 'go' has no line. Write line: [GO].",
        ),
        ("    line:", "    topic:", "crawler.yaml:8: 'topic' is not known here."),
        ("title: Crawler", "camera: { topic: /c }", "crawler.yaml:2: 'camera' is not known here."),
        ("title: Crawler", "tilte: Crawler", "'tilte' is not known here. Did you mean title?"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(
    folder: Path, right: str, wrong: str, said: str
) -> None:
    assert said in checked(folder, (right, wrong))


def test_its_keys_are_in_the_schema_and_those_of_others_stay(folder: Path) -> None:
    made = subprocess.run(  # noqa: S603 - our own command
        [sys.executable, "-m", "rosic.config.json_schema", str(folder / "schema")],
        env=environment(with_it(folder)),
        capture_output=True,
        check=False,
    )
    assert made.returncode == 0, made.stderr
    schema = json.loads((folder / "schema" / "robot.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    known = jsonschema.Draft202012Validator(schema)
    crawler = read(folder / "crawler.yaml")
    assert known.is_valid(crawler)
    for path in shipped_profiles().values():
        assert known.is_valid(read(path)), path
    assert not known.is_valid(crawler | {"joints": {}})
    assert not known.is_valid(crawler | {"link": crawler["link"] | {"port": 0}})
    assert not known.is_valid(read(shipped_profiles()["omni"]) | {"stop": {"line": "HALT"}})
    link = schema["$defs"]["crawler.Link"]["properties"]
    assert link["port"]["description"] == "Where it listens."


def read(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
    return found


async def test_it_is_driven_through_a_gateway_and_stopped(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(folder))
    monkeypatch.delitem(sys.modules, "trial", raising=False)
    invalidate_caches()
    [table] = TABLE.findall(PAGE.read_text(encoding="utf-8"))
    [driven] = DRIVEN.findall(PAGE.read_text(encoding="utf-8"))
    async with import_module("trial").TrialCrawler() as trial:
        checked(folder, ("port: 4711", f"port: {trial.port}"))
        config = await asyncio.to_thread(configured, folder, table)
        async with running(folder, config) as terminal:
            for line in driven.splitlines():
                await terminal.follow(line)
        assert trial.acted == 2


def configured(folder: Path, table: str) -> Path:
    path = folder / "rosic.toml"
    path.write_text(
        f'[[messenger]]\nkind = "terminal"\n{table}\n[[principal]]\nname = "Ada"\n'
        f'address = "terminal:{os.getuid()}"\nrole = "admin"\n',
        encoding="utf-8",
    )
    path.chmod(0o600)
    good = cold_rosic("check", "-c", path, env=with_it(folder))
    assert good.status == 0, good.err
    return path


class Terminal:
    """Whoever sits before a gateway."""

    def __init__(self, process: asyncio.subprocess.Process, log: Path) -> None:
        self.process = process
        self._log = log

    async def follow(self, line: str) -> None:
        """Say a line that begins with the prompt; wait for any other to be said."""
        assert self.process.stdin is not None
        if line.startswith("> "):
            self.process.stdin.write(f"{line[2:]}\n".encode())
            return
        heard = ""
        try:
            async with asyncio.timeout(60 * pace()):
                while line not in heard:
                    heard += await self._next()
        except (TimeoutError, EOFError):
            raise AssertionError(f"no {line!r} in {heard} {self._log.read_text()}") from None

    async def _next(self) -> str:
        assert self.process.stdout is not None
        line = await self.process.stdout.readline()
        if not line:
            raise EOFError
        return line.decode()


@asynccontextmanager
async def running(folder: Path, config: Path) -> AsyncIterator[Terminal]:
    pipe = asyncio.subprocess.PIPE
    with (folder / "log").open("w") as log:
        process = await asyncio.create_subprocess_exec(
            *ROSIC,
            *("run", "-c", str(config)),
            env=environment(with_it(folder)),
            stdin=pipe,
            stdout=pipe,
            stderr=log,
        )
    try:
        yield Terminal(process, folder / "log")
    finally:
        with suppress(ProcessLookupError):
            process.send_signal(signal.SIGTERM)
        await process.communicate()
