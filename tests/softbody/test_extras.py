"""A library that is missing is named, with the command that installs it."""

import math

import pytest

from softbody import MissingPackageError
from softbody.extras import library


def test_a_library_that_is_there_is_returned():
    assert library("math", "math", "sums", "a sum") is math


def test_one_that_is_missing_is_an_import_error_with_its_cure():
    with pytest.raises(MissingPackageError, match=r"a film needs Films: pip install softbody\[record\]") as caught:
        library("no_such_module", "Films", "record", "a film")
    assert isinstance(caught.value, ImportError)
