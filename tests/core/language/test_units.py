from __future__ import annotations

import subprocess
import sys
from math import pi
from typing import TYPE_CHECKING

import msgspec
import pint
import pytest

from rosic.config import units as table_of_names
from tests.pace import pace

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.core.language import UnitTable


@pytest.mark.parametrize(
    ("spelled", "dimension", "si"),
    [
        ("m", "length", 1),
        ("metres", "length", 1),
        ("meter", "length", 1),
        ("cm", "length", 0.01),
        ("mm", "length", 0.001),
        ("km", "length", 1000),
        ("in", "length", 0.0254),
        ("inch", "length", 0.0254),
        ("ft", "length", 0.3048),
        ("deg", "angle", pi / 180),
        ("degrees", "angle", pi / 180),
        ("°", "angle", pi / 180),
        ("rad", "angle", 1),
        ("turn", "angle", 2 * pi),
        ("s", "time", 1),
        ("sec", "time", 1),
        ("min", "time", 60),
        ("h", "time", 3600),
        ("ms", "time", 0.001),
        ("m/s", "speed", 1),
        ("km/h", "speed", 1 / 3.6),
        ("cm/s", "speed", 0.01),
        ("mph", "speed", 0.44704),
        ("metres per second", "speed", 1),
        ("rad/s", "turning speed", 1),
        ("deg/s", "turning speed", pi / 180),
        ("rpm", "turning speed", 2 * pi / 60),
        ("N", "force", 1),
        ("mN", "force", 0.001),
        ("kgf", "force", 9.80665),
        ("lbf", "force", 4.4482216152605),
        ("kg", "mass", 1),
        ("g", "mass", 0.001),
        ("%", "share", 0.01),
        ("percent", "share", 0.01),
        ("Hz", "frequency", 1),
        ("V", "voltage", 1),
        ("Nm", "torque", 1),
        ("Grad", "angle", pi / 180),
        ("grade", "angle", pi / 180),
        ("Umdrehungen", "angle", 2 * pi),
        ("Metern", "length", 1),
        ("Zentimeter", "length", 0.01),
        ("fuß", "length", 0.3048),
        ("Sekunden", "time", 1),
        ("Minute", "time", 60),
        ("stunden", "time", 3600),
        ("Meter pro Sekunde", "speed", 1),
        ("Grad pro Sekunde", "turning speed", pi / 180),
        ("Prozent", "share", 0.01),
    ],
)
def test_a_spelling_has_its_unit(units: UnitTable, spelled: str, dimension: str, si: float) -> None:
    unit = units.find(spelled)

    assert unit is not None
    assert unit.dimension == dimension
    assert unit.factor == pytest.approx(si, rel=1e-12)
    assert unit.offset == 0


@pytest.mark.parametrize(
    ("spelled", "value", "kelvin"),
    [
        ("degC", 0, 273.15),
        ("°C", 100, 373.15),
        ("°F", 32, 273.15),
        ("°F", 212, 373.15),
        ("K", 5, 5),
    ],
)
def test_temperatures_have_a_zero_of_their_own(
    units: UnitTable, spelled: str, value: float, kelvin: float
) -> None:
    unit = units.find(spelled)

    assert unit is not None
    assert value * unit.factor + unit.offset == pytest.approx(kelvin)


def test_every_factor_is_what_the_whole_of_pint_says(units: UnitTable) -> None:
    registry: pint.UnitRegistry[float] = pint.UnitRegistry(autoconvert_offset_to_baseunit=True)
    checked = 0
    for named in table_of_names._UNITS.values():
        kinds = {str(registry.Quantity(1.0, name).to_base_units().units) for name in named}
        assert len(kinds) == 1
        for name, spelled in named.items():
            if not spelled:
                continue
            unit = units.exact[spelled.split("|")[0].split()[0]]
            for value in (1.0, 17.5):
                there = registry.Quantity(value, name).to_base_units().magnitude
                assert value * unit.factor + unit.offset == pytest.approx(there, rel=1e-12)
            checked += 1
    assert checked > 60


# ---- slips of a finger ----


