"""Rules about the shape of the source: functions over texts, so that each can be seen to fail."""

from __future__ import annotations

import ast
import builtins
import posixpath
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

MAX_LINES = 500

# Folders of tests that are about no package: contracts, processes, people, the tests themselves.
TESTS_OF_THE_WHOLE = frozenset(
    {"conformance", "journeys", "mutants", "planted", "real", "shape", "shifted"}
)

VAGUE_NAMES = frozenset({"utils", "util", "helpers", "helper", "common", "manager", "base", "misc"})

# The one sentence in which ROSIC says what its stop is not, and the pages that may say it.
_DISCLAIMER = re.compile(r"It is not an emergency stop\s+\(IEC 60204-1, ISO 13850\)")
_DISCLAIMING_PAGES = frozenset({"SECURITY.md", "README.md"})
_SAFETY_FUNCTION = re.compile(r"emergency[\s_-]*stop|\be-stop\b|\bestop\b", re.IGNORECASE)

# A character class in each pattern keeps this file from finding itself.
_TRACES = re.compile(
    r"(?<![\w.])/(?:wor[k]|roo[t]|home/[a-z][\w-]*|Users/[a-z][\w-]*|opt/pyp[i][\w-]*)/"
    r"|/tm[p]/bash_jobs|\.pyen[v]\b"
    r"|https?://[^\s\"']+/(?:simpl[e]|package[s])/|(?:files\.pythonhosted|(?<!\.)pyp[i])\.org\b"
    r"|registry\.npmj[s]\.org|--(?:extra-)?inde[x]-url|--find-link[s]"
)

_AMERICAN = re.compile(
    r"(?<![a-z])(?:"
    r"(?:un)?authoriz\w*|organiz\w*|recogniz\w*|initializ\w*|normaliz\w*|synchroniz\w*|finaliz\w*"
    r"|minimiz\w*|maximiz\w*|optimiz\w*|summariz\w*|utiliz\w*|customiz\w*|prioritiz\w*|sanitiz\w*"
    r"|behavior\w*|colors?|colored|favorit\w*|favors?|honor\w*|neighbor\w*|labor|gray"
    r"|center(?:s|ed|ing)?|canceled|canceling|labeled|labeling|modeled|modeling|signaled|signaling"
    r"|traveled|traveling|analyz\w*|catalogs?|dialogs?|defense|fulfill?ment|artifacts?"
    r")(?![a-z])",
    re.IGNORECASE,
)
# What only the adapter of a ROS 2 graph may speak of: its name, its types, its client, its ways to
# reach something and the keys under which a profile names them.
_ROS = re.compile(
    r"(?<![a-z])ros[ _-]?2?(?![a-z0-9])|rclpy|rosidl|rosout|rosgraph"
    r"|(?<![a-z])[a-z_]+_(?:msgs|srvs)(?![a-z])|(?<![a-z])qos(?![a-z])|(?:service|action|parameters|stop)binding"
    r"|action[ _]goal"
    r"|set_parameters|stream_hz|zero_type|cancel_only|stop_only|(?<![a-z])twist(?![a-z])"
    r"|skill\.(?:topic|service|action)\b|jointstate|odometry|to_robot_topic",
    re.IGNORECASE,
)
# The path of a link, without its anchor; links that leave the repository carry a scheme.
_LINK = re.compile(r"\]\((?![a-z]+:|#)([^)#\s]+)")
# Names that others chose (an API, a header, a wire format) are taken out before the text is read.
FOREIGN_NAMES = (
    re.compile(r"\bunicodedata\.normalize\b"),
    re.compile(r"\bNO_COLOR\b|--no-color\b|\bcolor_depth\b|\bColorDepth\b|\bpygments\.\w+"),
    re.compile(
        r"\bSTATUS_CANCELED\b|\bnum_goals_canceled\b|\bgoals_canceled\b|\bgoals_canceling\b"
        r"|\bhandle\.canceled\(\)"
    ),
    re.compile(r"[\"']Authorization[\"']|\bAuthorization:|[\"']Unauthorized[\"']|</?center>"),
    re.compile(r"\bauthorization[\"']|\bHTTPStatus\.UNAUTHORIZED\b"),  # of HTTP
    re.compile(r"\bcolor-scheme\b|\bprefers-color-scheme\b"),  # of browsers
    re.compile(r"\binitializer="),
    re.compile(r"\.initialize\(\)|[\"']initialize[\"']"),  # of MCP
    re.compile(r"\bdef initialize\(self\)"),  # of python-telegram-bot's connections
    re.compile(r"\bcreate_initialization_options\b"),  # of its library
    re.compile(r"\bbehavior_tree\b"),  # of Nav2's goals
    re.compile(r"\boptimize="),  # Pillow's
    re.compile(r"\b(?:color|ecolor)=|\"grid\.color\"|\"ecolor\""),  # matplotlib's
    re.compile(r"\bscipy\.optimize\b"),
    re.compile(r"\binitialize(?:Operator|Robot)\b"),  # the paper's functions
    re.compile(r"\bpor favor\b"),  # "please", in Spanish and Portuguese
    re.compile(r"\b\w*(?:accent|icon|fill|name)_color\w*"),  # Telegram's fields
)


