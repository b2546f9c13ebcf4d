"""Metrics as Prometheus reads them: the text format 0.0.4.

https://prometheus.io/docs/instrumenting/exposition_formats/
"""

from __future__ import annotations

from bisect import bisect_left
from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

MEDIA_TYPE: Final = "text/plain; version=0.0.4; charset=utf-8"
COUNTER, GAUGE, HISTOGRAM = "counter", "gauge", "histogram"
_ESCAPED: Final = str.maketrans({"\\": r"\\", "\n": r"\n", '"': r"\""})


class Histogram:
    """How often something took how long; counts in buckets that only grow.

    Args:
        bounds: Upper bounds of the buckets in seconds, growing.
    """

    def __init__(self, bounds: Sequence[float]) -> None:
        self._bounds = tuple(bounds)
        self._counts = [0] * (len(self._bounds) + 1)
        self._sum = 0.0

    def observe(self, seconds: float) -> None:
        """Count one."""
        self._counts[bisect_left(self._bounds, seconds)] += 1
        self._sum += seconds

    @property
    def count(self) -> int:
        """How many were counted."""
        return sum(self._counts)

    @property
    def mean_s(self) -> float:
        """How long it took on average; 0 where nothing was counted."""
        return self._sum / self.count if self.count else 0.0

    def lines(self, name: str, labels: Mapping[str, str]) -> Iterator[str]:
        """Yield its lines."""
        so_far = 0
        for bound, count in zip((*map(_number, self._bounds), "+Inf"), self._counts, strict=True):
            so_far += count
            yield _line(f"{name}_bucket", {**labels, "le": bound}, so_far)
        yield _line(f"{name}_sum", labels, self._sum)
        yield _line(f"{name}_count", labels, so_far)


class Sample(NamedTuple):
    """One value of a metric.

    Attributes:
        labels: What it is of: ``{"robot": "omni"}``.
        value: A number; or times that were measured.
    """

    labels: Mapping[str, str]
    value: float | Histogram


class Metric(NamedTuple):
    """One metric with its values."""

    name: str
    kind: str
    about: str
    samples: tuple[Sample, ...]

    def lines(self) -> Iterator[str]:
        """Yield what it is, then its samples; nothing without a sample."""
        if self.samples:
            yield f"# HELP {self.name} {self.about}"
            yield f"# TYPE {self.name} {self.kind}"
        for labels, value in self.samples:
            if isinstance(value, Histogram):
                yield from value.lines(self.name, labels)
            else:
                yield _line(self.name, labels, value)


def page(metrics: Iterable[Metric]) -> bytes:
    """Return metrics as Prometheus reads them."""
    return "".join(f"{line}\n" for metric in metrics for line in metric.lines()).encode()


def _line(name: str, labels: Mapping[str, str], value: float) -> str:
    said = ",".join(f'{key}="{text.translate(_ESCAPED)}"' for key, text in labels.items())
    return f"{name}{{{said}}} {_number(value)}" if said else f"{name} {_number(value)}"


def _number(value: float) -> str:
    return str(value) if isinstance(value, int) else f"{value:.9g}"
