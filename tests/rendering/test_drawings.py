"""Maps, charts, ways, clips and scenes: that they show what they should, within their bounds."""

from __future__ import annotations

import io
from math import inf, nan, pi
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace
from PIL import Image, ImageDraw, ImageFont

from rosic.config.plugins import catalogue
from rosic.core.i18n import Sentence, in_language
from rosic.core.robot.view import (
    Ball,
    Box,
    Clip,
    Colour,
    Drawing,
    Label,
    OccupancyMap,
    PathsView,
    PathView,
    Pose,
    RawFrame,
    Scene,
    Subject,
    TimeSeries,
    Tube,
)
from rosic.errors import NothingToSee
from rosic.rendering.charts import ticks, written
from rosic.rendering.draw import draw
from rosic.rendering.style import (
    ACCENT,
    ALERT,
    GOOD,
    INK,
    PAPER,
    SEVERAL,
    Sheet,
    font,
    readable,
)

if TYPE_CHECKING:
    from rosic.contracts.renderer import Renderer

PAINTER: Renderer = draw
GRID = OccupancyMap(
    40, 20, 0.05, Pose(-1.0, -0.5), bytes([0] * 400 + [100] * 400), Pose(0.5, -0.25, yaw_rad=0)
)
CURVE = TimeSeries("omni: battery", "%", tuple((i - 60.0, 80 - i / 10) for i in range(60)), 20.0)
WAY = PathView("omni: move", tuple(Pose(i / 10, 0.2, yaw_rad=0) for i in range(10)))
WAYS = PathsView("swarm", (WAY, PathView("cf1", (Pose(0, 0), Pose(0.4, 0.9)))))
ROOM = Scene(
    (
        Box((0, 0, 0.5), (1, 1, 1), (200, 30, 30)),
        Ball((0, -1, 0.3), 0.2, (30, 30, 200)),
        Tube((1, 0, 0), (1, 0, 1), 0.1, (30, 200, 30)),
    ),
    (0.0, -5.0, 2.0),
    (0.0, 0.0, 0.5),
    labels=(Label("it", (0, 0, 1.2)),),
)


def opened(drawing: Drawing) -> Image.Image:
    image = Image.open(io.BytesIO(drawing.content))
    assert image.size == (drawing.width, drawing.height)
    assert max(image.size) <= 1280
    assert len(drawing.content) <= 4_000_000
    return image


