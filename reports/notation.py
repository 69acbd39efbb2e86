"""Notation of numbers for readers: powers of ten, grouped digits, durations, dates; never an `e-15`."""

from __future__ import annotations

import math
import re
from datetime import datetime

DASH = "—"
NOT_A_NUMBER = "not a number"  # JSON has neither NaN nor infinity: the record holds null for both
NO_BREAK, THIN = "\u00a0", "\u202f"
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def power_of_ten(exponent: int) -> str:
    """Return 10 to a whole power, such as `10⁻¹⁵`, and `1` for the power 0."""
    return "1" if exponent == 0 else "10" + str(exponent).translate(SUPERSCRIPT)


def count(value: float) -> str:
    """Return a whole number with its digits in groups of three, such as `20 000`."""
    text = f"{value:.0f}"
    return f"{value:,.0f}".replace(",", THIN).replace("-", "−") if len(text.lstrip("-")) > 4 else text.replace("-", "−")


def number(value: float | None, digits: int = 3) -> str:
    """Return a number to so many significant digits, such as `0.125` or `3.1 × 10⁻¹⁵`; `∞` for one that overflowed."""
    if value is None or math.isnan(value):
        return NOT_A_NUMBER
    if math.isinf(value):
        return "∞" if value > 0.0 else "−∞"
    if value == int(value) and abs(value) < 1e6:
        return count(value)
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    power = int(exponent)
    if -3 <= power < digits:
        return _trimmed(f"{value:.{digits - 1 - power}f}")
    if digits <= power < 6:
        return count(round(value))
    factor = _trimmed(mantissa)
    return power_of_ten(power) if factor == "1" else f"{factor}{NO_BREAK}×{NO_BREAK}{power_of_ten(power)}"


def faster(ratio: float) -> str:
    """Return how much faster, or slower, something is whose speed is so many times another's: `1.25 × faster`."""
    if ratio == 1.0:
        return "as fast"
    times, word = (ratio, "faster") if ratio > 1.0 else (math.inf if ratio == 0.0 else 1.0 / ratio, "slower")
    return f"{number(times)}{NO_BREAK}×{NO_BREAK}{word}"


def number_beside(value: float | None, other: float | None) -> str:
    """Return `value` with as many digits as it takes not to look the same as an `other` that differs."""
    if value is None or other is None or value == other:
        return number(value)
    return next((number(value, d) for d in range(3, 17) if number(value, d) != number(other, d)), number(value, 17))


def percent(share: float | None) -> str:
    """Return a share of 1 in percent; one that is neither none nor all never reads as `0 %` or `100 %`."""
    if share is None:
        return NOT_A_NUMBER
    if 0.0 < share < 0.001:
        return f"<{THIN}0.1{THIN}%"
    if 0.999 < share < 1.0:
        return f">{THIN}99.9{THIN}%"
    return f"{_trimmed(f'{100.0 * share:.1f}')}{THIN}%"


def duration(seconds: float | None) -> str:
    """Return a duration, such as `0.42 s`, `2 min 31 s` or `1 h 4 min`."""
    if seconds is None:
        return NOT_A_NUMBER
    if seconds < 59.5:
        return f"{seconds:.2f}{THIN}s" if seconds < 9.95 else f"{seconds:.0f}{THIN}s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes}{THIN}min {rest}{THIN}s"
    return f"{minutes // 60}{THIN}h {minutes % 60}{THIN}min"


def date(iso: str) -> str:
    """Return an ISO 8601 time as `21 November 2025, 06:44 UTC`; anything else as it stands."""
    try:
        when = datetime.fromisoformat(iso.replace("Z", "+00:00"))
    except ValueError:
        return iso
    zone = when.tzname() or ""
    return f"{when.day} {MONTHS[when.month - 1]} {when.year}, {when:%H:%M} {zone}".rstrip()


# Not strftime's %B: that one speaks the language of the machine.
MONTHS = (
    "January", "February", "March", "April", "May", "June",
    "July", "August", "September", "October", "November", "December",
)  # fmt: skip


def prose(text: str | None) -> str:
    """Return a text whose numbers such as `4e-12` or `1e-5` read `4 × 10⁻¹²` and `10⁻⁵`."""
    return EXPONENT.sub(lambda found: _power(found["factor"], int(found["power"])), text or "")


EXPONENT = re.compile(r"(?<![\w.])(?P<factor>\d+(?:\.\d+)?)e(?P<power>[+-]?\d+)(?![\w.]*\w)")


def _power(factor: str, power: int) -> str:
    ten = power_of_ten(power)
    return ten if factor == "1" else f"{factor}{NO_BREAK}×{NO_BREAK}{ten}"


def section(name: str) -> str:
    """Return a section of the paper with its sign, such as `§5.1`, or several, such as `§§3, 4.4`."""
    sign = "§§" if "," in name else "§"
    return f"{sign}{name}" if name[:1].isdigit() else name


def _trimmed(text: str) -> str:
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return text.replace("-", "−")
