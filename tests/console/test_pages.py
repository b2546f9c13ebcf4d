"""The files of the page: small, kept by browsers while they are true, fetched from nowhere else."""

from __future__ import annotations

import json
import re
import tomllib
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from rosic.config.plugins import catalogue
from rosic.console.pages import page_files
from rosic.console.texts import TEXTS
from tests.api.served import served

if TYPE_CHECKING:
    from collections.abc import Iterator

HERE = Path(__file__).parent
STATIC = HERE.parents[1] / "src" / "rosic" / "console" / "static"
SCRIPTS = sorted(STATIC.glob("*.js"))
FIRST_PAGE_BYTES = 250_000
SAYS = re.compile(r'\bt\(\s*"((?:[^"\\]|\\.)*)"')
SAYS_SOMETHING = re.compile(r"\bt\(\s*(?!\")[^)\s]")


def sentences(script: str) -> list[str]:
    return [json.loads(f'"{found}"') for found in SAYS.findall(script)]


def vendored() -> Iterator[tuple[str, str]]:
    for package in tomllib.loads((HERE / "vendored.toml").read_text()).values():
        yield from package["files"].items()


def test_what_is_vendored_is_what_npm_has() -> None:
    folder = STATIC / "vendor"
    known = dict(vendored())
    assert {path.name for path in folder.iterdir()} == set(known)
    for name, digest in known.items():
        assert sha256((folder / name).read_bytes()).hexdigest() == digest, name


def test_every_sentence_of_the_page_can_be_translated() -> None:
    said = [text for script in SCRIPTS for text in sentences(script.read_text())]
    assert sorted(set(said)) == sorted({str(text) for text in TEXTS})
    assert len(said) > 100


def test_no_sentence_is_said_that_is_not_written_out() -> None:
    # The definition of it, and nothing else, is followed by a name.
    for script in SCRIPTS:
        found = SAYS_SOMETHING.findall(script.read_text())
        assert len(found) == (1 if script.name == "texts.js" else 0), script.name


def test_a_sentence_that_is_missing_is_found() -> None:
    assert sentences('t("One {x}", { x }) + t(\n  "Two",\n)') == ["One {x}", "Two"]
    assert SAYS_SOMETHING.findall("t(why)") == ["t(w"]


def test_nothing_is_put_in_as_html_or_run_from_text() -> None:
    for script in SCRIPTS:
        for wrong in ("innerHTML", "outerHTML", "insertAdjacentHTML", "eval(", "document.write"):
            assert wrong not in script.read_text(), script.name


def test_nothing_is_fetched_from_elsewhere() -> None:
    namespaces = {"http://www.w3.org/2000/svg"}
    for path in [*SCRIPTS, *STATIC.glob("*.css"), STATIC / "index.html", STATIC / "icon.svg"]:
        assert set(re.findall(r"https?://[^\"'\s)]+", path.read_text())) <= namespaces, path.name


def test_all_of_the_page_is_small() -> None:
    german = catalogue("de")
    assert german is not None
    assert sum(len(each.packed) for each in page_files({"de": german}).values()) < FIRST_PAGE_BYTES


async def test_the_page_is_served_and_its_policy_is_strict() -> None:
    async with served() as place:
        page = await place.http.get("/")
        assert page.status_code == 200
        assert page.headers["content-type"] == "text/html; charset=utf-8"
        assert page.headers["cache-control"] == "no-cache"
        policy = page.headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert not re.search(r"<script(?![^>]*\bsrc=)|<style|\son\w+=|\sstyle=", page.text)


async def test_what_never_changes_is_kept_for_ever_and_the_rest_is_asked_for() -> None:
    async with served() as place:
        page = (await place.http.get("/")).text
        scripts = re.findall(r'"(/console/[0-9a-f]{16}/[^"]+)"', page)
        assert len(scripts) >= 5
        for address in scripts:
            found = await place.http.get(address)
            assert found.status_code == 200, address
            assert found.headers["cache-control"] == "public, max-age=31536000, immutable"
            assert found.headers["content-encoding"] == "gzip"
            known = {"If-None-Match": found.headers["etag"]}
            again = await place.http.get(address, headers=known)
            assert (again.status_code, again.content) == (304, b"")
            plain = await place.http.get(address, headers={"Accept-Encoding": "identity"})
            assert plain.content == found.content
            head = await place.http.head(address)
            assert (head.status_code, head.content) == (200, b"")


async def test_everything_the_scripts_import_is_there() -> None:
    files = page_files({})
    for path, file in files.items():
        for name in re.findall(rb'from\s?"([^"]+)"', file.body) if path.endswith("js") else ():
            assert name.startswith(b"./"), (path, name)
            there = f"{path.rpartition('/')[0]}/{name.decode()[2:]}"
            assert there in files, (path, name)


async def test_its_words_are_those_of_the_catalogue() -> None:
    async with served() as place:
        found = await place.http.get("/console/texts/de.json")
        assert found.headers["cache-control"] == "no-cache"
        words = found.json()
        assert set(words) == {str(text) for text in TEXTS}
        assert words["Sign in"] == "Anmelden"
        assert words["At rest"] == "In Ruhe"


@pytest.mark.parametrize("path", ["/console/", "/console/x/page.js", "/../pyproject.toml", "/x"])
async def test_there_is_nothing_else(path: str) -> None:
    async with served() as place:
        assert (await place.http.get(path)).status_code == 404


async def test_the_page_takes_nothing() -> None:
    async with served() as place:
        assert (await place.http.post("/", json={})).status_code in {404, 405}
