"""Understanding what people write: a total, linear-time grammar, units and bounds.

Pure. In the order of a message: `hears_stop`, `understand`, `bind`, `show`. All of them look things
up in a `Vocabulary`, which is compiled from the profiles once and replaced when they change.
"""

from __future__ import annotations

from rosic.core.language.arguments import bind
from rosic.core.language.ast import (
    Answered,
    Cancel,
    CommandLine,
    Do,
    Halt,
    Help,
    Line,
    LineContext,
    Misunderstood,
    Proposed,
    Resume,
    Robots,
    Start,
    Status,
    Use,
)
from rosic.core.language.cancel_detection import hears_cancel, is_urgent
from rosic.core.language.compiled import SAY, skills_of
from rosic.core.language.formatting import live_words, show
from rosic.core.language.line_parser import MOST_WORDS
from rosic.core.language.line_words import leaves_out
from rosic.core.language.numbers import Unit, UnitTable
from rosic.core.language.parser import LONGEST_TEXT, MOST_LINES, LanguageReader, places, understand
from rosic.core.language.phrase_reader import MOST_PHRASE_WORDS
from rosic.core.language.sanitise import clean, clean_name, inert_text
from rosic.core.language.secrecy import kept_of, without_codes
from rosic.core.language.stop_detection import hears_stop
from rosic.core.language.vocabulary import Vocabulary, VocabularyHolder
from rosic.core.language.wait_detection import hears_wait

__all__ = [
    "LONGEST_TEXT",
    "MOST_LINES",
    "MOST_PHRASE_WORDS",
    "MOST_WORDS",
    "SAY",
    "Answered",
    "Cancel",
    "CommandLine",
    "Do",
    "Halt",
    "Help",
    "LanguageReader",
    "Line",
    "LineContext",
    "Misunderstood",
    "Proposed",
    "Resume",
    "Robots",
    "Start",
    "Status",
    "Unit",
    "UnitTable",
    "Use",
    "Vocabulary",
    "VocabularyHolder",
    "bind",
    "clean",
    "clean_name",
    "hears_cancel",
    "hears_stop",
    "hears_wait",
    "inert_text",
    "is_urgent",
    "kept_of",
    "leaves_out",
    "live_words",
    "places",
    "show",
    "skills_of",
    "understand",
    "without_codes",
]
