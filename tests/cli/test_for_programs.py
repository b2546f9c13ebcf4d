"""What programs and shells read: JSON, exit statuses, completion; and `rosic resume`."""

from __future__ import annotations

import json
import re
import subprocess
from typing import TYPE_CHECKING

import pytest

from rosic.cli.main import COMMANDS, main
from tests.cli.offline import MEMORY, Place
from tests.cli.running import gateway, rosic, write_config
from tests.cli.terminal import shell_at
from tests.pace import pace
from tests.servers import needed

if TYPE_CHECKING:
    from pathlib import Path


LEVEL = '[[principal]]\nname = "Vi"\naddress = "terminal:4242"\nrole = "viewer"\n'


@pytest.fixture
def place(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Place:
    return Place(tmp_path, capsys, MEMORY + LEVEL)


@pytest.mark.usefixtures("running")
def test_resume_undoes_what_stop_did_and_asks_which_of_several(config: Path) -> None:
    assert rosic("resume", "-c", config).out == "Nothing is stopped there.\n"
    rosic("stop", "omni", "-c", config)
    [omni, kuka] = json.loads(rosic("status", "--json", "omni", "kuka1", "-c", config).out)
    assert (omni["stopped"], omni["stopped_by"], kuka["stopped"]) == (True, "operator", False)
    ran = rosic("resume", "-c", config)
    assert (ran.status, "omni is ready again." in ran.out) == (0, True)
    [omni] = json.loads(rosic("status", "--json", "omni", "-c", config).out)
    assert (omni["robot"], omni["online"], omni["stopped"]) == ("omni", True, False)

    rosic("stop", "-c", config)
    several = rosic("resume", "-c", config)
    assert several.status == 1
    assert "omni, kuka1" in several.err
    assert rosic("resume", "kuka1", "-c", config).status == 0
    assert json.loads(rosic("status", "--json", "omni", "-c", config).out)[0]["stopped"]
    assert rosic("resume", "--all", "-c", config).status == 0
    assert not json.loads(rosic("status", "--json", "omni", "-c", config).out)[0]["stopped"]
    assert rosic("resume", "omin", "-c", config).status == 1
    assert rosic("resume", "omni", "--all", "-c", config).status == 1


def test_resume_without_a_gateway_says_so(place: Place) -> None:
    assert "No gateway is running" in place.wrong("resume", "omni")


@pytest.mark.usefixtures("running")
def test_people_and_keys_of_a_running_gateway_are_lists(config: Path) -> None:
    people = json.loads(rosic("people", "--json", "-c", config).out)
    assert {person["state"] for person in people} == {"good"}
    keys = json.loads(rosic("key", "list", "--json", "-c", config).out)
    assert {key["person"] for key in keys} == {person["id"] for person in people}


def test_people_and_keys_are_lists_without_a_gateway_too(place: Place) -> None:
    assert json.loads(place.good("people", "--json"))[0] == {"name": "Ada", "state": "configured"}
    place.begun()
    place.good("invite", "--role", "viewer", "--plain")
    place.good("lock", "Vi")
    people = {one["name"]: one for one in json.loads(place.good("people", "--json"))}
    assert people["Vi"]["state"] == "locked"
    assert people["Vi"]["roles"] == ["viewer"]
    assert people["Vi"]["addresses"] == ["terminal:4242"]
    [key] = json.loads(place.good("key list", "Vi", "--json"))
    assert (key["person"], key["state"]) == (people["Vi"]["id"], "good")
    place.good("key revoke", key["id"])
    [key] = json.loads(place.good("key list", "Vi", "--json"))
    assert (key["state"], key["taken_back"][-1]) == ("taken back", "Z")


@pytest.mark.parametrize(
    ("line", "status", "said"),
    [
        ("kuka1 grasp", 1, "Vi may not.\n"),
        ("stop kuka1", 0, "Vi may.\n"),
        ("status kuka1", 0, "Vi may.\n"),
    ],
)
def test_explain_says_no_when_the_answer_is_no(
    place: Place, line: str, status: int, said: str
) -> None:
    told = place.rosic("explain", "Vi", line)
    assert (told.status, told.err) == (status, "")
    assert said in told.out


def test_explain_says_no_to_what_the_robot_refuses_whatever_the_rules_say(place: Place) -> None:
    told = place.rosic("explain", "Ada", "kuka1 grasp 300 N")
    assert told.status == 1
    assert "40 N" in told.out
    assert "Ada may not. The robot's own bounds refuse it, for everybody." in told.out
    assert "Ada may.\n" not in told.out


def test_a_missing_configuration_leads_to_rosic_init(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for command in ("run", "check", "status", "stop", "people"):
        assert main([command]) in {1, 2}
        assert "rosic init" in capsys.readouterr().err


def test_doctor_finds_the_configuration_of_the_folder(tmp_path: Path) -> None:
    write_config(tmp_path, MEMORY)
    ran = rosic("doctor", cwd=tmp_path)
    lines = [line.split()[0] for line in ran.out.splitlines()]
    assert lines[0] == "rosic.toml"
    assert "terminal" in lines


def bash(script: Path, *words: str) -> list[str]:
    """Return what bash offers for the last of these words."""
    typed = " ".join(f"'{word}'" for word in words)
    asked = f"source {script}; COMP_WORDS=({typed}); COMP_CWORD={len(words) - 1}; _rosic"
    done = subprocess.run(  # noqa: S603 - our own script
        ["/bin/bash", "-c", f'{asked}; printf "%s\\n" "${{COMPREPLY[@]}}"'],
        capture_output=True,
        text=True,
        timeout=60 * pace(),
        check=True,
    )
    return done.stdout.split()


def test_a_shell_completes_commands_and_their_options(tmp_path: Path) -> None:
    script = tmp_path / "completion.bash"
    script.write_text(rosic("completion", "bash").out)
    firsts = {name.split()[0] for name in COMMANDS}
    assert set(bash(script, "rosic", "")) == firsts
    assert bash(script, "rosic", "peo") == ["people"]
    assert bash(script, "rosic", "key", "") == ["list", "create", "rotate", "revoke"]
    assert bash(script, "rosic", "people", "--j") == ["--json"]
    assert bash(script, "rosic", "key", "list", "Ada", "--j") == ["--json"]
    assert bash(script, "rosic", "robot", "check", "") == [], "names of files are the shell's own"
    assert bash(script, "rosic", "completion", "b") == ["bash"]


def test_zsh_completes_the_same(tmp_path: Path) -> None:
    zsh, prompt = needed("zsh"), "READY> "
    script = tmp_path / "completion.zsh"
    script.write_text(rosic("completion", "zsh").out)
    with shell_at([zsh, "-f", "-i"], tmp_path, prompt) as shell:
        shell.type(f"source {script.name}; echo so''urced")
        shell.wait_for("sourced")
        for typed, completed in (
            ("rosic peo", "rosic people "),
            ("rosic key rot", "rosic key rotate "),
            ("rosic people --j", "rosic people --json "),
            ("rosic key list Ada --j", "rosic key list Ada --json "),
            ("rosic completion z", "rosic completion zsh "),
            ("rosic robot check com", f"rosic robot check {script.name} "),
        ):
            shell.shown = ""
            shell.type(typed, end="\t")
            shell.wait_for(completed)
            shell.type("\x15", end="")  # take the line away
        shell.type("exit")
        assert shell.ended() == 0


@pytest.mark.usefixtures("running")
def test_history_says_what_the_operator_did_and_asks_for_known_names(config: Path) -> None:
    rosic("stop", "omni", "-c", config)
    assert rosic("resume", "omni", "-c", config).status == 0
    [*_, last] = json.loads(rosic("history", "--json", "--robot", "omni", "-c", config).out)
    assert (last["name"], last["asked"], last["told"]) == (
        "the operator",
        "resume omni",
        "ready again",
    )
    told = rosic("history", "--since", "1h", "-c", config).out
    assert "resume omni" in told
    assert "the operator  stop omni  told to stop" in told
    assert rosic("history", "--robot", "omin", "-c", config).status == 1
    assert rosic("history", "--person", "Zed", "-c", config).status == 1
    assert rosic("history", "--since", "never", "-c", config).status == 1


def test_history_of_one_person_is_theirs_alone(tmp_path: Path) -> None:
    """And all of it, the newest of each as well."""
    config = write_config(tmp_path)
    with gateway(config) as running:
        running.say("omni move 0.1 m")
        running.wait_for(": done ")
        assert rosic("stop", "kuka1", "-c", config).status == 0

        def of(*person: str) -> list[tuple[str, str]]:
            said = rosic("history", "--json", *person, "-c", config)
            return [(one["name"], one["robot"]) for one in json.loads(said.out)]

        everybodys = of()
        assert ("Ada", "omni") in everybodys
        assert {name for name, _ in everybodys} > {"Ada"}
        assert of("--person", "ada") == [one for one in everybodys if one[0] == "Ada"]
        assert of("--person", "Bob") == []


@pytest.mark.usefixtures("running")
def test_history_of_nothing_is_one_sentence_that_says_of_what(config: Path) -> None:
    nothing = rosic("history", "--since", "1h", "--person", "Bob", "-c", config)
    assert re.fullmatch(r"Nothing was asked by Bob since .+\.\n", nothing.out)
    assert nothing.status == 0


def test_history_works_without_a_gateway(place: Place) -> None:
    assert "Nothing was asked for yet" in place.good("history")
    assert json.loads(place.good("history", "--json")) == []
