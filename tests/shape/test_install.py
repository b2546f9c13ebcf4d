"""Whoever waits while make installs reads what for, and how far it is."""

from __future__ import annotations

import io
import subprocess
import sys

import pytest

from tests import install

PIP_SAYS = """\
Ignoring colorama: markers 'sys_platform == "win32"' don't match your environment
Collecting aiohttp==3.12.0 (from -r core.txt (line 1))
  Downloading aiohttp-3.12.0.whl (1.7 MB)
Requirement already satisfied: msgspec==0.19.0 in ./lib
Processing ./wheels/six-1.17.0-py2.py3-none-any.whl (from -r core.txt (line 9))
Installing collected packages: aiohttp
""".splitlines(keepends=True)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_in_a_terminal_one_line_counts_what_is_fetched_and_nothing_of_it_stays() -> None:
    out = Terminal()
    progress = install.Progress(4, out)
    progress.follow(PIP_SAYS)
    progress.show("")
    shown = [text.strip() for text in out.getvalue().split("\r")]
    assert [text for text in shown if text] == [
        "1 of 3 packages fetched",
        "2 of 3 packages fetched",
        "3 of 3 packages fetched",
        "putting 3 packages in place",
    ]
    assert "\n" not in out.getvalue()
    assert out.getvalue().endswith("\r")


def test_a_warning_stands_on_a_line_of_its_own(capsys: pytest.CaptureFixture[str]) -> None:
    out = Terminal()
    progress = install.Progress(2, out)
    progress.show("1 of 2 packages fetched")
    progress.warn(["WARNING: retrying\n"])
    assert out.getvalue().endswith("\r")
    assert capsys.readouterr().err == "WARNING: retrying\n"


def test_in_a_log_nothing_is_counted() -> None:
    out = io.StringIO()
    progress = install.Progress(3, out)
    progress.follow(PIP_SAYS)
    progress.show("")
    assert out.getvalue() == ""


def test_what_pip_cannot_do_is_said_and_is_a_failure(capfd: pytest.CaptureFixture[str]) -> None:
    status = install.pip(install.Progress(1, io.StringIO()), "--no-index", "no-such-package==0")
    assert status != 0
    assert "no-such-package" in capfd.readouterr().err


@pytest.mark.parametrize("size", install.LASTS)
def test_every_size_says_first_how_many_packages_it_brings(
    size: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    done = [sys.executable, "-c", "raise SystemExit(0)"]
    monkeypatch.setattr(install, "PIP", (*done, "--"))
    out = io.StringIO()
    assert install.install(size, out) == 0
    first, rest = out.getvalue().split("\n")
    listed = subprocess.run(  # noqa: S603 - counted by somebody else
        ["/bin/grep", "-c", "==.*\\\\$", str(install.REQUIREMENTS / f"{size}.txt")],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.strip()
    assert first.startswith(f"Installing {listed} packages of requirements/{size}.txt into ")
    assert rest == ""
