"""`rosic run` and the commands that reach it, as processes of their own."""

from __future__ import annotations

import asyncio
import os
import re
import signal
import socket
import stat
import time
from typing import TYPE_CHECKING

import pytest

from rosic.testing.telegram import FakeTelegram
from tests.cli.running import CONFIG, TELEGRAM, gateway, rosic, write_config, write_neighbours
from tests.pace import pace, patience

if TYPE_CHECKING:
    from pathlib import Path

MEMORY = CONFIG.replace('"simulated"', '"memory"')
TWO_ADMINS = MEMORY.replace('"operator"', '"admin"')
PEOPLE = "[[messenger]]" + CONFIG.partition("[[messenger]]")[2].partition("[[robot]]")[0]
PEOPLE += "[[principal]]" + CONFIG.partition("[[principal]]")[2]
WRONG_TOKEN = {"LAB_TOKEN": "4242424242:wrong-wrong-wrong-wrong-wrong-wrong"}
OF_ADA = (
    TELEGRAM
    + """
[[principal]]
name = "Ada"
address = "telegram:{ada}"
role = "admin"
"""
)


def one_sentence(err: str) -> str:
    """Return what was said on standard error, which must be one line and no trace."""
    [line] = err.splitlines()
    assert line.startswith("rosic: ")
    assert line.endswith((".", "?"))
    return line.removeprefix("rosic: ")


def test_it_says_when_it_is_ready_and_ends_in_time(tmp_path: Path) -> None:
    with gateway(write_config(tmp_path)) as running:
        running.say("omni move 5 m speed 0.05 m/s")
        running.wait_for("driving")
        begun_s = time.monotonic()
        assert running.end() == 0
        took_s = time.monotonic() - begun_s

        assert took_s < 5 * patience()
        assert re.search(
            r"^\d\d:\d\d:\d\d info rosic.gateway: ready in \d+\.\d\d s: 2 robots, "
            r"by terminal$",
            running.err(),
            re.MULTILINE,
        )
        assert "ROSIC was shut down" in running.out()
        assert "Traceback" not in running.err()
    assert not (tmp_path / "rosic-data/control.sock").exists()


def test_it_names_robots_that_share_a_namespace_as_it_starts(tmp_path: Path) -> None:
    with gateway(write_neighbours(tmp_path)) as running:
        assert "warning rosic.gateway: ant and bee have one namespace, /hill: " in running.err()


def test_commands_reach_it(tmp_path: Path) -> None:
    config = write_config(tmp_path)
    with gateway(config) as running:
        socket = tmp_path / "rosic-data/control.sock"
        assert stat.S_IMODE(socket.stat().st_mode) == 0o600

        status = rosic("status", "-c", config)
        assert status.status == 0
        assert status.out.startswith("omni: at rest · free · battery 100 %")
        assert "KUKA iiwa: at rest" in status.out
        assert rosic("status", "kuka1", "-c", config).out == "KUKA iiwa: at rest · free\n"
        assert rosic("status", "kuka2", "-c", config) == (
            1,
            "",
            "There is no robot called kuka2. There are: omni, kuka1.\n",
        )

        running.say("omni move 5 m speed 0.05 m/s")
        running.wait_for("driving")
        stop = rosic("stop", "omni", "-c", config)
        assert stop.status == 0
        assert re.fullmatch(r"STOP sent to omni\.\nSTOP: omni at rest \(\d\.\d\d s\)\.\n", stop.out)
        running.wait_for("omni: stopped before it ended")
        assert "stopped by" in rosic("status", "omni", "-c", config).out
        assert "at rest" in rosic("status", "kuka1", "-c", config).out

        unknown = rosic("stop", "omin", "-c", config)
        assert "There is no robot called omin." in unknown.out
        assert "STOP sent to omni, KUKA iiwa." in unknown.out
        assert rosic("status", "kuka1", "-c", config).out.startswith("KUKA iiwa: stopped by")
        assert running.end(signal.SIGINT) == 0


def test_a_stop_needs_nothing_but_the_data_folder(tmp_path: Path) -> None:
    config = write_config(tmp_path, MEMORY)
    with gateway(config):
        config.write_text('[[messenger]]\nkind = "nonsense"\n[[robot]]\nprofile = "lost"\n')

        assert rosic("stop", "-c", config).status == 0
        assert rosic("stop", "--data", tmp_path / "rosic-data").status == 0


