"""`rosic init`: a few answers, and a configuration that `rosic check` accepts, or nothing."""

from __future__ import annotations

import os
import stat
from typing import TYPE_CHECKING

import pytest

from rosic.app.config import load_config
from rosic.app.setup.init import SetupAnswers, found, zone_here
from rosic.cli.main import main
from rosic.config.profiles import shipped_profiles
from rosic.errors import ConfigurationError
from rosic.system import SystemClock
from tests.cli.running import rosic

if TYPE_CHECKING:
    from pathlib import Path

TOKEN = "4242424242:" + "abc" * 12
DRAFT = """
id: rover
title: Rover
link: { kind: memory }
skills:
  home: { title: Home, class: task }
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    capsys.readouterr()
    status = main(["init", *arguments])
    return status, *capsys.readouterr()


def left(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def test_without_a_question_it_writes_what_can_be_started(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status, out, err = said(capsys, "--yes")

    assert (status, err) == (0, "")
    assert out == "Written: rosic.toml. Start with: rosic run\n"
    assert main(["check"]) == 0
    config = load_config(folder / "rosic.toml")
    assert [robot.id for robot in config.robots] == ["omni", "kuka1"]
    assert [str(a) for p in config.people for a in p.addresses] == [f"terminal:{os.getuid()}"]


def test_questions_are_asked_and_answered(folder: Path) -> None:
    answers = (
        f"My lab\nEurope/Vinna\nEurope/Vienna\nnonsense\n{TOKEN}\n\nomin\nomni, yumi\n"
        "perhaps\ny\n@ada\n1001\n"
    )
    ran = rosic("init", stdin=answers, cwd=folder)

    assert (ran.status, ran.err) == (0, "")
    for wrong in (
        "Did you mean Europe/Vienna?",
        "That does not look like a Telegram token.",
        "No profile is called 'omin'. Did you mean omni?",
        "Please say yes or no.",
        "'@ada' is not a Telegram id",
    ):
        assert wrong in ran.out, "it is asked again"
    assert ran.out.endswith("Written: telegram-token.txt, rosic.toml. Start with: rosic run\n")
    assert TOKEN not in ran.out
    assert TOKEN not in (folder / "rosic.toml").read_text()
    assert stat.S_IMODE((folder / "telegram-token.txt").stat().st_mode) == 0o600
    config = load_config(folder / "rosic.toml")
    assert (config.name, config.zone) == ("My lab", "Europe/Vienna")
    assert [robot.id for robot in config.robots] == ["omni", "yumi"]
    assert [robot.link.kind for robot in config.robots] == ["simulated", "simulated"]
    assert [str(a) for p in config.people for a in p.addresses] == ["telegram:1001"]
    assert rosic("check", cwd=folder).status == 0


def test_everything_can_be_said_by_options(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LAB_TOKEN", TOKEN)
    status, out, _ = said(
        capsys,
        "--yes",
        "--name",
        'The "lab"',
        "--zone",
        "Europe/Vienna",
        "--token-env",
        "LAB_TOKEN",
        "--robot",
        "omni",
        "cf1",
        "--link",
        "ros2",
        "--admin",
        "code",
        "-c",
        "place.toml",
    )

    assert status == 0
    assert out.startswith("Written: place.toml. Start with: rosic run -c place.toml\n")
    assert out.endswith("Whoever sends it first is the admin.\n")
    assert left(folder) == ["place.toml"]
    config = load_config("place.toml")
    assert (config.name, config.zone, config.people) == ('The "lab"', "Europe/Vienna", ())
    assert {robot.link.kind for robot in config.robots} == {"ros2"}


def test_what_cannot_be_simulated_is_said_before_the_next_question(folder: Path) -> None:
    ran = rosic("init", stdin="\n\n\n\nomni rover\n\n", cwd=folder)

    assert (ran.status, ran.err) == (0, "")
    said, asked = ran.out.index("rover cannot be simulated here"), ran.out.index("Simulate omni")
    assert said < asked
    config = load_config(folder / "rosic.toml")
    assert [(robot.id, robot.link.kind) for robot in config.robots] == [
        ("omni", "simulated"),
        ("rover", "ros2"),
    ]


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("simulated", "There is no simulated machine called 'table'."),
        ("bus", "There is no robot link of the kind 'bus'."),
    ],
)
def test_a_file_of_a_robot_that_cannot_be_reached_is_asked_for_again(
    folder: Path, kind: str, said: str
) -> None:
    rover = shipped_profiles()["rover"].read_text()
    table = rover.replace("kind: ros2", f"kind: {kind}").replace("id: rover", "id: table")
    (folder / "table.yaml").write_text(table)
    ran = rosic("init", "--no-telegram", stdin="\n\n\n./table.yaml\nomni\n\n", cwd=folder)

    assert (ran.status, ran.err) == (0, "")
    assert said in ran.out
    assert [robot.id for robot in load_config(folder / "rosic.toml").robots] == ["omni"]


def test_where_nothing_can_be_simulated_it_is_not_asked(folder: Path) -> None:
    ran = rosic("init", "--no-telegram", stdin="\n\n\nrover\n", cwd=folder)

    assert (ran.status, ran.err) == (0, "")
    assert "rover cannot be simulated here: it is looked for on ROS 2." in ran.out
    assert "Simulate" not in ran.out
    assert [robot.link.kind for robot in load_config(folder / "rosic.toml").robots] == ["ros2"]


def test_a_robot_that_was_to_be_simulated_and_cannot_is_asked_for_again(folder: Path) -> None:
    arguments = ("init", "--no-telegram", "--link", "simulated")
    ran = rosic(*arguments, stdin="\n\n\nrover\nyumi\n", cwd=folder)

    assert (ran.status, ran.err) == (0, "")
    assert "There is no simulated machine called 'rover'." in ran.out
    assert [robot.id for robot in load_config(folder / "rosic.toml").robots] == ["yumi"]


@pytest.mark.parametrize("name", ["rosic.toml", "telegram-token.txt"])
def test_nothing_is_overwritten(folder: Path, name: str) -> None:
    (folder / name).write_text("precious")

    ran = rosic("init", stdin=f"\n\n{TOKEN}\n\n\n\n\n", cwd=folder)

    assert ran.status == 2
    assert "it was left alone" in ran.err
    assert len(ran.err.strip().splitlines()) == 1
    assert left(folder) == [name]
    assert (folder / name).read_text() == "precious"


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("--robot omin", "No profile is called 'omin'. Did you mean omni?"),
        ("--robot rover --link simulated", "There is no simulated machine called 'rover'."),
        (f"--token-env {TOKEN}", "takes the NAME of a variable"),
        ("--token-env NO_SUCH", "The environment variable NO_SUCH is not set."),
        ("--token-file none.txt", "to read a secret from"),
        ("--admin 1001", "there is no Telegram here."),
        ("--token-env BAD", "does not look like a Telegram token."),
        ("--token-env LAB_TOKEN --admin @ada", "'@ada' is not a Telegram id"),
        ("--zone Europe/Vinna", "Did you mean Europe/Vienna?"),
        ("--name " + "x" * 65, "is not a name."),
        ("-c /sys/rosic.toml", "This cannot be written"),
    ],
)
def test_a_mistake_is_one_sentence_and_nothing_is_written(
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    arguments: str,
    sentence: str,
) -> None:
    monkeypatch.setenv("LAB_TOKEN", TOKEN)
    monkeypatch.setenv("BAD", "nonsense")
    status, out, err = said(capsys, "--yes", *arguments.split())

    assert (status, out) == (2, "")
    [line] = err.splitlines()
    assert sentence in line
    assert TOKEN not in line
    assert left(folder) == []


@pytest.mark.parametrize(
    ("said", "link", "zone"),
    [
        ("", "/usr/share/zoneinfo/Europe/Vienna", "Europe/Vienna"),
        ("", "/usr/share/zoneinfo/Etc/UTC", "UTC"),
        ("", "/etc/some-file-that-is-no-link", "UTC"),
        (":Asia/Tokyo", "/usr/share/zoneinfo/Europe/Vienna", "Asia/Tokyo"),
        ("<+03>-3", "/usr/share/zoneinfo/Europe/Vienna", "UTC"),
    ],
)
def test_the_zone_is_that_of_the_machine(
    folder: Path, monkeypatch: pytest.MonkeyPatch, said: str, link: str, zone: str
) -> None:
    monkeypatch.setenv("TZ", said)
    (folder / "localtime").symlink_to(link)

    assert zone_here(folder / "localtime") == zone


def test_answers_that_end_too_soon_write_nothing(folder: Path) -> None:
    ran = rosic("init", stdin="lab\n", cwd=folder)

    assert ran.status == 2
    assert "The questions were not answered to the end. Nothing was written." in ran.err
    assert left(folder) == []


def test_drafts_become_profiles_of_their_own(folder: Path) -> None:
    path = folder / "rosic.toml"
    made = found(path, SetupAnswers(name="lab", drafts={"rover": DRAFT}), SystemClock())

    assert left(folder) == ["robots/rover.yaml", "rosic.toml"]
    assert list(made.written) == [str(folder / "robots/rover.yaml"), str(path)]
    assert [robot.id for robot in load_config(path).robots] == ["rover"]


def test_a_draft_that_is_no_profile_takes_everything_back(folder: Path) -> None:
    answers = SetupAnswers(name="lab", drafts={"rover": DRAFT.replace("task", "fly")})
    with pytest.raises(ConfigurationError, match=r"rover\.yaml:6"):
        found(folder / "rosic.toml", answers, SystemClock())

    assert left(folder) == []


def test_no_robot_is_no_configuration(folder: Path) -> None:
    with pytest.raises(ConfigurationError, match="There is no robot"):
        found(folder / "rosic.toml", SetupAnswers(name="lab"), SystemClock())
    assert left(folder) == []


def test_a_profile_of_ones_own_is_taken_from_where_it_lies(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "rover.yaml").write_text(DRAFT)
    status, _, err = said(capsys, "--yes", "--robot", "./rover.yaml", "omni")

    assert (status, err) == (0, "")
    assert left(folder) == ["rosic.toml", "rover.yaml"]
    config = load_config(folder / "rosic.toml")
    assert [(robot.id, robot.link.kind) for robot in config.robots] == [
        ("omni", "simulated"),
        ("rover", "memory"),
    ]
    assert 'profile = "./rover.yaml"' in (folder / "rosic.toml").read_text()


def test_a_profile_elsewhere_is_named_by_its_whole_path(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "here").mkdir()
    (folder / "rover.yaml").write_text(DRAFT)
    status, _, err = said(capsys, "--yes", "--robot", "rover.yaml", "-c", "here/rosic.toml")

    assert (status, err) == (0, "")
    assert [robot.id for robot in load_config(folder / "here" / "rosic.toml").robots] == ["rover"]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [(None, "There is no such file."), ("id: rover\nskils: {}\n", "rover.yaml:2")],
)
def test_a_profile_that_is_none_writes_nothing(
    folder: Path, capsys: pytest.CaptureFixture[str], text: str | None, sentence: str
) -> None:
    if text is not None:
        (folder / "rover.yaml").write_text(text)
    before = left(folder)
    status, _, err = said(capsys, "--yes", "--robot", "./rover.yaml")

    assert status == 2
    assert sentence in err
    assert left(folder) == before
