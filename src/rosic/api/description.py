"""The description of the API as OpenAPI has it: every route with every way in which it refuses."""

from __future__ import annotations

from copy import deepcopy
from http import HTTPStatus
from typing import TYPE_CHECKING, Any, Final

import msgspec
from litestar.openapi.plugins import JsonRenderPlugin

from rosic.api.problems import PROBLEM
from rosic.api.schemas import Problem

if TYPE_CHECKING:
    from collections.abc import Iterable

    from litestar import Request

REFUSED: Final = (
    HTTPStatus.BAD_REQUEST,
    HTTPStatus.UNAUTHORIZED,
    HTTPStatus.FORBIDDEN,
    HTTPStatus.NOT_FOUND,
    HTTPStatus.METHOD_NOT_ALLOWED,
    HTTPStatus.REQUEST_TIMEOUT,
    HTTPStatus.CONFLICT,
    HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
    HTTPStatus.MISDIRECTED_REQUEST,
    HTTPStatus.UNPROCESSABLE_ENTITY,
    HTTPStatus.TOO_MANY_REQUESTS,
    HTTPStatus.INTERNAL_SERVER_ERROR,
    HTTPStatus.SERVICE_UNAVAILABLE,
)
NAME: Final = "Problem"
KEY: Final = "key"
METHODS: Final = frozenset({"get", "put", "post", "delete", "patch"})


class DescribedProblems(JsonRenderPlugin):
    """Renders the description, once, with what every route may answer besides."""

    def __init__(self, path: str) -> None:
        super().__init__(path=path)
        self._rendered = b""

    def prepare(self, schema: dict[str, Any]) -> None:
        """Render the description before anybody asks for it; it may be done on a thread."""
        self._rendered = msgspec.json.encode(described(schema))

    def render(self, request: Request[Any, Any, Any], openapi_schema: dict[str, Any]) -> bytes:
        """Return the description."""
        if not self._rendered:
            self._rendered = self.render_json(request, described(openapi_schema))
        return self._rendered


def described(schema: dict[str, Any]) -> dict[str, Any]:
    """Return a description in which every operation says how it refuses, and what it asks for."""
    whole = deepcopy(schema)
    _, components = msgspec.json.schema_components(
        (Problem,), ref_template="#/components/schemas/{name}"
    )
    parts = whole.setdefault("components", {})
    parts.setdefault("schemas", {}).update(components)
    parts["securitySchemes"] = {KEY: {"type": "http", "scheme": "bearer"}}
    whole["security"] = [{KEY: []}]
    for operation in _operations(whole):
        responses = operation.setdefault("responses", {})
        responses.get("204", {}).pop("content", None)
        for status in REFUSED:
            responses[str(int(status))] = _refusal(status)
    return whole


def _operations(schema: dict[str, Any]) -> Iterable[dict[str, Any]]:
    for path in schema.get("paths", {}).values():
        for method, operation in path.items():
            if method in METHODS:
                yield operation


def _refusal(status: HTTPStatus) -> dict[str, Any]:
    schema = {"$ref": f"#/components/schemas/{NAME}"}
    return {"description": status.phrase, "content": {PROBLEM: {"schema": schema}}}
