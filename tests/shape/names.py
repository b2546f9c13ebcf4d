"""The words of public class names: the field's, plain English, or explained in the glossary."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

GLOSSARY = Path(__file__).parents[2] / "docs" / "glossary.md"
RENAMED = GLOSSARY.parent / "decisions" / "0013-the-fields-own-names.md"
FIELD_WORDS = Path(__file__).with_name("field_words.txt")

_WORD = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+")
_TERM = re.compile(r"^\| ([^|]+) \|", re.MULTILINE)
_RENAMED = re.compile(r"^\| (`.+`) \|$", re.MULTILINE)
# Endings that make another form of the same word: robots, registry's entries, rendering, renderer.
_ENDINGS = ("s", "es", "d", "ed", "ing", "r", "er", "or", "ion")
_SHORTEST_STEM = 3


def words_of(name: str) -> list[str]:
    """Take a class name apart: ``ROSOutReasons`` is ros, out, reasons."""
    return [word.lower() for word in _WORD.findall(name)]


def terms_of(glossary: str) -> set[str]:
    """Return the words that a glossary explains: the first column of its tables."""
    terms = {word for term in _TERM.findall(glossary) for word in re.findall(r"[a-z]+", term)}
    return terms - {"word"}


def listed_words(text: str) -> set[str]:
    """Return the words of a list; what follows a ``#`` says whose words they are."""
    return {word for line in text.splitlines() for word in line.partition("#")[0].split()}


def base_forms(word: str) -> set[str]:
    """Return what a word may be a form of: ``queries`` of query, ``planning`` of plan."""
    forms = {word}
    for ending in _ENDINGS:
        stem = word.removesuffix(ending)
        if stem != word and len(stem) >= _SHORTEST_STEM:
            forms |= {stem, stem + "e"}
            if stem[-1] == stem[-2]:
                forms.add(stem[:-1])
    if word.endswith(("ies", "ied")):
        forms.add(word[:-3] + "y")
    return forms


def public_classes(texts: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Yield the module and the name of every public class."""
    for module, text in texts.items():
        for node in ast.parse(text).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                yield module, node.name


def unknown_words(texts: Mapping[str, str], known: set[str]) -> list[str]:
    """Return every public class one of whose words is neither listed nor explained."""
    return [
        f"{module}.{name}: {word}"
        for module, name in public_classes(texts)
        for word in words_of(name)
        if not base_forms(word) & known
    ]


def unused_words(texts: Mapping[str, str], listed: set[str]) -> list[str]:
    """Return the listed words that no public class needs any more."""
    used = {
        form
        for _, name in public_classes(texts)
        for word in words_of(name)
        for form in base_forms(word)
    }
    return sorted(listed - used)


def lost_names(page: str, texts: Mapping[str, str]) -> list[str]:
    """Return the rows of old and new names whose new module, or class, is not there.

    Args:
        page: Its rows are old module, new module; or old class, new class, module.
        texts: By dotted name.
    """
    lost = []
    for row in _RENAMED.findall(page):
        _, *classes, path = row.replace("`", "").split(" | ")
        module = path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
        text = texts.get(module, texts.get(f"rosic.{module}"))
        if text is None or not all(
            re.search(rf"^(?:class )?{name}\b", text, re.MULTILINE) for name in classes
        ):
            lost.append(row)
    return lost
