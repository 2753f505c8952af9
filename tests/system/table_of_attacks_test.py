"""Each test that a table of attacks names is there.

usage: table_of_attacks_test.py ROOT_OF_THE_SOURCES
"""

import pathlib
import re
import sys
import unittest

TABLES = ("schemas/release_format.md", "tests/system/attacks.md")


def names_in(text):
    """Of tests in Python, and of GoogleTest with or without their suite; of the rows of tables alone."""
    rows = "\n".join(line for line in text.split("\n") if line.startswith("|"))
    words = re.findall(r"`([A-Za-z0-9_.]+)`", rows)
    return [word for word in words if word.startswith("test_") or re.fullmatch(r"(\w+\.)?[A-Z]\w+", word)]


class Tables(unittest.TestCase):
    def test_each_test_that_is_named_is_there(self):
        files = [path for ending in ("cpp", "py") for path in (ROOT / "tests").rglob(f"*.{ending}")]
        text = "\n".join(path.read_text(errors="replace") for path in files)
        for table in TABLES:
            names = names_in((ROOT / table).read_text())
            self.assertGreater(len(names), 20, table)
            for name in names:
                suite, _, test = name.rpartition(".")
                wanted = f"({suite}, {test})" if suite else f"def {test}(" if test.startswith("test_") else f" {test}"
                self.assertTrue(wanted in text, f"{table} names {name}, which is no test")


if __name__ == "__main__":
    ROOT = pathlib.Path(sys.argv[1])
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
