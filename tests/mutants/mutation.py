"""Every small change that can be made to one source file, one at a time.

Only what stands in functions is changed, and what their parameters default to: anything else that
stands outside of them has been run before a test begins. Sentences, annotations and what goes to
the log stay as they are.
"""

from __future__ import annotations

import ast
from collections import Counter
from typing import TYPE_CHECKING, TypeAlias

import msgspec

if TYPE_CHECKING:
    from collections.abc import Iterator

Change: TypeAlias = tuple[str, ast.AST]

LONGEST = 110
SWAPPED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
OPPOSITE: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.FloorDiv,
    ast.FloorDiv: ast.Mult,
    ast.Div: ast.Mult,
    ast.BitOr: ast.BitAnd,
    ast.BitAnd: ast.BitOr,
}
RENAMED = {"min": "max", "max": "min", "any": "all", "all": "any"}
LEFT_ALONE = ("annotation", "returns", "args", "decorator_list", "type_comment", "type_params")
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
NOTHING = "lambda *_, **__: None"
REACHED = "__reached__"  # of a marked source: called with the line of each statement


class Mutant(msgspec.Struct, frozen=True):
    """One change.

    Attributes:
        function: In which, as Python qualifies its name.
        operator: What kind of change it is.
        before, after: The source, shortened.
        nth: Of the changes in this function that read the same.
        first, last: Lines of the statement it belongs to, or of its head.
        parameter: Whose default it changes; whoever calls the function reaches it.
    """

    function: str
    operator: str
    before: str
    after: str
    nth: int
    first: int
    last: int
    parameter: str = ""

    @property
    def id(self) -> str:
        """What stays the same when other lines change."""
        again = f" ({self.nth})" if self.nth else ""
        return f"{self.function}: {self.operator}: {self.before} -> {self.after}{again}"


class Site(msgspec.Struct):
    """Where a change goes: a field of a node, or one of its items."""

    owner: ast.AST
    field: str
    index: int | None
    new: ast.AST

    def change(self) -> None:
        """Make the change."""
        if self.index is None:
            setattr(self.owner, self.field, self.new)
        else:
            getattr(self.owner, self.field)[self.index] = self.new


def mutants(text: str) -> dict[str, Mutant]:
    """Return every change that can be made to a source, by id."""
    return {mutant.id: mutant for mutant, _ in _all(ast.parse(text))}


def mutated(text: str, name: str) -> ast.Module:
    """Return a source with one change, every line where it was."""
    tree = ast.parse(text)
    for mutant, site in _all(tree):
        if mutant.id == name:
            site.change()
            return ast.fix_missing_locations(tree)
    raise KeyError(name)


def marked(text: str) -> ast.Module:
    """Return a source that calls ``REACHED`` before each statement of a function."""
    tree = ast.parse(text)
    for function, _ in _functions(tree, ""):
        for node in list(ast.walk(function)):
            for name, value in ast.iter_fields(node):
                if isinstance(value, list) and value and isinstance(value[0], ast.stmt):
                    setattr(node, name, [new for old in value for new in (_mark(old), old)])
    return ast.fix_missing_locations(tree)


def _mark(statement: ast.stmt) -> ast.stmt:
    line = ast.Constant(statement.lineno)
    called = ast.Expr(ast.Call(ast.Name(REACHED, ast.Load()), [line], []))
    return ast.copy_location(called, statement)


def _all(tree: ast.Module) -> Iterator[tuple[Mutant, Site]]:
    seen: Counter[tuple[str, str, str, str]] = Counter()
    for function, name in _functions(tree, ""):
        for operator, old, statement, site in _in_function(function):
            before, after = _short(old), _short(site.new)
            first, last = _lines(statement)
            key = (name, operator, before, after)
            yield Mutant(name, operator, before, after, seen[key], first, last), site
            seen[key] += 1
        for parameter, old, statement, site in _defaults(function):
            before, after = _short(old), _short(site.new)
            first, last = _lines(statement)
            operator = f"default of {parameter}"
            yield Mutant(name, operator, before, after, 0, first, last, parameter), site


