"""Whether a figure that was sampled over hours grows: a slope, and between which bounds it lies.

The slope is that of Theil and Sen, the median of the slopes between all pairs, with the bounds of
P. K. Sen, Estimates of the regression coefficient based on Kendall's tau, JASA 63 (1968). They are
wider where neighbours in time have something in common: K. H. Hamed and A. R. Rao, A modified
Mann-Kendall trend test for autocorrelated data, Journal of Hydrology 204 (1998).

A slope over hours does not show what begins late, or comes at once. So a figure grows, too, whose
last quarter lies above its first by more than three times what that quarter differs within itself,
and a twentieth.
"""

from __future__ import annotations

from itertools import combinations, pairwise
from math import sqrt
from statistics import NormalDist, fmean, median
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.time_units import HOUR_S

if TYPE_CHECKING:
    from collections.abc import Sequence

BINS: Final = 24
"""So many means over stretches of equal length stand for the samples."""
SURE: Final = 0.99
QUARTER: Final = BINS // 4
WIDELY: Final = 3.0
SLIGHT: Final = 0.05
GROWS: Final = "grows"
FALLS: Final = "falls"
LEVEL: Final = "not distinguishable from 0"


class Trend(NamedTuple):
    """How fast a figure grows, in an hour.

    Attributes:
        low, high: Between these bounds it lies, `SURE` of the times.
        rose: Its last quarter lies above the first by more than that differs within itself.
    """

    per_hour: float
    low: float
    high: float
    rose: bool = False

    @property
    def verdict(self) -> str:
        """Say whether it grows."""
        if self.low > 0 or self.rose:
            return GROWS
        return FALLS if self.high < 0 else LEVEL


def trend_of(times_s: Sequence[float], values: Sequence[float]) -> Trend:
    """Return the trend of samples, in the order of their times.

    Raises:
        ValueError: There are fewer samples than `BINS`.
    """
    if len(values) < BINS:
        raise ValueError(f"{len(values)} samples are too few for a trend")
    points = _binned(times_s, values)
    slopes = sorted(
        (after - before) / (later - hour)
        for (hour, before), (later, after) in combinations(points, 2)
    )
    slope = median(slopes)
    variance = BINS * (BINS - 1) * (2 * BINS + 5) / 18
    alike = _alike([value - slope * hour for hour, value in points])
    reach = NormalDist().inv_cdf((1 + SURE) / 2) * sqrt(variance * alike)
    first = max(0, int((len(slopes) - reach) / 2))
    return Trend(slope, slopes[first], slopes[-1 - first], _rose([value for _, value in points]))


def _rose(values: Sequence[float]) -> bool:
    early, late = values[:QUARTER], values[-QUARTER:]
    usual = WIDELY * (max(early) - min(early)) + SLIGHT * abs(median(early))
    return median(late) - median(early) > usual


def _binned(times_s: Sequence[float], values: Sequence[float]) -> list[tuple[float, float]]:
    edges = [round(number * len(values) / BINS) for number in range(BINS + 1)]
    spans = [slice(begin, end) for begin, end in pairwise(edges)]
    return [(fmean(times_s[span]) / HOUR_S, fmean(values[span])) for span in spans]


def _alike(residuals: Sequence[float]) -> float:
    """Return how many times as far bounds lie apart because neighbours are alike: squared."""
    count = len(residuals)
    ordered = sorted(residuals)
    middle = (count - 1) / 2
    ranks = [_rank(ordered, value) - middle for value in residuals]
    power = sum(rank * rank for rank in ranks)
    if not power:
        return 1.0
    notable, more = NormalDist().inv_cdf(0.975) / sqrt(count), 0.0
    for lag in range(1, count - 2):
        shared = sum(one * other for one, other in zip(ranks, ranks[lag:], strict=False)) / power
        if abs(shared) > notable:
            more += (count - lag) * (count - lag - 1) * (count - lag - 2) * shared
    return max(1.0, 1 + 2 * more / (count * (count - 1) * (count - 2)))


def _rank(ordered: Sequence[float], value: float) -> float:
    """Return the place of a value among all; equal ones share theirs."""
    places = [at for at, other in enumerate(ordered) if other == value]
    return fmean(places)