def places(image: Image.Image, colour: Colour) -> list[tuple[int, int]]:
    """Return where something of about this colour is."""
    pixels = image.convert("RGB").tobytes()
    reds, greens, blues = (range(part - 29, part + 30) for part in colour)
    return [
        (at % image.width, at // image.width)
        for at, (red, green, blue) in enumerate(
            zip(pixels[::3], pixels[1::3], pixels[2::3], strict=True)
        )
        if red in reds and green in greens and blue in blues
    ]


def middle(found: list[tuple[int, int]]) -> tuple[float, float]:
    return sum(x for x, _ in found) / len(found), sum(y for _, y in found) / len(found)


@pytest.mark.parametrize("subject", [GRID, CURVE, WAY, WAYS, ROOM, Clip((ROOM, ROOM), 0.2)])
@pytest.mark.parametrize("low", [False, True])
def test_everything_has_a_low_quality_that_is_smaller(subject: Subject, *, low: bool) -> None:
    image = opened(draw(subject, low=low))
    if low:
        full = opened(draw(subject))
        assert image.width < full.width


def test_a_map_has_its_origin_below_on_the_left_and_the_robot_where_it_is() -> None:
    drawing = draw(GRID)
    image = opened(drawing).convert("RGB")
    taken, free = image.getpixel((30, 30)), image.getpixel((30, drawing.height - 60))
    assert isinstance(taken, tuple)
    assert isinstance(free, tuple)
    assert sum(taken) + 400 < sum(free)  # the later rows are farther up
    x, y = middle(places(image, ACCENT))
    # Three quarters across, a quarter up.
    assert abs(x / drawing.width - 0.75) < 0.03
    assert abs(y / (drawing.height - 34) - 0.75) < 0.05


def test_a_turned_map_is_shown_with_its_own_axes_upright() -> None:
    turned = replace(GRID, origin=Pose(0, 0, yaw_rad=pi / 2), pose=Pose(-0.25, 1.5, yaw_rad=0))
    drawing = draw(turned)
    x, y = middle(places(opened(drawing), ACCENT))
    assert abs(x / drawing.width - 0.75) < 0.03
    assert abs(y / (drawing.height - 34) - 0.75) < 0.05


def test_ways_of_several_robots_have_a_colour_each_and_end_where_the_robot_is() -> None:
    image = opened(draw(WAYS))
    one, other = (places(image, colour) for colour in SEVERAL[:2])
    assert len(one) > 300
    assert len(other) > 300
    assert max(x for x, _ in one) > max(x for x, _ in other), "to 0.9 m against 0.4 m"
    assert min(y for _, y in other) < min(y for _, y in one), "up to 0.9 m against 0.2 m"
    with pytest.raises(NothingToSee):
        draw(PathsView("nobody", (PathView("cf1", (Pose(nan, 0),)),)))


def test_a_path_is_shown_and_its_end_marked() -> None:
    image = opened(draw(replace(GRID, path=tuple((i / 50 - 0.9, -0.4) for i in range(90)))))
    assert len(places(image, ALERT)) > 500


@pytest.mark.parametrize(
    "wrong",
    [
        replace(GRID, cells=b"\0" * 799),
        replace(GRID, width=0),
        replace(GRID, cells=b""),
        replace(GRID, resolution_m=0.0),
        replace(GRID, resolution_m=nan),
        replace(GRID, origin=Pose(inf, 0)),
        replace(GRID, width=100_000, height=100_000),
    ],
)
def test_a_broken_map_is_refused(wrong: OccupancyMap) -> None:
    with pytest.raises(NothingToSee, match=r"^The map .*\.$"):
        draw(wrong)


def test_a_pose_that_is_no_number_is_left_out() -> None:
    image = opened(draw(replace(GRID, pose=Pose(nan, 0), path=((nan, 0.0), (0.0, 0.0)))))
    assert not [y for _, y in places(image, ACCENT) if y < image.height - 34]


def test_a_curve_falls_where_it_falls() -> None:
    image = opened(draw(CURVE))
    line = [place for place in places(image, ACCENT) if place[1] > 50]  # below its title
    left = [y for x, y in line if x < 200]
    right = [y for x, y in line if x > 600]
    assert sum(left) / len(left) < sum(right) / len(right) - 50


def test_a_gap_in_a_curve_stays_a_gap() -> None:
    points = tuple(p for p in CURVE.points if not -40 < p[0] < -20)
    whole, torn = (
        places(opened(draw(replace(CURVE, points=p))), ACCENT) for p in (CURVE.points, points)
    )
    assert [x for x, y in whole if 380 < x < 420 and y > 50]
    assert not [x for x, y in torn if 380 < x < 420 and y > 50]


def test_the_line_that_should_not_be_crossed_is_shown_when_it_is_near() -> None:
    close = replace(CURVE, points=tuple((t, v - 55) for t, v in CURVE.points))
    assert not places(opened(draw(CURVE)), ALERT)
    assert places(opened(draw(close)), ALERT)


def test_words_in_a_drawing_are_those_of_whoever_looks() -> None:
    written: list[str] = []

    def say(text: str) -> str:
        """As a catalogue does that knows what was made of what."""
        written.append(text)
        return f"{text.template.upper()}" if isinstance(text, Sentence) else text

    close = replace(CURVE, points=tuple((t, v - 55) for t, v in CURVE.points))
    up = PathView("cf1: takeoff", tuple(Pose(0, 0, i / 10) for i in range(10)), vertical=True)
    path = replace(GRID, path=((0.0, 0.0), (0.5, 0.5)))
    for subject, words in (
        (close, ("now", "{count} s", "alert below {value}")),
        (up, ("height, m",)),
        (path, ("path", "robot")),
    ):
        written.clear()
        english, other = draw(subject), draw(subject, say=say)
        templates = {text.template for text in written if isinstance(text, Sentence)}
        assert templates == set(words)
        assert other.content != english.content, "they were drawn so"


def _pixels(words: str) -> bytes:
    sheet = Sheet(400, 30)
    sheet.text((4, 4), words, size=16)
    return sheet.finished().tobytes()


LETTERS = "äöüÄÖÜßéñçłøåžșğя²–„“→·…°µΩЖщїє"  # noqa: RUF001 - people write it


def test_every_letter_of_latin_greek_and_cyrillic_is_drawn_as_itself() -> None:
    drawn = {letter: _pixels(letter) for letter in LETTERS}
    assert len(set(drawn.values())) == len(LETTERS), "two look the same: one is no letter"
    assert _pixels("") not in drawn.values()
    assert readable(f"Förderer {LETTERS}") == f"Förderer {LETTERS}"
    assert _pixels("Fo\u0308rderer") == _pixels("Förderer")


def test_a_letter_that_no_font_has_is_written_plainly() -> None:
    assert readable("ﬀ 机 \U0001d7d9") == "ff ? 1"
    assert _pixels("机") == _pixels("?")


def test_a_line_of_plain_letters_is_drawn_as_ever() -> None:
    sheet = Image.new("RGB", (200, 30), PAPER)
    pen = ImageDraw.Draw(sheet)
    face = ImageFont.load_default(16)
    pen.text((4, 4), "omni: battery", fill=INK, font=face)
    other = Image.new("RGB", (200, 30), PAPER)
    ImageDraw.Draw(other).text((4, 4), "omni: battery", fill=INK, font=font("omni: battery", 16))
    assert other.tobytes() == sheet.tobytes()


def test_numbers_in_a_drawing_have_the_commas_of_whoever_looks() -> None:
    german = catalogue("de")
    assert german is not None
    told: list[str] = []

    def say(words: str) -> str:
        assert german is not None
        told.append(in_language(words, german))
        return told[-1]

    curve = TimeSeries("omni: battery", "V", ((-10.0, 11.85), (0.0, 12.25)), 11.9)
    draw(curve, say=say)
    draw(replace(WAY, title="omni: way"), say=say)
    draw(WAYS, say=say)
    draw(GRID, say=say)
    assert "12,25 V" in told
    assert not [words for words in told if "." in words]
    assert in_language(written(12_500.0, 500.0), german) == "12\u202f500"
    assert written(12_500.0, 500.0) == "12,500"


@pytest.mark.parametrize("points", [(), ((0.0, nan),), ((-1.0, inf),)])
def test_nothing_to_draw_is_said(points: tuple[tuple[float, float], ...]) -> None:
    with pytest.raises(NothingToSee):
        draw(replace(CURVE, points=points))


@pytest.mark.parametrize("values", [[5.0], [0.0, 0.0], [1e9, -1e9], [1e-9, 2e-9], [-3.0, -3.0]])
def test_any_range_of_values_can_be_drawn(values: list[float]) -> None:
    draw(TimeSeries("x", "", tuple((float(i - 9), v) for i, v in enumerate(values))))


def test_a_way_begins_green_and_ends_where_the_robot_is() -> None:
    image = opened(draw(WAY))
    begin, end = middle(places(image, GOOD)), max(x for x, _ in places(image, ACCENT))
    assert end - begin[0] > 300


def test_a_way_up_shows_its_height_as_well() -> None:
    up = PathView("cf1: takeoff", tuple(Pose(0, 0, i / 10) for i in range(10)), vertical=True)
    lower = [y for _, y in places(opened(draw(up)), ACCENT) if y > 470]
    assert max(lower) - min(lower) > 50


@pytest.mark.parametrize("way", [PathView("x", ()), PathView("x", (Pose(nan, 0),))])
def test_no_way_is_said(way: PathView) -> None:
    with pytest.raises(NothingToSee):
        draw(way)


def test_a_clip_moves() -> None:
    row = bytes(range(64))
    frames = tuple(
        RawFrame(64, 48, "mono8", 64, (row[i:] + row[:i]) * 48) for i in range(0, 50, 10)
    )
    image = opened(draw(Clip(frames, 0.25)))
    assert (image.format, getattr(image, "n_frames", 0)) == ("GIF", 5)
    assert image.info["duration"] == 250


def test_a_clip_of_nothing_is_refused() -> None:
    with pytest.raises(NothingToSee):
        draw(Clip((), 0.2))


def test_what_stands_before_hides_what_stands_behind() -> None:
    small, large = (
        Ball((0, 1, 0.5), 0.2, (30, 30, 200)),
        Box((0, 0, 0.5), (1, 0.2, 1), (200, 30, 30)),
    )
    before = replace(small, centre=(0, -1, 0.5))
    empty = replace(ROOM, solids=(), labels=())

    def blue(*solids: Ball | Box) -> int:
        shown = opened(draw(replace(empty, solids=solids))).convert("RGB")
        pixels = [shown.getpixel((x, y)) for x in range(540, 740, 4) for y in range(200, 600, 4)]
        return sum(1 for p in pixels if isinstance(p, tuple) and p[2] > 1.5 * p[0])

    assert blue(before, large) > 50
    assert blue(large, before) == blue(before, large)
    assert blue(small, large) == blue(large, small) == 0


@pytest.mark.parametrize(
    "wrong",
    [
        replace(ROOM, eye=(nan, 0, 0)),
        replace(ROOM, angle_rad=0.0),
        replace(ROOM, floor=(-1e6, -1e6, 1e6, 1e6)),
        replace(ROOM, solids=ROOM.solids * 300),
        replace(ROOM, solids=(Ball((nan, 0, 0), 0.1, (0, 0, 0)),)),
    ],
)
def test_a_broken_scene_is_refused(wrong: Scene) -> None:
    with pytest.raises(NothingToSee, match=r"^The scene .*\.$"):
        draw(wrong)


def test_ticks_are_round_and_within() -> None:
    assert ticks(-0.3, 1.1, 5) == pytest.approx([0.0, 0.5, 1.0])
    assert [written(v, 0.5) for v in ticks(-1.0, 1.0, 4)] == ["-1.0", "-0.5", "0.0", "0.5", "1.0"]
    assert written(1200.0, 200.0) == "1,200"
