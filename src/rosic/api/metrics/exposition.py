"""Metrics as Prometheus reads them: the text format 0.0.4.

https://prometheus.io/docs/instrumenting/exposition_formats/
"""

from __future__ import annotations

import re
from bisect import bisect_left
from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

MEDIA_TYPE: Final = "text/plain; version=0.0.4; charset=utf-8"
COUNTER, GAUGE, HISTOGRAM = "counter", "gauge", "histogram"
_LABEL: Final = re.compile(r'(\w+)="((?:[^"\\]|\\.)*)"')
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

    def lines(self, name: str, labels: Mapping[str, str]) -> Iterator[str]:
        """Yield its lines."""
        so_far = 0
        for bound, count in zip((*map(_number, self._bounds), "+Inf"), self._counts, strict=True):
            so_far += count
            yield sample(f"{name}_bucket", {**labels, "le": bound}, so_far)
        yield sample(f"{name}_sum", labels, self._sum)
        yield sample(f"{name}_count", labels, so_far)


def family(name: str, kind: str, about: str, samples: Iterable[str]) -> Iterator[str]:
    """Yield the lines of one metric: what it is, then its samples; nothing without a sample."""
    found = tuple(samples)
    if found:
        yield f"# HELP {name} {about}"
        yield f"# TYPE {name} {kind}"
        yield from found


def sample(name: str, labels: Mapping[str, str], value: float) -> str:
    """Return one line."""
    said = ",".join(f'{key}="{text.translate(_ESCAPED)}"' for key, text in labels.items())
    return f"{name}{{{said}}} {_number(value)}" if said else f"{name} {_number(value)}"


def page(lines: Iterable[str]) -> bytes:
    """Return lines as what is answered."""
    return "".join(f"{line}\n" for line in lines).encode()


def _number(value: float) -> str:
    return str(value) if isinstance(value, int) else f"{value:.9g}"


# ---- read again, for people ----


class Figure(NamedTuple):
    """One value; of a histogram its mean, and how many were counted."""

    labels: tuple[tuple[str, str], ...]
    value: float
    counted: int | None = None


class MetricSeries(NamedTuple):
    """One metric with its values."""

    name: str
    kind: str
    about: str
    figures: tuple[Figure, ...]


def read_families(lines: Iterable[str]) -> Iterator[MetricSeries]:
    """Yield what lines of `family` say; without the buckets of histograms, and what is empty."""
    name = kind = about = ""
    samples: list[tuple[str, tuple[tuple[str, str], ...], float]] = []
    for line in (*lines, "# HELP  "):
        if line.startswith("# HELP "):
            figures = tuple(_figures(samples, kind))
            if figures:
                yield MetricSeries(name, kind, about, figures)
            name, _, about = line.removeprefix("# HELP ").partition(" ")
            samples = []
        elif line.startswith("# TYPE "):
            kind = line.rpartition(" ")[2]
        else:
            what, _, number = line.rpartition(" ")
            known, _, labels = what.partition("{")
            read = tuple((key, _unescaped(text)) for key, text in _LABEL.findall(labels))
            samples.append((known.removeprefix(name), read, float(number)))


def _figures(
    samples: Iterable[tuple[str, tuple[tuple[str, str], ...], float]], kind: str
) -> Iterator[Figure]:
    sums: dict[tuple[tuple[str, str], ...], float] = {}
    for part, labels, value in samples:
        if kind != HISTOGRAM:
            yield Figure(labels, value)
        elif part == "_sum":
            sums[labels] = value
        elif part == "_count" and value:
            yield Figure(labels, sums[labels] / value, int(value))


def _unescaped(text: str) -> str:
    return re.sub(r"\\(.)", lambda found: "\n" if found[1] == "n" else found[1], text)
