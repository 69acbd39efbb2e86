"""Is a number written as a reader expects it?"""

import pytest

from reports.notation import count, date, duration, number, number_beside, percent, prose, section


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (3.14159e-15, "3.14 × 10⁻¹⁵"),
        (1e-12, "10⁻¹²"),
        (-2.5e-7, "−2.5 × 10⁻⁷"),
        (9.999e-5, "10⁻⁴"),
        (0.0123, "0.0123"),
        (0.0, "0"),
        (4.097, "4.1"),
        (862.4, "862"),
        (999.9, "1000"),
        (20_000.0, "20\u202f000"),
        (5352.3, "5352"),
        (2.4e12, "2.4 × 10¹²"),
        (1e300, "10³⁰⁰"),
        (5e-324, "4.94 × 10⁻³²⁴"),
        (None, "not a number"),
    ],
)
def test_a_number_is_written_with_powers_of_ten(value, text):
    assert number(value).replace("\u00a0", " ") == text


def test_a_value_just_above_its_tolerance_does_not_look_the_same():
    assert number_beside(1.0004e-12, 1e-12).replace("\u00a0", " ") == "1.0004 × 10⁻¹²"
    assert number_beside(1e-12, 1e-12) == "10⁻¹²"


def test_a_share_that_is_neither_none_nor_all_never_reads_so():
    assert percent(0.0) == "0\u202f%"
    assert percent(1e-6) == "<\u202f0.1\u202f%"
    assert percent(0.107) == "10.7\u202f%"
    assert percent(0.99999) == ">\u202f99.9\u202f%"
    assert percent(1.0) == "100\u202f%"
    assert percent(None) == "not a number"


def test_durations_and_dates_are_words():
    assert [duration(s).replace("\u202f", " ") for s in (0.42, 12.3, 59.9, 151.4, 3840.0, None)] == [
        "0.42 s",
        "12 s",
        "1 min 0 s",
        "2 min 31 s",
        "1 h 4 min",
        "not a number",
    ]
    assert date("2025-11-21T06:44:10+00:00") == "21 November 2025, 06:44 UTC"
    assert date("2025-11-21T06:44:10Z") == "21 November 2025, 06:44 UTC"
    assert date("yesterday") == "yesterday"


def test_digits_are_grouped_from_five_on():
    assert [count(n) for n in (642, 2562, 163842)] == ["642", "2562", "163\u202f842"]


def test_a_section_gets_its_sign_once():
    assert [section(s) for s in ("5.1", "3, 4.4", "§5.1", "none", "")] == ["§5.1", "§§3, 4.4", "§5.1", "none", ""]


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("rounds at 1e-16 each", "rounds at 10⁻¹⁶ each"),
        ("up to 4e-12, then 2.5e3", "up to 4 × 10⁻¹², then 2.5 × 10³"),
        ("one e5, E5, file1e5x and 0x1e5", "one e5, E5, file1e5x and 0x1e5"),
        ("1e-3 … 1e-13", "10⁻³ … 10⁻¹³"),
    ],
)
def test_prose_writes_exponents_as_powers_of_ten(text, shown):
    assert prose(text).replace("\u00a0", " ") == shown


def test_a_ratio_that_overflows_is_written_too():
    assert number(1e300 / 1e-300) == "∞"
    assert number(-1e300 / 1e-300) == "−∞"
    assert number(float("nan")) == "not a number"
