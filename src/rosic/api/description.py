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
    HTTPStatus.GATEWAY_TIMEOUT,
)
NAME: Final = "Problem"
KEY: Final = "key"
FILES: Final = "/v1/files"
VIEWS: Final = "/v1/robots/{robot}/views/{kind}"
SAID: Final = "/v1/chat/{message}/file"
PICTURES: Final = ("image/png", "image/jpeg")
BYTES: Final = {"schema": {"type": "string", "format": "binary"}}
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
    whole: dict[str, Any] = _any_of(deepcopy(schema))
    _, components = msgspec.json.schema_components(
        (Problem,), ref_template="#/components/schemas/{name}"
    )
    parts = whole.setdefault("components", {})
    parts.setdefault("schemas", {}).update(components)
    parts["securitySchemes"] = {KEY: {"type": "http", "scheme": "bearer"}}
    whole["security"] = [{KEY: []}]
    _say_bytes(whole["paths"])
    for operation in _operations(whole):
        responses = operation.setdefault("responses", {})
        responses.get("204", {}).pop("content", None)
        for status in REFUSED:
            responses[str(int(status))] = _refusal(status)
    return whole


def _say_bytes(paths: dict[str, Any]) -> None:
    """Say of what sort the bytes are that no structure describes: files, and pictures."""
    sent, shown = paths.get(FILES, {}).get("post"), paths.get(VIEWS, {}).get("get")
    told = paths.get(SAID, {}).get("get")
    if sent is not None:
        sent["requestBody"] = {"required": True, "content": {"application/octet-stream": BYTES}}
    if shown is not None:
        shown["responses"]["200"]["content"] = dict.fromkeys(PICTURES, BYTES)
    if told is not None:
        kinds = ("application/octet-stream", *PICTURES, "image/webp", "image/gif")
        told["responses"]["200"]["content"] = dict.fromkeys(kinds, BYTES)


def _any_of(part: Any) -> Any:  # noqa: ANN401 - any part of a description
    """Return a part in which what fits two kinds fits: 15.0 is a number and an integer.

    Litestar writes each union as ``oneOf``, and beside a string with limits what all fits.
    """
    if isinstance(part, list):
        return [_any_of(one) for one in part]
    if not isinstance(part, dict):
        return part
    described_part = {key: _any_of(one) for key, one in part.items() if key != "oneOf"}
    kinds = [_any_of(one) for one in part.get("oneOf", ()) if one != {}]
    if len(kinds) == 1:
        return {**kinds[0], **described_part}
    return {**described_part, "anyOf": kinds} if kinds else described_part


def _operations(schema: dict[str, Any]) -> Iterable[dict[str, Any]]:
    for path in schema.get("paths", {}).values():
        for method, operation in path.items():
            if method in METHODS:
                yield operation


def _refusal(status: HTTPStatus) -> dict[str, Any]:
    schema = {"$ref": f"#/components/schemas/{NAME}"}
    return {"description": status.phrase, "content": {PROBLEM: {"schema": schema}}}