def test_somebody_revoked_stays_revoked(tmp_path: Path) -> None:
    config = write_config(tmp_path, TWO_ADMINS)
    with gateway(config) as running:
        people = rosic("people", "-c", config).out
        assert re.search(
            rf"^Ada: as admin · terminal:{os.getuid()} · p[0-9a-f]{{16}}$", people, re.MULTILINE
        )
        running.say("omni arm home")
        running.wait_for("omni: done")

        assert rosic("revoke", "ada", "-c", config).out == (
            "Ada has no access any more, also after a restart.\n"
        )
        running.say("omni arm home")
        running.wait_for("Your access here has ended.")
        assert "access ended" in rosic("people", "-c", config).out
        assert rosic("revoke", "ada", "-c", config).out == (
            "Ada has no access already. Nothing was changed.\n"
        )
        assert rosic("revoke", "Zed", "-c", config) == (
            1,
            "",
            "rosic: Nobody is called Zed. There are: Ada, Bob.\n",
        )
        running.end()
    with gateway(config) as again:
        again.say("omni arm home")
        again.wait_for("Your access here has ended.")


def test_somebody_of_the_file_who_is_revoked_before_the_next_start_never_gets_in(
    tmp_path: Path,
) -> None:
    before_ada, ada, after_ada = TWO_ADMINS.partition('[[principal]]\nname = "Ada"')
    assert ada
    with gateway(write_config(tmp_path, before_ada)) as running:
        assert running.end() == 0
    config = write_config(tmp_path, before_ada + ada + after_ada)
    assert "Ada: not taken over yet" in rosic("people", "-c", config).out

    assert rosic("revoke", "Ada", "-c", config).status == 0

    assert "Ada: access ended" in rosic("people", "-c", config).out
    with gateway(config) as running:
        running.say("omni arm home")
        running.wait_for("Your access here has ended.")


def test_without_a_gateway_commands_say_so(tmp_path: Path) -> None:
    config = write_config(tmp_path, MEMORY)

    for command in ("status", "stop"):
        assert rosic(command, "-c", config) == (
            1,
            "",
            f"rosic: No gateway is running on {tmp_path}/rosic-data.\n",
        )


# ---- what keeps it from starting ----


def test_a_second_gateway_on_the_same_data_gives_way(tmp_path: Path) -> None:
    config = write_config(tmp_path, MEMORY)
    with gateway(config) as first:
        second = rosic("run", "-c", config)

        assert second.status == 1
        assert "already running on this data" in one_sentence(second.err)
        assert rosic("status", "-c", config).status == 0
        assert first.end() == 0
    with gateway(config) as next_one:
        assert next_one.end() == 0


def test_what_a_gateway_that_was_killed_leaves_behind_is_in_nobodys_way(tmp_path: Path) -> None:
    config = write_config(tmp_path, MEMORY)
    with gateway(config) as running:
        running.process.kill()
    assert (tmp_path / "rosic-data/control.sock").exists()
    assert rosic("status", "-c", config).status == 1

    with gateway(config):
        assert rosic("status", "-c", config).status == 0


def unwritable(folder: Path) -> str:
    """Return a folder in which this user may make nothing; nobody may in /sys."""
    if os.geteuid() == 0:
        return "/sys/rosic-data"
    locked = folder / "locked"
    locked.mkdir(mode=0o500)
    return str(locked / "data")


@pytest.mark.parametrize(
    ("text", "status", "sentence"),
    [
        ("[gateway", 2, "This is not TOML"),
        ('[gateway]\nnmae = "lab"', 2, "nmae"),
        ('[gateway]\ndata = "{unwritable}"\n' + MEMORY, 1, "cannot be written"),
        ('[gateway]\ndata = "{long}"\n' + MEMORY, 1, "path of the data folder is too long"),
        (MEMORY.replace('"terminal"', '"terminall"'), 1, "Did you mean terminal?"),
        (MEMORY.replace('"omni"', '"broken.yaml"'), 2, "broken.yaml:2"),
        (MEMORY.replace('"memory"', '"nothing"'), 1, "no robot link of the kind 'nothing'"),
        (MEMORY.replace('"admin"', '"amdin"'), 2, "No role is called 'amdin'."),
        (TELEGRAM, 2, "LAB_TOKEN is not set"),
    ],
)
def test_bad_input_is_one_sentence(tmp_path: Path, text: str, status: int, sentence: str) -> None:
    (tmp_path / "broken.yaml").write_text("id: omni\n  link: [\n")
    changes = {
        "unwritable": unwritable(tmp_path),
        "long": "d" * 120,
        "api_base": "http://127.0.0.1:1",
        "ada": "1001",
    }
    ran = rosic("run", "-c", write_config(tmp_path, text, **changes))

    assert ran.status == status
    assert sentence in one_sentence(ran.err)
    assert ran.out == ""


def test_a_username_ends_the_start(tmp_path: Path) -> None:
    config = write_config(tmp_path, OF_ADA, api_base="http://127.0.0.1:1", ada="ada")

    ran = rosic("run", "-c", config, env=WRONG_TOKEN)

    assert ran.status == 1
    assert "telegram:ada of Ada is no account's id." in one_sentence(ran.err)


