"""Each sentence about a configuration, by a file that causes it, on the line that is to blame."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

import pytest

from rosic.app.config import load_config, read_config
from rosic.errors import ConfigurationError
from tests.config.profile_text import GOOD as PROFILE
from tests.config.profile_text import MARK, marked_line, spoil, write

if TYPE_CHECKING:
    from pathlib import Path

# The token of Telegram's own manual.
TOKEN = "110201543:AAHdqTcvCH1vGWJxfSeofSAs0K5PALDsaw"  # noqa: S105 - nobody's

GOOD = """\
[gateway]
name = "lab"
data = "data"
lease_idle_s = 60
log_level = "info"

[[messenger]]
kind = "telegram"
token = { env = "BOT_TOKEN" }

[[messenger]]
kind = "terminal"

[[robot]]
profile = "robots/rover.yaml"

[[robot]]
profile = "omni"
link = "simulated"

[[principal]]
name = "Admin"
address = "telegram:1001"
role = "admin"

[[principal]]
name = "Student"
addresses = ["telegram:1002", "terminal:local"]
roles = ["viewer", "student"]

[role.student]
scopes = ["rover:move", "omni:read", "*:resume"]

[limits]
burst = 20
per_s = 2
"""


class Case(NamedTuple):
    """The line that carries the mark is the one to be named."""

    name: str
    old: str
    new: str
    sentence: str
    hint: str = ""


CASES = [
    # ---- tables, keys, types ----
    Case(
        "unknown table",
        "[limits]",
        "[limit] #!",
        "'limit' is not known here.",
        "Did you mean limits?",
    ),
    Case(
        "unknown key",
        "lease_idle_s = 60",
        "lease_idle = 60 #!",
        "'lease_idle' is not known here.",
        "Did you mean lease_idle_s?",
    ),
    Case(
        "a table for a list",
        '[[messenger]]\nkind = "telegram"\ntoken = { env = "BOT_TOKEN" }\n\n[[messenger]]\n',
        "[messenger] #!\n",
        "'messenger' must be a list, not a table of keys.",
        "Write [[messenger]], in two pairs of brackets.",
    ),
    Case("missing key", 'profile = "omni"\n', "", "'profile' is missing in 2 of 'robot'."),
    Case(
        "missing scopes",
        'scopes = ["rover:move", "omni:read", "*:resume"]',
        "",
        "The role student gives nothing.",
        "Give it scopes, or includes.",
    ),
    Case(
        "text for a number",
        "burst = 20",
        'burst = "20" #!',
        "'burst' must be a number, not a text.",
    ),
    Case(
        "a date",
        'name = "lab"',
        "name = 2026-11-21 #!",
        "'name' must be a text, not a date or a time.",
    ),
    Case("no number", "per_s = 2", "per_s = nan #!", "'per_s' must be a finite number."),
    Case("bounds", "burst = 20", "burst = 0 #!", "'burst' must be between 1 and 1e+06."),
    Case(
        "lease",
        "lease_idle_s = 60",
        "lease_idle_s = -1 #!",
        "'lease_idle_s' must be between 1 and 86400.",
    ),
    Case(
        "log level",
        'log_level = "info"',
        'log_level = "verbose" #!',
        "'log_level' must be one of debug, info, warning, error.",
    ),
    Case(
        "empty name",
        'name = "lab"',
        'name = "" #!',
        "'' is not a name.",
        "Use 1 to 64 characters of one line.",
    ),
    Case("data", 'data = "data"', 'data = "" #!', "'' is not a folder."),
    Case(
        "a zone that is none",
        'name = "lab"',
        'name = "lab"\nzone = "Europe/Viena" #!',
        'I know no time zone "Europe/Viena". Did you mean Europe/Vienna?',
    ),
    Case(
        "a city for a zone",
        'name = "lab"',
        'name = "lab"\nzone = "berlin" #!',
        'I know no time zone "berlin". Did you mean Europe/Berlin?',
    ),
    Case(
        "a person with more room than all",
        "[limits]",
        "[files]\nperson_mb = 3000 #!\n\n[limits]",
        "One person may keep more than everybody together.",
        "Raise place_mb, or lower person_mb.",
    ),
    Case(
        "no room",
        "[limits]",
        "[files]\nplace_mb = 0 #!\n\n[limits]",
        "'place_mb' must be between 1 and 1e+07.",
    ),
    # ---- messengers ----
    Case(
        "no kind",
        '[[messenger]]\nkind = "terminal"',
        '[[messenger]] #!\nname = "terminal"',
        "A messenger needs a kind that is a text.",
        'For example kind = "telegram".',
    ),
    Case("kind", 'kind = "terminal"', "kind = 1 #!", "A messenger needs a kind that is a text."),
    Case(
        "name",
        'kind = "terminal"',
        'kind = "terminal"\nname = [] #!',
        "A messenger needs a name that is a text.",
    ),
    Case(
        "two of a name",
        'kind = "terminal"',
        'kind = "terminal"\nname = "telegram" #!',
        "Two messengers are called 'telegram'.",
        "Give one another name.",
    ),
    Case(
        "a variable that is not there",
        '"BOT_TOKEN" }',
        '"BOT_TOKN" } #!',
        "The environment variable BOT_TOKN is not set.",
        "Set it where ROSIC is started.",
    ),
    Case(
        "a token for the name of a variable",
        '"BOT_TOKEN" }',
        f'"{TOKEN}" }} #!',
        "'token' names no variable of the environment.",
        "Write the NAME of one that holds the secret, not the secret.",
    ),
    Case(
        "a token for the name of a file",
        '{ env = "BOT_TOKEN" }',
        f'{{ file = "{TOKEN}" }} #!',
        "There is no file *** to read a secret from.",
    ),
    Case("an empty variable", '"BOT_TOKEN" }', '"NOTHING" } #!', "The secret of 'token' is empty."),
    Case(
        "a variable of two lines",
        '"BOT_TOKEN" }',
        '"TWO_LINES" } #!',
        "The secret of 'token' is not one line of plain text.",
    ),
    Case(
        "env and file",
        '{ env = "BOT_TOKEN" }',
        '{ env = "BOT_TOKEN", file = "t" } #!',
        "'token' must say either env or file.",
        'Write { env = "NAME" } or { file = "path" }.',
    ),
    Case(
        "env of a number",
        '{ env = "BOT_TOKEN" }',
        "{ env = 7 } #!",
        "'token' must say either env or file.",
    ),
    Case(
        "no secret file",
        '{ env = "BOT_TOKEN" }',
        '{ file = "none.txt" } #!',
        "There is no file none.txt to read a secret from.",
    ),
    Case(
        "a folder",
        '{ env = "BOT_TOKEN" }',
        '{ file = "robots" } #!',
        "There is no file robots to read a secret from.",
    ),
    Case(
        "a file others read",
        '{ env = "BOT_TOKEN" }',
        '{ file = "open.txt" } #!',
        "Others may read open.txt, which holds a secret.",
        "Run: chmod 600 open.txt",
    ),
    Case(
        "an empty file",
        '{ env = "BOT_TOKEN" }',
        '{ file = "empty.txt" } #!',
        "The secret of 'token' is empty.",
    ),
    Case(
        "a file of bytes",
        '{ env = "BOT_TOKEN" }',
        '{ file = "bytes.txt" } #!',
        "The file bytes.txt cannot be read as a secret.",
    ),
    Case(
        "a name with a null",
        '{ env = "BOT_TOKEN" }',
        '{ file = "a\\u0000b" } #!',
        "There is no file ",
    ),
    # ---- robots ----
    Case(
        "unknown profile",
        'profile = "omni"',
        'profile = "omnii" #!',
        "No profile is called 'omnii'.",
        "Did you mean omni? A file of your own ends in .yaml.",
    ),
    Case(
        "no profile there",
        "robots/rover.yaml",
        "robots/rovr.yaml",
        "There is no profile at robots/rovr.yaml.",
    ),
    Case(
        "the same robot twice",
        'profile = "robots/rover.yaml"',
        'profile = "omni"',
        "Two robots are called 'omni'.",
        "Give one another id.",
    ),
    Case("link", 'link = "simulated"', 'link = "by hand" #!', "'by hand' is not a name."),
    # ---- people ----
    Case(
        "no address",
        'address = "telegram:1001"\n',
        "",
        "Admin has no address, so nobody could write as Admin.",
    ),
    Case("no role", 'role = "admin"\n', "", "Admin has no role, so Admin could do nothing."),
    Case(
        "address",
        '"telegram:1001"',
        '"1001" #!',
        "'1001' is not an address.",
        "Write platform:account, for example telegram:1001.",
    ),
    Case(
        "username",
        '"telegram:1001"',
        '"telegram:@ada" #!',
        "@ada is a username, which can pass to somebody else.",
        "Give the account's number or id.",
    ),
    Case(
        "one address, two people",
        '["telegram:1002"',
        '["telegram:1001"',
        "telegram:1001 already belongs to Admin.",
    ),
    Case(
        "two people of a name",
        'name = "Student"',
        'name = "ADMIN" #!',
        "Two people are called ADMIN.",
        "Tell them apart.",
    ),
    Case(
        "unknown role",
        '"viewer", "student"]',
        '"viewer", "studnt"] #!',
        "No role is called 'studnt'.",
        "Did you mean student?",
    ),
    # ---- roles ----
    Case(
        "no scope",
        '"rover:move"',
        '"rover"',
        "'rover' is no right: write robot, colon and skill, for example omni:move.",
    ),
    Case("half a scope", '"rover:move"', '"rover:"', "'rover:' is no right: "),
    Case(
        "a regular expression",
        '"rover:move"',
        '"rover:(move|drive)"',
        "'rover:(move|drive)' is no right: ",
    ),
    Case(
        "a robot that is not there",
        '"rover:move"',
        '"rovr:move"',
        "No robot or group is called 'rovr'.",
        "Did you mean rover?",
    ),
    Case(
        "a pattern for nobody",
        '"rover:move"',
        '"crazyflie-*:move"',
        "No robot matches 'crazyflie-*'.",
    ),
    Case(
        "a skill that is not there",
        '"rover:move"',
        '"rover:mov"',
        "rover has no skill 'mov'.",
        "Did you mean move?",
    ),
    Case(
        "a role that includes itself",
        '"*:resume"]',
        '"*:resume"]\nincludes = ["student"]',
        "The role student includes itself: student includes student.",
    ),
    Case(
        "a limit on nothing",
        '"*:resume"]',
        '"*:resume"]\nlimits = ["speeed <= 1 m/s"]',
        "No skill given here has a parameter 'speeed'",
    ),
    Case(
        "a limit in a wrong unit",
        '"*:resume"]',
        '"*:resume"]\nlimits = ["distance <= 1 kg"]',
        "On rover, 'distance <= 1 kg' does not fit distance of move",
    ),
    Case(
        "care for nothing",
        "[role.student]",
        '[[care]]\nscopes = ["rovr:move"]\nconfirm = true\n\n[role.student]',
        "No robot or group is called 'rovr'.",
    ),
    Case(
        "care that nothing asks for",
        "[role.student]",
        '[[care]]\nscopes = ["*:resume"] #!\nconfirm = true\n\n[role.student]',
        "'*:resume' is no skill: confirm, step_up and second_person are asked for skills alone.",
    ),
    Case("role name", "[role.student]", '["role"."Stu dent"]', "'Stu dent' is not a name."),
]

ENVIRON = {"BOT_TOKEN": TOKEN, "NOTHING": " \n", "TWO_LINES": f"{TOKEN}\n{TOKEN}"}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "robots").mkdir()
    write(tmp_path / "robots", PROFILE)
    for name, content, mode in (
        ("open.txt", TOKEN.encode(), 0o640),
        ("empty.txt", b"\n", 0o600),
        ("bytes.txt", TOKEN.encode() + b"\xff", 0o600),
    ):
        path = tmp_path / name
        path.write_bytes(content)
        path.chmod(mode)
    return tmp_path


def test_the_file_that_is_spoilt_here_was_good(folder: Path) -> None:
    errors = read_config(write(folder, GOOD, "rosic.toml"), environ=ENVIRON).errors
    assert [str(error) for error in errors] == []


@pytest.mark.parametrize("case", CASES, ids=[case.name for case in CASES])
def test_what_is_wrong_is_said(case: Case, folder: Path) -> None:
    text = GOOD.replace("[role.student]", case.new) if case.name == "role name" else None
    text = text or spoil(case.old, case.new, GOOD)
    path = write(folder, text, "rosic.toml")

    [error] = read_config(path, environ=ENVIRON).errors[:1]

    said = str(error).removeprefix(f"{error.where}: ")
    assert said.startswith(case.sentence)
    assert case.hint in said
    assert "\n" not in said
    assert said.rstrip()[-1] in ".?t"
    assert TOKEN not in said
    if MARK in text:
        assert error.where == f"{path}:{marked_line(text)}"
    with pytest.raises(ConfigurationError) as raised:
        load_config(path, environ=ENVIRON)
    assert str(raised.value) == str(error)


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ("messenger", "There is no [[messenger]], so nobody could talk to a robot."),
        ("robot", "There is no [[robot]]."),
    ],
)
def test_a_gateway_needs_something_on_either_side(
    table: str, sentence: str, tmp_path: Path
) -> None:
    others = {"messenger": 'kind = "terminal"', "robot": 'profile = "yumi"'}
    text = "".join(f"[[{name}]]\n{line}\n" for name, line in others.items() if name != table)
    [error] = read_config(write(tmp_path, text, "rosic.toml"), environ={}).errors
    assert str(error).removeprefix(f"{error.where}: ").startswith(sentence)


def test_what_is_wrong_with_a_profile_is_said_with_its_own_line(folder: Path) -> None:
    text = spoil("link_loss: hold", "link_loss: hodl #!", PROFILE)
    profile = write(folder / "robots", text)
    [error] = read_config(write(folder, GOOD, "rosic.toml"), environ=ENVIRON).errors
    assert error.where == f"{profile}:{marked_line(text)}"


def test_robots_that_could_not_be_told_apart_are_refused(folder: Path) -> None:
    write(folder / "robots", spoil("words: [buggy]", "words: [omni]", PROFILE))
    [error] = read_config(write(folder, GOOD, "rosic.toml"), environ=ENVIRON).errors
    assert '"omni" means both' in str(error)


JUNK = ("7", "[[]]", "{ env = [] }")


@pytest.mark.parametrize("number", range(len(GOOD.splitlines())))
def test_whatever_is_wrong_is_said_and_raises_nothing(number: int, folder: Path) -> None:
    lines = GOOD.splitlines()
    before = lines[number]
    for junk in JUNK:
        lines[number] = f"{before.partition(' = ')[0]} = {junk}" if " = " in before else junk
        path = write(folder, "\n".join(lines), "rosic.toml")
        for error in read_config(path, environ=ENVIRON).errors:
            assert error.where


def test_everything_is_said_at_once(folder: Path) -> None:
    write(folder / "robots", spoil("link_loss: hold", "link_loss: hodl", PROFILE))
    text = spoil('"BOT_TOKEN"', '"BOT_TOKN"', GOOD)
    text = spoil('profile = "omni"', 'profile = "omnii"', text)
    said = [str(e) for e in read_config(write(folder, text, "rosic.toml"), environ=ENVIRON).errors]
    assert len(said) == 3
    for word, sentence in zip(("BOT_TOKN", "link_loss", "omnii"), said, strict=True):
        assert word in sentence


QUOTED = list(re.finditer(r'"[^"]*"', GOOD))


@pytest.mark.parametrize("number", range(len(QUOTED)))
def test_a_token_that_stands_where_something_else_belongs_is_not_shown(
    number: int, folder: Path
) -> None:
    here = QUOTED[number]
    for text in (TOKEN, f"telegram:{TOKEN}", f"bot{TOKEN}"):
        spoilt = f'{GOOD[: here.start()]}"{text}"{GOOD[here.end() :]}'
        for error in read_config(write(folder, spoilt, "rosic.toml"), environ=ENVIRON).errors:
            shown = f"{error} {error.where} {error.hint} {error!r}"
            assert TOKEN.partition(":")[2] not in shown
