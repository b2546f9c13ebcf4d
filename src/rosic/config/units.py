"""The units people may use, as factors that pint works out.

Converting with pint takes about 80 microseconds a value; looking a factor up takes a fraction of
one. Importing pint and asking it takes longer than the rest of a start, so its answers ship in
``unit_factors.json``, with the version of pint that gave them and a digest of what it was asked.
They count only where both still agree; otherwise pint is asked at start. ``python -m
rosic.config.units`` writes the file anew, and a test compares it with what pint says.

Only this module imports pint. What people may say is listed here, spelling by spelling, so that no
abbreviation out of thousands can be taken for something that nobody meant.
"""

from __future__ import annotations

from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from rosic.core.language.numbers import Unit, UnitTable

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

SHIPPED = Path(__file__).with_name("unit_factors.json")

# What pint has to know for it, in pint's language. Reading its own list of everything would take a
# sixth of a second more; the tests compare each factor with that list instead.
_DEFINITIONS = """
milli- = 1e-3
centi- = 1e-2
deci- = 1e-1
kilo- = 1e3
mega- = 1e6
meter = [length]
second = [time]
gram = [mass]
ampere = [current]
kelvin = [temperature]; offset: 0
radian = []
turn = 6.283185307179586476925287 * radian = _ = revolution
degree = turn / 360
percent = 0.01
minute = 60 * second
hour = 60 * minute
inch = 2.54 * centimeter
foot = 12 * inch
yard = 3 * foot
mile = 1760 * yard
liter = decimeter ** 3
metric_ton = 1000 * kilogram
pound = 453.59237 * gram
ounce = pound / 16
newton = kilogram * meter / second ** 2
kilogram_force = 9.80665 * newton
pound_force = 0.45359237 * kilogram_force
hertz = 1 / second
joule = newton * meter
watt = joule / second
volt = watt / ampere
watt_hour = watt * hour
pascal = newton / meter ** 2
bar = 1e5 * pascal
degree_Celsius = kelvin; offset: 273.15
degree_Fahrenheit = 5 / 9 * kelvin; offset: 233.15 + 200 / 9
"""

# Dimension, in a word people read, to units: pint's name, then how people write it. The first unit
# of a dimension is the SI one; the first spelling of a unit is the one shown.
_UNITS: dict[str, dict[str, str]] = {
    "length": {
        "meter": "m metre metres meter meters mtr Metern",
        "millimeter": "mm millimetre millimetres millimeter millimeters Millimetern",
        "centimeter": "cm centimetre centimetres centimeter centimeters Zentimeter Zentimetern",
        "decimeter": "dm decimetre decimetres decimeter decimeters Dezimeter Dezimetern",
        "kilometer": "km kilometre kilometres kilometer kilometers Kilometern",
        "inch": "in inch inches Zoll",
        "foot": "ft foot feet Fuß",
        "yard": "yd yard yards",
        "mile": "mi mile miles Meile Meilen",
    },
    "angle": {
        "radian": "rad radian radians Radiant",
        "degree": "deg degree degrees ° Grad Grade",
        "milliradian": "mrad milliradian milliradians Milliradiant",
        "turn": "turn turns revolution revolutions rev revs Umdrehung Umdrehungen",
    },
    "time": {
        "second": "s sec secs second seconds Sekunde Sekunden Sek",
        "millisecond": "ms msec millisecond milliseconds Millisekunde Millisekunden",
        "minute": "min mins minute minutes Minuten",
        "hour": "h hr hrs hour hours Stunde Stunden Std",
    },
    "speed": {
        "meter/second": "m/s mps|metre per second|metres per second|meter per second"
        "|meters per second|Meter pro Sekunde",
        "millimeter/second": "mm/s|millimetres per second|millimeters per second"
        "|Millimeter pro Sekunde",
        "centimeter/second": "cm/s|centimetres per second|centimeters per second"
        "|Zentimeter pro Sekunde",
        "kilometer/hour": "km/h kmh kph|kilometres per hour|kilometers per hour"
        "|Kilometer pro Stunde",
        "mile/hour": "mph|miles per hour",
        "foot/second": "ft/s|feet per second",
        "inch/second": "in/s|inches per second",
    },
    "turning speed": {
        "radian/second": "rad/s|radians per second",
        "degree/second": "deg/s °/s Grad/s|degrees per second|Grad pro Sekunde",
        "revolution/minute": "rpm|turns per minute|revolutions per minute|Umdrehungen pro Minute",
        "turn/second": "turn/s turns/s|turns per second|revolutions per second"
        "|Umdrehungen pro Sekunde",
    },
    "acceleration": {
        "meter/second**2": "m/s² m/s2 m/s^2",
        "centimeter/second**2": "cm/s² cm/s2 cm/s^2",
    },
    "turning acceleration": {
        "radian/second**2": "rad/s² rad/s2 rad/s^2",
        "degree/second**2": "deg/s² deg/s2 deg/s^2",
    },
    "force": {
        "newton": "N newton newtons",
        "millinewton": "mN millinewton millinewtons",
        "kilonewton": "kN kilonewton kilonewtons",
        "kilogram_force": "kgf kp",
        "pound_force": "lbf",
    },
    "torque": {
        "newton*meter": "Nm N·m N*m|newton metre|newton metres|newton meters",
        "newton*centimeter": "Ncm N·cm",
    },
    "mass": {
        "kilogram": "kg kilo kilos kilogram kilograms Kilogramm",
        "gram": "g gram grams gramme grammes Gramm",
        "milligram": "mg milligram milligrams Milligramm",
        "metric_ton": "t tonne tonnes Tonnen",
        "pound": "lb lbs pound pounds",
        "ounce": "oz ounce ounces",
    },
    "share": {"dimensionless": "", "percent": "% percent pct Prozent|per cent"},
    "frequency": {
        "hertz": "Hz hertz",
        "kilohertz": "kHz kilohertz",
        "megahertz": "MHz megahertz",
    },
    "voltage": {"volt": "V volt volts", "millivolt": "mV millivolt millivolts"},
    "current": {"ampere": "A amp amps ampere amperes", "milliampere": "mA milliamp milliamps"},
    "power": {"watt": "W watt watts", "kilowatt": "kW kilowatt kilowatts"},
    "energy": {"joule": "J joule joules", "watt_hour": "Wh", "kilowatt_hour": "kWh"},
    "pressure": {
        "pascal": "Pa pascal pascals",
        "kilopascal": "kPa kilopascal kilopascals",
        "bar": "bar bars",
    },
    "volume": {
        "meter**3": "m³ m3 m^3",
        "liter": "l L litre litres liter liters",
        "milliliter": "ml mL millilitre millilitres milliliter milliliters",
    },
    "area": {"meter**2": "m² m2 m^2", "centimeter**2": "cm² cm2 cm^2"},
    "temperature": {
        "kelvin": "K kelvin kelvins",
        "degree_Celsius": "°C degC celsius C ℃",
        "degree_Fahrenheit": "°F degF fahrenheit F ℉",
    },
}