def too_long(texts: Mapping[str, str], limit: int = MAX_LINES) -> list[str]:
    """Modules that have outgrown one reason to change."""
    lines = {path: len(text.splitlines()) for path, text in texts.items()}
    return [f"{path}: {count} lines" for path, count in lines.items() if count > limit]


def vaguely_named(paths: Iterable[str]) -> list[str]:
    """Modules and packages whose name says nothing about what belongs in them."""
    return [
        path
        for path in paths
        if any(part.removesuffix(".py").strip("_") in VAGUE_NAMES for part in path.split("/"))
    ]


def without_source(tests: Iterable[str], sources: Iterable[str]) -> list[str]:
    """Folders of tests that lie beside no folder of the source; tests of the whole are left out."""
    ours = {posixpath.dirname(path) for path in sources}
    ours |= {posixpath.dirname(folder) for folder in ours}
    theirs = {posixpath.dirname(path).removeprefix("tests/") for path in tests} - {"tests"}
    return sorted(
        f"tests/{folder}"
        for folder in theirs
        if folder.partition("/")[0] not in TESTS_OF_THE_WHOLE
        and not {f"src/rosic/{folder}", f"src/{folder}"} & ours
    )


def claims_of_safety(texts: Mapping[str, str]) -> list[str]:
    """Places that call ROSIC's stop what it is not; the disclaimer on its own pages is left out."""
    said = {
        path: _DISCLAIMER.sub("", text) if path in _DISCLAIMING_PAGES else text
        for path, text in texts.items()
    }
    return [found for path, text in said.items() for found in _found(path, text, _SAFETY_FUNCTION)]


def traces_of_a_machine(texts: Mapping[str, str]) -> list[str]:
    """Paths of one machine, and addresses that packages were fetched from."""
    return [found for path, text in texts.items() for found in _found(path, text, _TRACES)]


def american_spellings(texts: Mapping[str, str]) -> list[str]:
    """Words that ROSIC spells in the British way; names that others chose are let through."""
    return [
        found
        for path, text in texts.items()
        for found in _found(path, _without_foreign_names(text), _AMERICAN)
    ]


def words_of_ros(texts: Mapping[str, str]) -> list[str]:
    """Places that speak of ROS; its adapter, and whoever sets one up, are not among the texts."""
    return [found for path, text in texts.items() for found in _found(path, text, _ROS)]


def without_docstring(texts: Mapping[str, str]) -> list[str]:
    """Packages that do not say what they are for."""
    return [
        path
        for path, text in texts.items()
        if path.endswith("/__init__.py") and not ast.get_docstring(ast.parse(text))
    ]


def broken_links(texts: Mapping[str, str], paths: Iterable[str]) -> list[str]:
    """Relative links of Markdown pages that lead to no file and no folder."""
    known = {
        "/".join(path.split("/")[:depth]) for path in paths for depth in range(path.count("/") + 2)
    }
    return [
        f"{page}: {target}"
        for page, text in texts.items()
        for target in _LINK.findall(text)
        if posixpath.normpath(posixpath.join(posixpath.dirname(page), target)) not in known | {"."}
    ]


def imported_packages(texts: Iterable[str]) -> set[str]:
    """Top-level names of everything that the sources import, wherever the import stands."""
    names: set[str] = set()
    for node in (node for text in texts for node in ast.walk(ast.parse(text))):
        if isinstance(node, ast.Import):
            names.update(alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module.partition(".")[0])
    return names


def pins(requirements: str) -> dict[str, str]:
    """Name to version of every pinned line."""
    return dict(re.findall(r"^([a-z0-9.-]+)(?:\[[\w,]+\])?==([\w.]+)", requirements, re.MULTILINE))


def without_hash(requirements: str) -> list[str]:
    """Requirements that anybody could replace: not pinned, or without a hash."""
    logical = requirements.replace("\\\n", " ").splitlines()
    wanted = [line for line in logical if line.strip() and not line.lstrip().startswith("#")]
    return [line for line in wanted if "==" not in line or "--hash=sha256:" not in line]


def _found(path: str, text: str, pattern: re.Pattern[str]) -> list[str]:
    return [
        f"{path}:{text.count(chr(10), 0, match.start()) + 1}: {match.group()}"
        for match in pattern.finditer(text)
    ]


def _without_foreign_names(text: str) -> str:
    for pattern in FOREIGN_NAMES:
        text = pattern.sub("", text)
    return text


