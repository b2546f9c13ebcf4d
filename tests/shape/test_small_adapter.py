"""A messenger in a day: the one that was added last stays as small as it is said to be."""

from __future__ import annotations

import ast
import io
import tokenize
from pathlib import Path

FOLDER = Path(__file__).parents[2] / "src" / "rosic" / "messengers" / "xmpp"
AT_MOST = 600
_BLANK = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
}


def lines_of_code(text: str) -> int:
    """Return how many lines are neither blank nor a comment nor a docstring."""
    code = {
        line
        for token in tokenize.generate_tokens(io.StringIO(text).readline)
        if token.type not in _BLANK
        for line in range(token.start[0], token.end[0] + 1)
    }
    said = {
        line
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)
    }
    return len(code - said)


def test_the_adapter_of_xmpp_has_fewer_than_600_lines_of_code() -> None:
    found = {path.name: lines_of_code(path.read_text()) for path in FOLDER.glob("*.py")}
    assert 0 < sum(found.values()) < AT_MOST, found


def test_comments_docstrings_and_blank_lines_are_no_code() -> None:
    assert (
        lines_of_code('"""One.\n\nTwo.\n"""\n\n# three\nfour = 4  # five\n\nsix(\n    7\n)\n') == 4
    )
