"""`rosic check` and `rosic robot check`: everything that is wrong, at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.cli.main import main
from rosic.config.profiles import shipped_profiles
from tests.cli.running import CONFIG, write_config, write_neighbours

if TYPE_CHECKING:
    from pathlib import Path


def test_a_good_configuration_is_told_what_is_in_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_config(tmp_path)

    assert main(["check", "-c", str(path)]) == 0

    assert capsys.readouterr().out == f"{path} is good: 1 messenger, 2 robots, 2 people.\n"
    assert not (tmp_path / "rosic-data").exists()


def test_everything_that_is_wrong_is_said_at_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = CONFIG.replace('kind = "terminal"', 'kind = "terminal"\nbells = true')
    text += '\n[[messenger]]\nkind = "telegramm"\n[[robot]]\nprofile = "yumi"\nlink = "ros3"\n'

    assert main(["check", "-c", str(write_config(tmp_path, text))]) == 2

    said = capsys.readouterr().err
    assert "rosic.toml:2: The messenger terminal does not know the setting bells." in said
    assert "There is no messenger of the kind 'telegramm'. Did you mean telegram?" in said
    assert "There is no robot link of the kind 'ros3'. Did you mean ros2?" in said
    assert said.endswith("3 things are wrong.\n")


def test_what_could_be_better_is_said_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = CONFIG.replace('"admin"', '"viewer"').replace('"operator"', '"viewer"')
    text = text.replace('"terminal:99999"', '"telegram:1001"')

    assert main(["check", "-c", str(write_config(tmp_path, text))]) == 0

    said = capsys.readouterr().out
    assert "Nobody of this file may move omni." in said
    assert "Bob has no address on a messenger of this file." in said
    assert "Nobody is heard at telegram:1001: the messengers of this file are terminal." in said


def test_an_assurance_that_no_conversation_has_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    care = '\n[[care]]\nscopes = ["omni:move"]\nassurance = "{}"\n'
    telegram = CONFIG.replace(
        'kind = "terminal"', 'kind = "telegram"\ntoken = "1:aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"'
    ).replace("terminal:", "telegram:")
    matrix = CONFIG.replace(
        'kind = "terminal"',
        'kind = "matrix"\nname = "lab"\nhomeserver = "https://m.example.org"\n'
        'user = "@robots:example.org"\npassword = "p"\n'
        f'folder = "{tmp_path}/matrix"\nrequire_verified = false',
    )
    for text, wanted, told in (
        (telegram, "e2ee-unverified", True),
        (telegram, "provider-readable", False),
        (matrix, "e2ee-verified", False),
        (matrix, "local", True),
        (CONFIG, "local", False),
    ):
        main(["check", "-c", str(write_config(tmp_path, text + care.format(wanted)))])
        said = capsys.readouterr()
        assert (f"asks for a conversation that is {wanted}" in said.out + said.err) is told, said


def test_an_address_that_nobody_hears_is_named_though_another_is_heard(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = CONFIG.replace(
        'address = "terminal:99999"', 'addresses = ["terminal:99999", "telegrm:1001"]'
    )
    assert "telegrm" in text

    assert main(["check", "-c", str(write_config(tmp_path, text))]) == 0

    said = capsys.readouterr().out
    assert "Nobody is heard at telegrm:1001: the messengers of this file are terminal." in said
    assert "has no address" not in said


@pytest.mark.parametrize(("account", "status"), [("1001", 0), ("ada", 2), ("10x1", 2)])
def test_a_username_is_no_address(
    account: str, status: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    token = tmp_path / "token"
    token.write_text(f"4242424242:{'A' * 35}")
    token.chmod(0o600)
    text = CONFIG.replace('kind = "terminal"', 'kind = "telegram"\ntoken = {{ file = "token" }}')
    text = text.replace("terminal:99999", f"telegram:{account}")

    assert main(["check", "-c", str(write_config(tmp_path, text))]) == status

    wrong = f"telegram:{account} of Bob is no account's id."
    assert (wrong in capsys.readouterr().err) == (status != 0)


def test_a_robot_that_is_somebody_needs_no_messenger(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = f'{CONFIG}\n[[principal]]\nname = "omni"\naddress = "robot:omni"\nrole = "viewer"\n'

    assert main(["check", "-c", str(write_config(tmp_path, text))]) == 0

    assert "has no address" not in capsys.readouterr().out


def test_shipped_profiles_are_good(capsys: pytest.CaptureFixture[str]) -> None:
    files = [str(path) for path in shipped_profiles().values()]

    assert main(["robot", "check", *files]) == 0

    assert capsys.readouterr().out.count(" is good: ") == len(files)


@pytest.mark.parametrize(("kind", "status"), [("ros2", 0), ("ros3", 2)])
def test_a_profile_whose_link_nothing_knows_is_not_good(
    kind: str, status: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "rover.yaml"
    service = "type: std_srvs/srv/Trigger }"
    path.write_text(
        f"id: rover\nlink:\n  kind: {kind}\n  namespace: /\nstop: {{ service: /stop, {service}\n"
        "at_rest: { topic: /odom, type: nav_msgs/msg/Odometry, "
        "field: twist.twist.linear.x, below: 0.01 }\n"
        f"skills:\n  home:\n    service: {{ name: /home, {service}\n"
    )

    assert main(["robot", "check", str(path)]) == status

    told = capsys.readouterr()
    if status:
        wrong = "There is no robot link of the kind 'ros3'. Did you mean ros2?"
        assert (told.out, told.err) == ("", f"{path}:3: {wrong}\n")
    else:
        assert told.out.endswith(f"{path} is good: rover, 1 skill.\n")


def test_what_a_start_would_refuse_is_refused_by_both_checks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "nowhere.yaml"
    path.write_text("id: nowhere\nlink: { kind: simulated }\nskills: { home: { class: task } }\n")

    assert main(["robot", "check", str(path)]) == 2
    assert "There is no simulated machine called 'nowhere'." in capsys.readouterr().err

    text = f'{CONFIG}\n[[robot]]\nprofile = "{path}"\n'
    assert main(["check", "-c", str(write_config(tmp_path, text))]) == 2
    assert "There is no simulated machine called 'nowhere'." in capsys.readouterr().err


def test_robots_that_share_a_namespace_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", "-c", str(write_neighbours(tmp_path))]) == 0
    assert "ant and bee have one namespace, /hill" in capsys.readouterr().out


def test_a_wrong_profile_is_told_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "omni.yaml"
    path.write_text("id: Omni\nlink: { kind: ros2 }\nbusy: perhaps\n")

    assert main(["robot", "check", str(path), str(tmp_path / "nowhere.yaml")]) == 2

    lines = capsys.readouterr().err.splitlines()
    assert any(line.startswith(f"{path}:1: ") for line in lines)
    assert any(line.startswith(f"{path}:3: ") for line in lines)
    assert any("nowhere.yaml" in line for line in lines)
