"""What is kept, looked into, taken out, limited and erased from the command line."""

from __future__ import annotations

import io
import json
import os
from typing import TYPE_CHECKING

import pytest
from openpyxl import load_workbook

from tests.cli.offline import Place
from tests.cli.running import gateway, rosic

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from tests.cli.running import Gateway


@pytest.fixture(scope="module")
def running(config: Path) -> Iterator[Gateway]:
    with gateway(config) as opened:
        for line, answer in (
            ("/archive on", "are kept for"),
            ("=1+1 is no formula", ""),
            ("/data bay = four", "Data stored."),
            ("/data bay", "bay: four"),
        ):
            opened.say(line)
            opened.wait_for(answer)
        yield opened


def good(command: str, *arguments: str | Path, config: Path) -> str:
    ran = rosic(*command.split(), *arguments, "-c", config, cwd=config.parent)
    assert (ran.status, ran.err) == (0, "")
    return ran.out


def chat_of(config: Path) -> str:
    listed = json.loads(good("container list", "--json", config=config))
    (chat,) = [one["container"] for one in listed if one["kind"] == "chat"]
    assert isinstance(chat, str)
    return chat


@pytest.mark.usefixtures("running")
def test_containers_are_listed_and_shown(config: Path) -> None:
    lines = good("container list", config=config).splitlines()
    assert [line.split()[0] for line in lines] == ["robot"] * 2 + ["person"] * 2 + ["chat"]
    assert lines[0].split()[1:] == ["kuka1", "KUKA", "iiwa"]
    assert lines[-1].endswith(f"  terminal private {os.getuid()}")
    shown = good("container show", "Ada", config=config).splitlines()
    assert shown[0].startswith("person Ada (p")
    assert shown[-1] == "  shared data: 1 of 64 names, 7 bytes of 64 KiB"
    as_json = json.loads(good("container show", "Ada", "--json", config=config))
    assert {"kind": "shelf", "count": 1, "size": 10} in as_json["holds"]


@pytest.mark.usefixtures("running")
def test_a_chat_is_exported_in_each_form_and_nothing_is_written_over(config: Path) -> None:
    chat, folder = chat_of(config), config.parent
    said = good("container export", chat, "--as", "text", "-o", "a.txt", config=config)
    assert said.endswith(" in a.txt. It is not sealed: whoever has it can read it.\n")
    assert (folder / "a.txt").stat().st_mode & 0o777 == 0o600
    first = (folder / "a.txt").read_text().splitlines()[1]
    assert first == f"Sender ID: {os.getuid()}, Sender Username: Ada, Message: =1+1 is no formula"
    good("container export", chat, config=config)
    row = json.loads((folder / f"{chat}.jsonl").read_text().splitlines()[1])
    assert (row["way"], row["text"]) == ("in", "=1+1 is no formula")
    good("container export", chat, "--as", "xlsx", "-o", "a.xlsx", config=config)
    sheet = load_workbook(io.BytesIO((folder / "a.xlsx").read_bytes())).worksheets[0]
    assert sheet["F3"].value == "=1+1 is no formula"
    assert sheet["F3"].data_type == "s"

    again = rosic("container", "export", chat, "-o", "a.txt", "-c", config, cwd=folder)
    assert (again.status, again.out) == (2, "")
    assert "a.txt exists. Nothing was written." in again.err
    assert (folder / "a.txt").read_text().splitlines()[1] == first
    (folder / "link").symlink_to(folder / "elsewhere")
    rosic("container", "export", chat, "-o", "link", "-c", config, cwd=folder)
    assert not (folder / "elsewhere").exists()
    good("container export", "Ada", "--as", "text", "-o", "ada.txt", config=config)
    assert "\nKind: command, ID: " in (folder / "ada.txt").read_text()
    good("container export", "Ada", "--as", "xlsx", "-o", "ada.xlsx", config=config)
    sheet = load_workbook(io.BytesIO((folder / "ada.xlsx").read_bytes())).worksheets[0]
    assert [cell.value for cell in sheet[1]] == ["Kind", "ID", "Known", "Sealed"]


@pytest.mark.usefixtures("running")
def test_a_limit_holds_at_once_for_one_alone(config: Path, running: Gateway) -> None:
    said = good("container limit", "Ada", "--names", "1", "--size", "1KiB", config=config)
    assert said == "Ada may keep 1 name and 1.0 KiB from now on.\n"
    running.say("/data other = value")
    running.wait_for("keeps at most 1 name. Nothing was kept.")
    shown = json.loads(good("container show", "kuka1", "--json", config=config))
    assert (shown["names_most"], shown["kept_most"]) == (64, 65536)
    wrong = rosic("container", "limit", "Ada", "--size", "much", "-c", config)
    assert "Write --size 64KiB." in wrong.err


@pytest.mark.usefixtures("running")
def test_a_person_is_erased_after_a_question_and_is_gone(config: Path) -> None:
    asked = rosic("container", "erase", "Bob", "-c", config)
    assert (asked.status, asked.out) == (2, "")
    assert "Nothing was erased." in asked.err
    assert good("container erase", "Bob", "--yes", config=config).startswith("Bob is erased.")
    assert "Bob" not in good("container list", config=config)
    last = rosic("container", "erase", "Ada", "--yes", "-c", config)
    assert "Ada is the only admin here. Nothing was erased." in last.err


def test_without_a_gateway_the_data_is_looked_into_and_limited(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    place = Place(tmp_path, capsys).begun()
    place.good("key rotate", "Bob")  # takes the people of the file over
    place.good("invite", "--role", "viewer")  # what codes are known by is sealed for the place
    listed = json.loads(place.good("container list", "--json"))
    assert {one["name"] for one in listed} >= {"Ada", "Bob", "KUKA iiwa", "the operator"}
    assert place.good("container show", "operator").startswith("person the operator (operator)")
    place.good("container limit", "Bob", "--names", "3")
    assert " of 3 names, " in place.good("container show", "Bob")
    assert "1 entry in bob.jsonl." in place.good("container export", "Bob", "-o", "bob.jsonl")
    assert json.loads((tmp_path / "bob.jsonl").read_text())["sealed"]["name"] == "Bob"
    assert place.wrong("container erase", "Bob", "--yes").startswith("Only a running gateway")

    (tmp_path / "rosic-data" / "root.key").unlink()
    assert "key" in place.wrong("container export", "Bob", "-o", "again.jsonl")
    assert not (tmp_path / "again.jsonl").exists()
