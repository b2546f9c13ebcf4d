"""The route of what is measured of the gateway: the figures of ``/metrics``, for people to read."""

from __future__ import annotations

import msgspec
from litestar import get
from litestar.di import NamedDependency
from litestar.params import SkipValidation

from rosic.api.metrics.exposition import MetricSeries, read_families
from rosic.api.metrics.gateway_metrics import GatewayMetrics
from rosic.api.routes import Api, Who
from rosic.core.i18n import said

FIGURES_ONLY = said("What is measured here is shown to whoever looks after people.")
Figures = NamedDependency[SkipValidation[GatewayMetrics]]


class FigureOut(msgspec.Struct, frozen=True):
    """One figure.

    Attributes:
        labels: What it is of: ``{"robot": "omni"}``.
        value: Of times that were measured, their mean in seconds.
        count: Of times that were measured, how many; else null.
    """

    labels: dict[str, str]
    value: float
    count: int | None


class MetricOut(msgspec.Struct, frozen=True):
    """Figures of one kind.

    Attributes:
        kind: ``counter``, which only grows; ``gauge``; or ``histogram``, of times.
    """

    name: str
    kind: str
    about: str
    figures: tuple[FigureOut, ...]


@get("/metrics", summary="What is measured", tags=["health"])
async def metrics(api: Api, caller: Who, figures: Figures) -> list[MetricOut]:
    """Return what `/metrics` tells a monitoring, for whoever looks after people."""
    api.check_admin(caller, FIGURES_ONLY)
    return [_metric(found) for found in read_families(figures.lines())]


def _metric(found: MetricSeries) -> MetricOut:
    return MetricOut(
        found.name,
        found.kind,
        found.about,
        tuple(FigureOut(dict(each.labels), each.value, each.counted) for each in found.figures),
    )


ROUTES = (metrics,)