def _functions(node: ast.AST, prefix: str) -> Iterator[tuple[ast.stmt, str]]:
    """Go through the outermost functions; what stands in them belongs to them."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, FUNCTIONS):
            yield child, f"{prefix}{child.name}"
        elif isinstance(child, ast.ClassDef):
            yield from _functions(child, f"{prefix}{child.name}.")


def _in_function(function: ast.AST) -> Iterator[tuple[str, ast.AST, ast.stmt, Site]]:
    assert isinstance(function, FUNCTIONS)
    body = function.body[1:] if _is_docstring(function.body[0]) else function.body
    if len(body) > 1 and not _yields(function):
        first = body[0]
        early = ast.copy_location(ast.If(ast.Constant(True), [ast.Return()], [first]), first)
        index = function.body.index(first)
        yield "returns early", first, first, Site(function, "body", index, early)
    for index, statement in enumerate(function.body):
        yield from _below(function, "body", index, statement, statement)


def _defaults(function: ast.AST) -> Iterator[tuple[str, ast.AST, ast.stmt, Site]]:
    """Go through what parameters default to, each with the first statement of the function."""
    assert isinstance(function, FUNCTIONS)
    first = next((each for each in function.body if not _is_docstring(each)), function.body[0])
    given = function.args
    named = [*given.posonlyargs, *given.args][-len(given.defaults) :] if given.defaults else []
    for field, parameters, values in (
        ("defaults", named, given.defaults),
        ("kw_defaults", given.kwonlyargs, given.kw_defaults),
    ):
        for index, (parameter, value) in enumerate(zip(parameters, values, strict=True)):
            other = None if value is None else _instead(value)
            if value is not None and other is not None:
                located = ast.copy_location(other, value)
                yield parameter.arg, value, first, Site(given, field, index, located)


def _instead(default: ast.expr) -> ast.expr | None:
    """Return another default; what is called, by its name, does nothing then."""
    match default:
        case ast.Constant(value=bool(value)):
            return ast.Constant(not value)
        case ast.Constant(value=int(value)) | ast.Constant(value=float(value)):
            return ast.Constant(value + 1)
        case ast.Constant(value=None):
            return ast.Constant(...)
        case ast.Name(id=name) | ast.Attribute(attr=name) if name == name.lower():
            return ast.parse(NOTHING, mode="eval").body
    return None


def _yields(function: ast.AST) -> bool:
    return any(isinstance(node, ast.Yield | ast.YieldFrom) for node in ast.walk(function))


def _below(
    owner: ast.AST, field: str, index: int | None, node: ast.AST, statement: ast.stmt
) -> Iterator[tuple[str, ast.AST, ast.stmt, Site]]:
    """Go through all changes of a node and of what is in it."""
    if isinstance(node, ast.stmt):
        statement = node
    if _is_docstring(node) or _is_for_the_log(node):
        return
    for operator, new in _changes(node):
        located = ast.copy_location(new, node)
        yield operator, node, statement, Site(owner, field, index, located)
    for name, number, child in _children(node):
        if number is None:
            yield from _conditions(node, name, child, statement)
        yield from _below(node, name, number, child, statement)


def _children(node: ast.AST) -> Iterator[tuple[str, int | None, ast.AST]]:
    for name, value in ast.iter_fields(node):
        if name in LEFT_ALONE and not (name == "args" and isinstance(node, ast.Call)):
            continue
        if isinstance(value, list):
            for number, item in enumerate(value):
                if isinstance(item, ast.AST):
                    yield name, number, item
        elif isinstance(value, ast.AST):
            yield name, None, value


def _conditions(
    node: ast.AST, name: str, value: ast.AST, statement: ast.stmt
) -> Iterator[tuple[str, ast.AST, ast.stmt, Site]]:
    """A condition that always holds, and one that never does."""
    if name != "test" or isinstance(value, ast.Constant):
        return
    if not isinstance(node, ast.While):  # it would only run for ever
        yield "always", value, statement, Site(node, name, None, _located(True, value))
    yield "never", value, statement, Site(node, name, None, _located(False, value))


def _located(constant: bool, at: ast.AST) -> ast.AST:
    return ast.copy_location(ast.Constant(constant), at)


def _changes(node: ast.AST) -> Iterator[Change]:
    if isinstance(node, ast.stmt):
        yield from _of_statement(node)
    else:
        yield from _of_condition(node)
        yield from _of_value(node)


def _of_statement(node: ast.stmt) -> Iterator[Change]:
    match node:
        case ast.Expr() | ast.Raise() | ast.Delete() | ast.Assert() | ast.Break() | ast.Continue():
            yield "dropped", ast.Pass()
        case ast.Assign(targets=[ast.Attribute() | ast.Subscript(), *_]):
            yield "dropped", ast.Pass()
        case ast.AugAssign(target=target, op=op, value=value) if type(op) in OPPOSITE:
            yield "opposite", ast.AugAssign(target, OPPOSITE[type(op)](), value)
        case ast.Return(value=value) if value is not None and not _is_none(value):
            yield "returns nothing", ast.Return(ast.Constant(None))


def _of_condition(node: ast.AST) -> Iterator[Change]:
    match node:
        case ast.Compare(left=left, ops=[op], comparators=[right]):
            yield "compared otherwise", ast.Compare(left, [SWAPPED[type(op)]()], [right])
        case ast.BoolOp(op=op, values=values):
            other = ast.Or() if isinstance(op, ast.And) else ast.And()
            yield "and for or", ast.BoolOp(other, values)
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            yield "not dropped", operand
        case ast.comprehension(target=target, iter=over, ifs=[_, *_], is_async=is_async):
            yield "always", ast.comprehension(target, over, [], is_async)


def _of_value(node: ast.AST) -> Iterator[Change]:
    match node:
        case ast.Constant(value=bool(value)):
            yield "opposite", ast.Constant(not value)
        case ast.Constant(value=int(value)) | ast.Constant(value=float(value)):
            yield "one more", ast.Constant(value + 1)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in OPPOSITE:
            yield "opposite", ast.BinOp(left, OPPOSITE[type(op)](), right)
        case ast.Name(id=name, ctx=ctx) if name in RENAMED:
            yield "opposite", ast.Name(RENAMED[name], ctx)


def _is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _is_docstring(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _is_for_the_log(node: ast.AST) -> bool:
    """Whether it is a call such as ``log.warning(...)``."""
    if not isinstance(node, ast.Expr) or not isinstance(node.value, ast.Call):
        return False
    called = node.value.func
    return (
        isinstance(called, ast.Attribute)
        and isinstance(called.value, ast.Name)
        and called.value.id == "log"
    )


def _lines(statement: ast.stmt) -> tuple[int, int]:
    """Return the lines of a statement; of one that holds others, those of its head."""
    last = statement.end_lineno or statement.lineno
    body = getattr(statement, "body", None)
    if isinstance(body, list) and body:
        last = max(statement.lineno, body[0].lineno - 1)
    return statement.lineno, last


def _short(node: ast.AST) -> str:
    if isinstance(node, ast.If) and isinstance(node.test, ast.Constant):
        return "return"
    text = " ".join(ast.unparse(node).split())
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
