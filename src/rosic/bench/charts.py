"""Charts of a report as PNG and SVG, by matplotlib: the extra ``bench``."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any, Final

from rosic.errors import ConfigurationError, how_to_install

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from matplotlib.axes import Axes

    from rosic.bench.report import Chart

SIZE_INCHES: Final = (7.2, 3.6)
DPI: Final = 110
BINS: Final = 30
COLOURS: Final = ("#2563a8", "#c2571a", "#2e7d4f", "#7a4fa3", "#6b7280", "#a3324a")
NO_CHARTS: Final = "Charts need matplotlib, which is not installed."
STYLE: Final[dict[Any, object]] = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.grid.axis": "y",
    "grid.color": "#e5e7eb",
    "axes.axisbelow": True,
    "svg.hashsalt": "rosic",  # the same figures make the same file
    "svg.fonttype": "path",
}


def require_charts() -> None:
    """Make sure that charts can be drawn.

    Raises:
        ConfigurationError: The extra is not installed; says how to.
    """
    try:
        import matplotlib  # noqa: F401, ICN001, PLC0415 - an extra
    except ImportError:
        raise ConfigurationError(NO_CHARTS, hint=f"Run: {how_to_install('bench')}") from None


def drawn(chart: Chart, kind: str) -> bytes:
    """Return a chart as a picture.

    Args:
        chart: What to draw.
        kind: ``png`` or ``svg``.

    Raises:
        ConfigurationError: The extra is not installed.
    """
    require_charts()
    from matplotlib import rc_context  # noqa: PLC0415 - an extra
    from matplotlib.figure import Figure  # noqa: PLC0415 - an extra

    with rc_context(STYLE):
        figure = Figure(figsize=SIZE_INCHES, dpi=DPI, layout="constrained")
        axes = figure.subplots()
        DRAWN[chart.kind](axes, chart)
        axes.set_title(chart.title, loc="left", fontsize=10, fontweight="bold")
        axes.set_xlabel(chart.x)
        axes.set_ylabel(chart.y)
        if len(chart.series) > 1:
            axes.legend(frameon=False, fontsize=8)
        content = io.BytesIO()
        undated: Mapping[str, Any] = {"Date": None} if kind == "svg" else {}
        figure.savefig(content, format=kind, metadata=undated)
    return content.getvalue()


def _bars(axes: Axes, chart: Chart) -> None:
    names = list(dict.fromkeys(str(x) for series in chart.series for x in series.x))
    width = 0.8 / len(chart.series)
    for number, series in enumerate(chart.series):
        shift = (number - (len(chart.series) - 1) / 2) * width
        places = [names.index(str(x)) + shift for x in series.x]
        axes.bar(
            places,
            series.y,
            width * 0.92,
            yerr=series.error or None,
            capsize=3,
            label=series.name,
            color=COLOURS[number % len(COLOURS)],
            error_kw={"ecolor": "#111827", "elinewidth": 1},
        )
    axes.set_xticks(range(len(names)), names)


def _histogram(axes: Axes, chart: Chart) -> None:
    every = [value for series in chart.series for value in series.y]
    span = (min(every), max(every)) if every else (0.0, 1.0)
    for number, series in enumerate(chart.series):
        axes.hist(
            series.y,
            bins=BINS,
            range=span,
            alpha=0.75 if len(chart.series) > 1 else 1.0,
            label=series.name,
            color=COLOURS[number % len(COLOURS)],
        )


def _lines(axes: Axes, chart: Chart) -> None:
    for number, series in enumerate(chart.series):
        axes.plot(
            series.x or range(1, len(series.y) + 1),
            series.y,
            label=series.name,
            color=COLOURS[number % len(COLOURS)],
            linewidth=1.2,
        )
    axes.set_ylim(bottom=min(0.0, *axes.get_ylim()))


DRAWN: Final[dict[str, Callable[[Axes, Chart], None]]] = {
    "bars": _bars,
    "histogram": _histogram,
    "lines": _lines,
}
