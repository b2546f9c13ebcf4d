"""The route of what is measured of the gateway: the figures of ``/metrics``, for people to read."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
from litestar import get
from litestar.di import NamedDependency
from litestar.params import SkipValidation

from rosic.api.metrics.exposition import Histogram, Metric, Sample
from rosic.api.metrics.gateway_metrics import GatewayMetrics
from rosic.api.routes import Api, Who
from rosic.core.i18n import in_language, said

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.i18n import Catalogue

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
        about: What it is, in the language of whoever asks.
    """

    name: str
    kind: str
    about: str
    figures: tuple[FigureOut, ...]


@get("/metrics", summary="What is measured", tags=["health"])
async def metrics(api: Api, caller: Who, figures: Figures) -> list[MetricOut]:
    """Return what `/metrics` tells a monitoring, for whoever looks after people."""
    api.check_admin(caller, FIGURES_ONLY)
    return shown(figures.metrics(), api.languages.of(caller.principal))


def shown(metrics: Iterable[Metric], catalogue: Catalogue | None = None) -> list[MetricOut]:
    """Return metrics for people to read: without buckets, and without what is empty."""
    found = [_metric(one, catalogue) for one in metrics]
    return [one for one in found if one.figures]


def _metric(found: Metric, catalogue: Catalogue | None) -> MetricOut:
    figures = tuple(_figure(each) for each in found.samples if not _is_empty(each.value))
    return MetricOut(found.name, found.kind, in_language(found.about, catalogue), figures)


def _is_empty(value: float | Histogram) -> bool:
    return isinstance(value, Histogram) and not value.count


def _figure(one: Sample) -> FigureOut:
    labels, value = dict(one.labels), one.value
    if isinstance(value, Histogram):
        return FigureOut(labels, value.mean_s, value.count)
    return FigureOut(labels, value, None)


ROUTES = (metrics,)
