"""A claim holds only if something was compared, all of it finite, all of it within the tolerance."""

from __future__ import annotations

import dataclasses
import sys

import numpy as np
import pytest

import softbody
from validation.check import DISAGREEMENTS, Check, Comparison, Misprint, NotHereError, Run
from validation.judge import errors_of, judge

RUN = Run("quick", 0, "family.claim")


def make_check(compare, unit="relative", tolerance=1e-9, engines=(), erratum=None) -> Check:
    return Check(
        "family.claim", "family", "A claim.", "1", "piece", "judge", engines, unit, tolerance, "why", compare,
        erratum=erratum,
    )  # fmt: skip


def verdict_of(compare, **options):
    record = judge(make_check(compare, **options), RUN)
    return record.verdict, record


def test_errors_within_the_tolerance_hold():
    verdict, record = verdict_of(lambda run: Comparison([1.0, 2.0], [1.0, 2.0 + 1e-10]))
    assert verdict == "holds"
    assert record.n == 2
    assert record.value == pytest.approx(1e-10, rel=1e-4)
    assert record.errors.zeros == 1


def test_one_error_beyond_the_tolerance_fails():
    verdict, record = verdict_of(lambda run: Comparison([1.0, 2.0], [1.0, 2.1]))
    assert verdict == "fails"
    assert "1 of 2" in record.why
    assert "case 1" in record.why


def test_comparing_nothing_fails():
    verdict, record = verdict_of(lambda run: Comparison([], []))
    assert (verdict, record.why) == ("fails", "compared nothing")


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_fails_on_either_side(bad):
    assert verdict_of(lambda run: Comparison([1.0, bad], [1.0, 1.0]))[0] == "fails"
    assert verdict_of(lambda run: Comparison([1.0, 1.0], [1.0, bad]))[0] == "fails"
    assert verdict_of(lambda run: Comparison([1.0, bad], [1.0, bad]))[0] == "fails"


def test_a_scale_of_zero_fails():
    assert verdict_of(lambda run: Comparison([1.0], [1.0], scale=0.0))[0] == "fails"


def test_a_missing_engine_is_not_run_and_never_a_pass():
    def compare(run):
        import a_package_that_nobody_has  # noqa: F401

    verdict, record = verdict_of(compare, engines=("a_package_that_nobody_has",))
    assert (verdict, record.why) == ("not run", "a_package_that_nobody_has is not installed")


def test_what_cannot_be_on_this_machine_is_not_run_and_says_why():
    def compare(run):
        raise NotHereError("no wheel is built for this processor")

    verdict, record = verdict_of(compare)
    assert (verdict, record.why) == ("not run", "no wheel is built for this processor")
    assert record.value is None


def test_a_missing_module_that_is_no_declared_engine_fails():
    def compare(run):
        import a_package_that_nobody_has  # noqa: F401

    assert verdict_of(compare)[0] == "fails"


def test_an_exception_fails_and_is_named():
    verdict, record = verdict_of(lambda run: 1 / 0)
    assert verdict == "fails"
    assert "ZeroDivisionError" in record.why


def test_disagreements_are_counted():
    options = {"unit": DISAGREEMENTS, "tolerance": 0.0}
    answers = np.array([True, False, True])
    assert verdict_of(lambda run: Comparison(answers, answers.copy()), **options)[0] == "holds"
    verdict, record = verdict_of(lambda run: Comparison(answers, ~answers, groups=["a", "a", "b"]), **options)
    assert (verdict, record.value) == ("fails", 3.0)
    assert [(group.label, group.max) for group in record.groups] == [("a", 2.0), ("b", 1.0)]


def test_answers_of_another_shape_or_kind_are_refused():
    with pytest.raises(ValueError, match="shape"):
        errors_of([1.0, 2.0], [1.0], 1.0)
    with pytest.raises(ValueError, match="yes-or-no"):
        errors_of([True], [1.0], 1.0)


def test_rows_are_compared_by_the_length_of_their_difference():
    assert errors_of([[3.0, 0.0]], [[0.0, 4.0]], 2.0) == pytest.approx([2.5])


def test_an_erratum_fails_if_the_printed_form_is_as_good():
    misprint = Misprint("E1", "wrong", "right")
    good = Comparison([1.0], [1.0], printed=[2.0])
    bad = Comparison([1.0], [1.0], printed=[1.0])
    verdict, record = verdict_of(lambda run: good, erratum=misprint)
    assert verdict == "holds"
    assert record.erratum.printed_value == 1.0
    assert record.erratum.printed_wrong == 1.0
    assert verdict_of(lambda run: bad, erratum=misprint)[0] == "fails"


def test_each_check_has_random_numbers_of_its_own_that_depend_on_the_seed():
    a, b, c = Run("quick", 1, "a"), Run("quick", 1, "b"), Run("quick", 2, "a")
    assert a.fresh_rng().random() == a.fresh_rng().random()
    assert len({a.fresh_rng().random(), b.fresh_rng().random(), c.fresh_rng().random()}) == 3