# In these spellings the case decides: milli or mega, newton or nano, kelvin or thousand.
_CASE_DECIDES = frozenset({"mm", "ms", "mN", "mV", "mA", "mg", "mrad", "Nm", "Ncm", "MHz", "K"})


class UnitFactors(msgspec.Struct, frozen=True, kw_only=True):
    """The factors that pint gave.

    Attributes:
        pint: Its version.
        asked: Digest of the definitions and names above.
        factors: pint's name of a unit to factor and offset: ``value * factor + offset`` is SI.
    """

    pint: str
    asked: str
    factors: dict[str, tuple[float, float]]


def compile_units() -> UnitTable:
    """Return every unit, by the factors that ship or, where those do not count, by pint's.

    Raises:
        pint.PintError: A list above is wrong; a mistake of ours, as it depends on nothing else.
    """
    factors = (shipped_factors() or ask_pint()).factors
    exact: dict[str, Unit] = {}
    for dimension, units in _UNITS.items():
        for name, spelled in units.items():
            spellings = _spellings(spelled)
            if spellings:
                unit = Unit(spellings[0], dimension, *factors[name])
                exact.update(dict.fromkeys(spellings, unit))
    return UnitTable(exact, _forgiving(exact))


def shipped_factors(path: Path = SHIPPED) -> UnitFactors | None:
    """Return the factors that ship; None if another pint, or one asked otherwise, gave them."""
    try:
        shipped = msgspec.json.decode(path.read_bytes(), type=UnitFactors)
        same = (shipped.pint, shipped.asked) == (version("pint"), digest())
    except (OSError, ValueError, PackageNotFoundError):
        return None
    return shipped if same else None


def ask_pint() -> UnitFactors:
    """Ask pint for the factor of every unit.

    Raises:
        pint.PintError: A list above is wrong.
    """
    import pint  # noqa: PLC0415 - takes a third of a second, and is seldom needed

    registry: pint.UnitRegistry[float] = pint.UnitRegistry(None)
    registry.load_definitions(_DEFINITIONS.split("\n"))
    factors: dict[str, tuple[float, float]] = {}
    for units in _UNITS.values():
        si = next(iter(units))
        for name in units:
            offset = registry.Quantity(0.0, name).to(si).magnitude
            step = f"delta_{name}" if offset else name
            factors[name] = (_tidy(registry.Quantity(1.0, step).to(si).magnitude), offset)
    return UnitFactors(pint=version("pint"), asked=digest(), factors=factors)


def digest(definitions: str = _DEFINITIONS, units: Mapping[str, Iterable[str]] = _UNITS) -> str:
    """Return a digest of everything that decides what pint answers, besides its version."""
    names = [list(names) for names in units.values()]
    return sha256(msgspec.json.encode([definitions, names])).hexdigest()


def _spellings(spelled: str) -> list[str]:
    """Split ``a b|c d e`` into ``a``, ``b`` and the phrase ``c d e``."""
    words, *phrases = spelled.split("|")
    return [*words.split(), *phrases]


def _tidy(factor: float) -> float:
    """Undo what pint's arithmetic added in the last place: a foot is 0.3048 m."""
    short = float(f"{factor:.12g}")
    return short if abs(short - factor) <= 4e-16 * abs(factor) else factor


def _forgiving(exact: dict[str, Unit]) -> dict[str, Unit]:
    forgiving: dict[str, Unit] = {}
    doubtful = {spelling.casefold() for spelling in _CASE_DECIDES}
    for spelling, unit in exact.items():
        folded = spelling.casefold()
        if forgiving.setdefault(folded, unit) != unit:
            doubtful.add(folded)
    return {spelling: unit for spelling, unit in forgiving.items() if spelling not in doubtful}


def main() -> None:
    """Write the file that ships."""
    SHIPPED.write_bytes(msgspec.json.format(msgspec.json.encode(ask_pint())) + b"\n")


if __name__ == "__main__":
    main()