def test_a_missing_file_is_one_sentence(tmp_path: Path) -> None:
    for command in ("run", "status"):
        ran = rosic(command, cwd=tmp_path)
        assert ran.status == 2
        assert "rosic.toml" in one_sentence(ran.err)
    assert "rosic.toml" in rosic("check", cwd=tmp_path).err


async def test_a_wrong_token_is_one_sentence_and_never_shown(tmp_path: Path) -> None:
    async with FakeTelegram() as server:
        config = write_config(tmp_path, OF_ADA, api_base=server.api_base, ada="1001")
        ran = await asyncio.to_thread(rosic, "run", "-c", config, env=WRONG_TOKEN)
        doctor = await asyncio.to_thread(rosic, "doctor", "-c", config, env=WRONG_TOKEN)

    assert ran.status == 1
    assert one_sentence(ran.err).startswith(
        "Telegram does not accept the token of the messenger telegram. "
    )
    assert re.search(r"telegram.*does not accept the token of the messenger telegram", doctor.out)
    assert "wrong-wrong" not in ran.err + doctor.out + doctor.err


@pytest.mark.limit(300)
async def test_it_starts_before_its_network_and_works_when_that_comes(tmp_path: Path) -> None:
    server = FakeTelegram(limits=None)
    await server.start()
    await server.stop()  # from here on its port is known, and nobody is there
    ada = server.create_user("Ada")
    config = write_config(tmp_path, OF_ADA, api_base=server.api_base, ada=str(ada))
    with gateway(config, env={"LAB_TOKEN": server.token}, ready=False) as running:
        await asyncio.to_thread(running.wait_for, "ready in", log=True)
        assert "telegram does not answer; I go on trying" in running.err()
        status = await asyncio.to_thread(rosic, "status", "-c", config)
        assert status.status == 0

        async with server:
            await asyncio.to_thread(running.wait_for, "telegram: listening", log=True)
            server.say(ada, ada, "omni arm home")
            async with asyncio.timeout(60 * pace()):
                while not any("done " in m["text"] for m in server.messages(ada, by_bot=True)):
                    await server.wait(server.seq, 1.0)
            assert await asyncio.to_thread(running.end) == 0


# ---- in the air ----


@pytest.mark.parametrize("beside", ["", "cf1 goto x=1 y=2 z=1"])
def test_what_hovers_lands_before_it_ends(tmp_path: Path, beside: str) -> None:
    names = ("cf1", "cf2", "cf3")
    robots = "".join(f'[[robot]]\nprofile = "{n}"\nlink = "simulated"\n' for n in names)
    config = write_config(tmp_path, PEOPLE + robots)
    with gateway(config) as running:
        running.say("crazyflies takeoff 1 m")
        for number in (1, 2, 3):
            running.wait_for(f"Crazyflie {number}: done")
        if beside:
            running.say(beside)
            running.wait_for("flying")
        begun_s = time.monotonic()
        assert running.end() == 0
        took_s = time.monotonic() - begun_s

        assert 2.0 < took_s < 5 * patience(), "from 1 m it takes 2.5 s to land"
        assert "error" not in running.err()


@pytest.mark.limit(300)
def test_what_cannot_land_in_time_is_named_and_stays_stopped(tmp_path: Path) -> None:
    robots = "".join(
        f'[[robot]]\nprofile = "{name}"\nlink = "simulated"\n' for name in ("cf1", "cf2", "omni")
    )
    config = write_config(tmp_path, PEOPLE + robots)
    with gateway(config) as running:
        running.say("crazyflies takeoff 2 m")
        for number in (1, 2):
            running.wait_for(f"Crazyflie {number}: done")
        running.say("cf1 goto x=1 y=2 z=2")
        running.wait_for("flying")
        begun_s = time.monotonic()
        assert running.end() == 0

        assert time.monotonic() - begun_s < 5 * patience()
        assert running.err().splitlines()[-1].partition("rosic.gateway: ")[2] == (
            "Crazyflie 1 and Crazyflie 2 are still coming to rest, as they were told, and stay "
            "stopped until somebody resumes them."
        )
    with gateway(config) as again:
        for name, shown in (("cf1", "Crazyflie 1"), ("cf2", "Crazyflie 2")):
            again.say(f"{name} takeoff 1 m")
            again.wait_for(f"{shown} is stopped")
        again.say("resume cf2")
        again.wait_for("Crazyflie 2 is ready again.")
        assert "omni: " in rosic("status", "omni", "-c", config).out
        assert "stopped" not in rosic("status", "omni", "-c", config).out


def test_a_port_that_is_taken_ends_the_start_before_it_is_called_ready(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        where = f"127.0.0.1:{taken.getsockname()[1]}"
        config = write_config(tmp_path, CONFIG + f'\n[api]\nlisten = "{where}"\n')
        ran = rosic("run", "-c", config)
    assert ran.status == 1
    said = f"{where} of this machine cannot be listened on (Address already in use)."
    assert said in one_sentence(ran.err)
    assert " ready in" not in ran.err