def test_fewer_cases_than_the_claim_asks_for_fail():
    few = dataclasses.replace(make_check(lambda run: Comparison([1.0, 2.0], [1.0, 2.0])), least=3)
    record = judge(few, Run("quick", 0, "family.claim"))
    assert record.verdict == "fails"
    assert "compared 2 different cases" in record.why


@pytest.mark.parametrize("scale", [0.0, -1.0, np.inf, np.nan, [1.0, -1.0], [1.0, np.inf], [[1.0], [1.0]]])
def test_a_scale_must_be_finite_and_above_0(scale):
    verdict, record = verdict_of(lambda run: Comparison([1.0, 2.0], [1.0, 2.0], scale=scale))
    assert verdict == "fails"
    assert "scale" in record.why


@pytest.mark.parametrize("shape", [(), (2, 0), (2, 2, 2)])
def test_answers_are_numbers_or_rows_of_them(shape):
    verdict, record = verdict_of(lambda run: Comparison(np.ones(shape), np.ones(shape)))
    assert verdict == "fails"
    assert "shape" in record.why


@pytest.mark.parametrize("answers", [np.array([1.0 + 1j]), np.array([None]), np.array(["1"])])
def test_what_is_no_real_number_is_refused(answers):
    verdict, record = verdict_of(lambda run: Comparison(answers, answers.copy()))
    assert verdict == "fails"
    assert "numbers" in record.why


def test_whole_numbers_are_compared_exactly_or_not_at_all():
    large = np.array([2**60, 2**60 + 1])
    assert errors_of(large, large[::-1].copy(), 1.0).tolist() == [1.0, 1.0]
    assert errors_of(large, large.copy(), 1.0).tolist() == [0.0, 0.0]
    with pytest.raises(ValueError, match="no doubles"):
        errors_of(large, large.astype(float), 1.0)


def test_what_is_compared_with_itself_is_refused():
    both = np.ones(4)
    answers = [1.0, 2.0]
    for measured, expected in ((both, both), (both, both[:]), (both[::2], both[:2]), (answers, answers)):
        verdict, record = verdict_of(lambda run, pair=(measured, expected): Comparison(*pair))
        assert verdict == "fails"
        assert "share memory" in record.why
    columns = np.ones((3, 2))
    assert verdict_of(lambda run: Comparison(columns[:, 0], columns[:, 1]))[0] == "holds"


def test_rows_of_yes_or_no_are_one_case_each():
    assert errors_of([[True, False], [True, True]], [[True, True], [True, True]], 1.0).tolist() == [1.0, 0.0]


@pytest.mark.parametrize("printed", [[np.nan, 2.0], [np.inf, 2.0]])
def test_a_printed_form_that_gives_no_number_shows_nothing(printed):
    made = Comparison([1.0, 1.0], [1.0, 1.0], printed=printed)
    verdict, record = verdict_of(lambda run: made, erratum=Misprint("E1", "wrong", "right"))
    assert verdict == "fails"
    assert "printed" in record.why


@pytest.fixture
def engine(tmp_path, monkeypatch):
    """Return a function that installs an engine, a file of Python, and returns its name."""

    def install(text):
        (tmp_path / "some_engine.py").write_text(text)
        monkeypatch.syspath_prepend(tmp_path)
        monkeypatch.delitem(sys.modules, "some_engine", raising=False)
        return ("some_engine",)

    return install


@pytest.mark.parametrize(
    "text", ["raise ImportError('no lib')", "import a_package_that_nobody_has", "def ask():\n    raise KeyError(1)"]
)
def test_an_engine_that_is_installed_and_breaks_is_no_fault_of_the_core(engine, text):
    def compare(run):
        import some_engine

        some_engine.ask()

    verdict, record = verdict_of(compare, engines=engine(text))
    assert verdict == "engine broken"
    assert "some_engine" in record.why


@pytest.mark.parametrize("nonsense", [np.nan, -np.inf, np.array([1.0, np.nan])])
def test_an_engine_that_breaks_on_what_is_no_number_is_not_to_blame(engine, nonsense):
    def compare(run):
        import some_engine

        some_engine.ask_about(nonsense)

    text = "def ask_about(points):\n    raise ValueError('no hull')"
    verdict, record = verdict_of(compare, engines=engine(text))
    assert verdict == "fails"
    assert "some_engine was given points that is not finite" in record.why
    nonsense = 1.0
    assert verdict_of(compare, engines=engine(text))[0] == "engine broken"


def test_a_core_that_raises_is_a_fault_of_the_core_whoever_judges(engine):
    def compare(run):
        softbody.World().add_box((0.0, 0.0, 0.0), 1.0)

    assert verdict_of(compare, engines=engine(""))[0] == "fails"