def test_no_unit_that_pint_knows_is_taken_for_another(units: UnitTable) -> None:
    """A gradian is no radian, a decametre no decimetre."""
    registry: pint.UnitRegistry[float] = pint.UnitRegistry(autoconvert_offset_to_baseunit=True)
    names = {name for name in registry._units if name.isalpha()}
    names |= {prefix + name for prefix in registry._prefixes if prefix[2:] for name in names}
    dimensions = {unit.dimension for unit in units.exact.values()}

    taken = {
        name: meant
        for name in names
        if units.find(name) is None and (meant := units.misspelt(name, dimensions))
    }

    assert len(names) > 10_000
    assert taken == {"degRe": ("degree",)}  # a symbol of degrees Réaumur, typed by nobody


def test_a_slip_in_a_full_name_is_that_unit_or_nothing(units: UnitTable) -> None:
    mended = 0
    for name, unit in units.exact.items():
        for at in range(len(name)):
            left_out = name[:at] + name[at + 1 :]
            swapped = name[:at] + name[at : at + 2][::-1] + name[at + 2 :]
            for slip in (left_out, swapped, name[:at] + name[at] * 2 + name[at + 1 :]):
                if units.find(slip) is None:
                    meant = units.misspelt(slip, {unit.dimension})
                    assert {units.exact[m] for m in meant} <= {unit}, (slip, name, meant)
                    mended += bool(meant)
                    assert not meant or len(slip) >= 5
    assert mended > 500


# ---- the factors that ship ----


def test_what_ships_is_what_pint_says_now() -> None:
    shipped = table_of_names.shipped_factors()

    assert shipped is not None, "made for another pint; run: python -m rosic.config.units"
    assert shipped == table_of_names.ask_pint(), "run: python -m rosic.config.units"


@pytest.mark.parametrize("change", [{"pint": "0.0.1"}, {"asked": "something else"}])
def test_factors_of_another_pint_or_of_other_units_do_not_count(
    change: dict[str, str], tmp_path: Path
) -> None:
    shipped = msgspec.json.decode(
        table_of_names.SHIPPED.read_bytes(), type=table_of_names.UnitFactors
    )
    file = tmp_path / "factors.json"
    file.write_bytes(msgspec.json.encode(shipped))
    assert table_of_names.shipped_factors(file) == shipped

    file.write_bytes(msgspec.json.encode(msgspec.structs.replace(shipped, **change)))

    assert table_of_names.shipped_factors(file) is None


@pytest.mark.parametrize("content", [None, b"", b"{}", b'{"pint": 1}', b"\xff"])
def test_factors_that_cannot_be_read_do_not_count(content: bytes | None, tmp_path: Path) -> None:
    file = tmp_path / "factors.json"
    if content is not None:
        file.write_bytes(content)

    assert table_of_names.shipped_factors(file) is None


def test_with_what_ships_pint_is_not_imported() -> None:
    code = "import sys; from rosic.config.units import compile_units as c; c(); print(*sys.modules)"
    done = subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        timeout=120 * pace(),
    )

    assert {"rosic.config.units", "msgspec"} <= set(done.stdout.split())
    assert {"pint", "numpy"}.isdisjoint(done.stdout.split())


def test_a_definition_or_a_name_that_changes_is_noticed() -> None:
    units = table_of_names._UNITS
    inch = table_of_names._DEFINITIONS.replace("2.54 *", "2.5 *")
    turned = {**units, "length": dict(reversed(units["length"].items()))}

    asked = {table_of_names.digest(), table_of_names.digest(inch)}
    assert len(asked | {table_of_names.digest(units=turned)}) == 3
    assert table_of_names.digest() == table_of_names.digest(table_of_names._DEFINITIONS, units)


def test_case_is_forgiven_where_it_decides_nothing(units: UnitTable) -> None:
    for said, meant in [
        ("CM", "cm"),
        ("Km", "km"),
        ("DEG", "deg"),
        ("hz", "Hz"),
        ("n", "N"),
        ("M", "m"),
    ]:
        assert units.find(said) == units.exact[meant]


@pytest.mark.parametrize("spelled", ["Mm", "MM", "MN", "Ms", "nm", "NM", "k", "mhz", "furlong", ""])
def test_case_is_not_forgiven_where_it_decides(units: UnitTable, spelled: str) -> None:
    assert units.find(spelled) is None
