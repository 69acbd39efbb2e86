"""Is each key of a TOML file found in its line, however it is written?"""

import pytest

from softbody.scenes.toml_lines import line_of, lines_of

tomllib = pytest.importorskip("tomllib")

TEXT = '''# a comment
a = 1

b.c = 2
long = [  # of several lines
  1, "]",
  2,
]
text = """
[[no]] = 3
"""
"quoted key" = { x = 1, y = [1, { z = 2 }] }
[table]
[table.inner]
a = 1
[[list]]
a = 1
[[list]]
a = 2
[list.of]
a = 3
[[list.more]]
a = 4
[[list.more]]
a = 5'''


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_every_path_has_its_line(end):
    text = TEXT.replace("\n", end)
    tomllib.loads(text)
    lines = lines_of(text, tomllib.loads)
    for path, line in {
        ("a",): 2,
        ("b", "c"): 4,
        ("long",): 5,
        ("long", 1): 5,
        ("text",): 9,
        ("quoted key", "y", 1, "z"): 12,
        ("table",): 13,
        ("table", "inner"): 14,
        ("table", "inner", "a"): 15,
        ("list", 0): 16,
        ("list", 0, "a"): 17,
        ("list", 1, "a"): 19,
        ("list", 1, "of"): 20,
        ("list", 1, "of", "a"): 21,
        ("list", 1, "more", 0, "a"): 23,
        ("list", 1, "more", 1): 24,
        ("list", 1, "more", 1, "a"): 25,
        ("list", 1, "not", "there"): 18,
        ("nowhere",): 1,
    }.items():
        assert line_of(path, lines) == line, path


def test_a_file_that_would_take_for_ever_has_the_lines_of_its_beginning():
    text = "first = 1\nlong = [\n" + '"a",\n' * 20_000 + "]\nlast = 1\n"
    lines = lines_of(text, tomllib.loads)
    assert lines[("first",)] == 1
    assert ("last",) not in lines