def test_the_worst_case_is_kept_with_both_answers_and_its_inputs():
    made = Comparison(
        [[1.0, 2.0], [3.0, 4.0]], [[1.0, 2.0], [3.0, 4.5]], [1.0, 2.0], ["a", "b"],
        inputs={"point": [[0.0, 1.0], [2.0, 3.0]], "mesh": ["torus", "sphere"], "vertices": np.zeros((2, 99, 3))},
    )  # fmt: skip
    worst = verdict_of(lambda run: made, tolerance=1.0)[1].worst
    assert (worst.number, worst.error, worst.scale, worst.group) == (1, 0.25, 2.0, "b")
    assert (worst.measured, worst.expected) == ([3.0, 4.0], [3.0, 4.5])
    assert worst.inputs == {"point": [2.0, 3.0], "mesh": "sphere", "vertices": "array of shape (99, 3)"}


def test_of_a_long_answer_the_first_numbers_are_kept_and_its_length():
    worst = verdict_of(lambda run: Comparison(np.ones((1, 500)), np.ones((1, 500))))[1].worst
    assert (len(worst.measured), worst.length) == (100, 500)


def test_inputs_have_a_row_a_case():
    made = Comparison([1.0, 2.0], [1.0, 2.0], inputs={"point": [0.0]})
    verdict, record = verdict_of(lambda run: made)
    assert verdict == "fails"
    assert "inputs['point'] has 1 rows for 2 cases" in record.why


@pytest.mark.parametrize("error", [SystemExit(1), KeyboardInterrupt(), GeneratorExit()])
def test_what_ends_a_process_ends_its_claim_only(error):
    def compare(run):
        raise error

    verdict, record = verdict_of(compare)
    assert verdict == "fails"
    assert type(error).__name__ in record.why


def test_an_engine_s_own_random_numbers_are_the_same_every_time():
    def compare(run):
        return Comparison(np.random.random(5), np.zeros(5), 1e9)

    assert verdict_of(compare)[1].value == verdict_of(compare)[1].value


@pytest.mark.parametrize("scale", [1e300, 1e13, 1e-19, [1.0, 1e99]])
def test_a_scale_of_a_size_that_no_answer_has_fails(scale):
    verdict, record = verdict_of(lambda run: Comparison([1.0, 2.0], [5.0, 6.0], scale=scale))
    assert verdict == "fails"
    assert "no answer is of that size" in record.why


class _Handed:
    """Hands over an array as something else."""

    def __init__(self, array: np.ndarray) -> None:
        self._array = array

    def __array__(self, *_: object, **__: object) -> np.ndarray:
        return self._array.copy()


@pytest.mark.parametrize("how", [list, np.ndarray.tolist, _Handed])
def test_what_is_compared_with_itself_by_way_of_no_array_fails(how):
    answers = np.array([0.1, 0.7, 3.3])
    verdict, record = verdict_of(lambda run: Comparison(answers, how(answers)))
    assert verdict == "fails"
    assert "the same to the last bit" in record.why
    assert verdict_of(lambda run: Comparison(how(answers), answers + 1e-17 * np.arange(3)))[0] == "fails"
    assert verdict_of(lambda run: Comparison(answers, answers.copy()))[0] == "holds"


@pytest.mark.parametrize("real", [np.float16, np.float32, np.longdouble])
def test_answers_are_doubles(real):
    """Half of their digits would agree by themselves, and more of them JSON does not hold."""
    verdict, record = verdict_of(lambda run: Comparison(np.ones(3, real), np.ones(3, real)))
    assert verdict == "fails"
    assert "doubles" in record.why


def test_a_case_that_is_told_many_times_is_one():
    tiled = Comparison(np.tile([0.3, 0.7], 50), np.tile([0.3, 0.7], 50) + 1e-17)
    several = dataclasses.replace(make_check(lambda run: tiled), least=3)
    record = judge(several, RUN)
    assert (record.verdict, record.n) == ("fails", 2)
    asked = dataclasses.replace(tiled, inputs={"at": np.arange(100.0)})
    assert judge(dataclasses.replace(make_check(lambda run: asked), least=3), RUN).n == 100
    kinds = dataclasses.replace(tiled, groups=["one", "one", "two", "two"] * 25)
    assert judge(make_check(lambda run: kinds), RUN).n == 4
    zeros = Comparison(np.zeros(100), np.zeros(100))
    assert judge(make_check(lambda run: zeros), RUN).n == 100


def test_disagreements_are_whole():
    answers = np.array([0.0, 1.0, 1.0])
    verdict, record = verdict_of(
        lambda run: Comparison(answers, np.array([0.0, 1.0, 0.6])), unit="disagreements", tolerance=0.0
    )
    assert (verdict, record.value) == ("fails", 1.0)


def test_a_claim_that_changes_what_it_was_declared_as_fails():
    def compare(run):
        object.__setattr__(claim, "tolerance", 1e9)
        return Comparison([1.0, 2.0], [5.0, 6.0])

    claim = make_check(compare)
    record = judge(claim, RUN)
    assert record.verdict == "fails"
    assert record.tolerance < 1.0
    assert "has changed what it was declared as" in record.why