# ---- what belongs to one adapter alone ----

_OF_TELEGRAM = re.compile(
    r"telegram|\bt\.me\b|botfather|setprivacy|@\w*bot\b|(?-i:[a-z]_bot\b)|\bbot_?names?\b",
    re.IGNORECASE,
)


def of_telegram(texts: Mapping[str, str], shown: Mapping[str, tuple[str, ...]]) -> list[str]:
    """Lines that know of Telegram.

    Args:
        texts: Of modules outside its adapter.
        shown: By module, what people read or write there and what has to stay.
    """
    found = []
    for path, text in texts.items():
        for number, line in enumerate(text.splitlines(), 1):
            rest = line
            for words in shown.get(path, ()):
                rest = rest.replace(words, "")
            if _OF_TELEGRAM.search(rest):
                found.append(f"{path}:{number}: {line.strip()}")
    return found


def abilities_asked_by_name(texts: Mapping[str, str], foreign: frozenset[str]) -> list[str]:
    """Places that ask an object by name for what it may have: a Protocol says it in the open.

    Args:
        texts: Of modules.
        foreign: Attributes of objects that are not ours, whose libraries offer no other way.
    """
    found = []
    for path, text in texts.items():
        for node in ast.walk(ast.parse(text)):
            if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Name):
                continue
            asks = node.func.id == "hasattr" or (node.func.id == "getattr" and len(node.args) > 2)
            name = node.args[1].value if asks and isinstance(node.args[1], ast.Constant) else ""
            if asks and name not in foreign:
                found.append(f"{path}:{node.lineno}: {ast.unparse(node)}")
    return found


def protocols_in(texts: Mapping[str, str], allowed: frozenset[str] = frozenset()) -> list[str]:
    """Protocols that are asked for by ``isinstance`` outside the contracts."""
    found = []
    for path, text in texts.items():
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.ClassDef) and node.name not in allowed:
                marks = [ast.unparse(mark) for mark in node.decorator_list]
                if "runtime_checkable" in marks:
                    found.append(f"{path}: {node.name}")
    return found


# ---- one name for one thing ----

_TRANSLATOR = re.compile(r"^from rosic\.core\.i18n import .*\bsaid\b", re.MULTILINE)


def hidden_translators(texts: Mapping[str, str]) -> list[str]:
    """Places that give the name of what makes a sentence translatable to something else.

    A field of a record hides nothing: it is read of an object.
    """
    found = []
    for path, text in texts.items():
        if not _TRANSLATOR.search(text):
            continue
        nodes = list(ast.walk(ast.parse(text)))
        fields = {node.target for node in nodes if isinstance(node, ast.AnnAssign)}
        found += [
            f"{path}:{node.lineno}"
            for node in nodes
            if (isinstance(node, ast.arg) and node.arg == "said")
            or (
                isinstance(node, ast.Name) and node.id == "said" and isinstance(node.ctx, ast.Store)
            )
            if node not in fields
        ]
    return found


# ---- what docstrings say is raised ----

_RAISES = re.compile(r"^Raises:\n((?:(?: {4}.*)?(?:\n|$))+)", re.MULTILINE)
_RAISED = re.compile(r"^ {4}(?! )([^:\n]+)", re.MULTILINE)
_OF_PYTHON = frozenset(
    name
    for name, found in vars(builtins).items()
    if isinstance(found, type) and issubclass(found, BaseException)
)


def unknown_exceptions(texts: Mapping[str, str]) -> list[str]:
    """Names under ``Raises:`` that no exception has: of Python, of these texts, or imported."""
    trees = {path: ast.parse(text) for path, text in texts.items()}
    ours = _exceptions_of(trees.values())
    return [
        f"{path}:{node.lineno}: {name}"
        for path, tree in trees.items()
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
        for section in _RAISES.findall(ast.get_docstring(node) or "")
        for names in _RAISED.findall(section)
        for name in names.split(", ")
        if name not in ours and name.partition(".")[0] not in _foreign_names(tree)
    ]


def _exceptions_of(trees: Iterable[ast.Module]) -> set[str]:
    """Return the names of exceptions: a base of theirs is one, or is called as libraries' are."""
    bases = {
        (node.name, ast.unparse(base).rpartition(".")[2])
        for tree in trees
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
        for base in node.bases
    }
    found, before = set(_OF_PYTHON), 0
    while len(found) > before:
        before = len(found)
        found |= {name for name, base in bases if base in found or base.endswith("Error")}
    return found


def _foreign_names(tree: ast.Module) -> set[str]:
    """Return what a module has of others: the names that it imports, and of what packages."""
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names.update(alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not (node.module or "").startswith("rosic"):
            names.update(alias.asname or alias.name for alias in node.names)
            names.add((node.module or "").partition(".")[0])
    return names
