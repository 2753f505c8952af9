#!/usr/bin/env python3
"""tests/support/check_prose measures what it says it measures, and each limit can fail."""
import importlib.machinery
import importlib.util
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
LOADER = importlib.machinery.SourceFileLoader("check_prose", str(pathlib.Path(__file__).resolve().parent / "check_prose"))
check_prose = importlib.util.module_from_spec(importlib.util.spec_from_loader("check_prose", LOADER))
LOADER.exec_module(check_prose)


class Prose(unittest.TestCase):
    def test_syllables(self):
        expected = {"range": 1, "table": 2, "needed": 2, "used": 1, "places": 2, "sites": 1, "matches": 2, "vehicle": 3,
                    "the": 1, "map's": 1, "self-driving": 3, "observation": 4, "12.5": 1}
        self.assertEqual({word: check_prose.syllables_of(word) for word in expected}, expected)

    def test_reading_ease_is_flesch_s(self):
        sentences = check_prose.sentences_of("The car has a map. It reads the table.")
        self.assertEqual([len(sentence) for sentence in sentences], [5, 4])
        # 9 words, 2 sentences, 10 syllables.
        self.assertAlmostEqual(check_prose.reading_ease(sentences), 206.835 - 1.015 * 9 / 2 - 84.6 * 10 / 9)

    def test_code_tables_pictures_and_targets_are_left_out(self):
        text = "# A heading\n\n```sh\nsome code here\n```\n\n| a | b |\n|---|---|\n\n![picture](a.svg)\n\nSee [this page](a/b.md), [that][ref] `x y`.\n\n[ref]: a/long/way.md"
        self.assertEqual(check_prose.sentences_of(check_prose.prose_of(text)), [["See", "this", "page", "that"]])

    def test_items_of_a_list_are_sentences(self):
        self.assertEqual(len(check_prose.sentences_of(check_prose.prose_of("- one page\n- two pages\n1. three"))), 3)

    def test_each_limit_can_fail(self):
        self.assertEqual(check_prose.faults_of("The car has a map.\n"), [])
        self.assertIn("101 lines", check_prose.faults_of("A map.\n" * 101)[0])
        self.assertIn("121 columns", check_prose.faults_of("A map. " * 17 + "go")[0])
        self.assertEqual(check_prose.faults_of("```\n" + "x" * 130 + "\n```\nA map.\n"), [])
        self.assertIn("a cell of 61", check_prose.faults_of("A map.\n\n| a | " + "b" * 61 + " |\n")[0])
        self.assertIn("31 words", check_prose.faults_of("\n".join(["map"] * 31) + "\n")[0])
        self.assertIn("reading ease", check_prose.faults_of("Probabilistic localization necessitates observation.\n")[0])


if __name__ == "__main__":
    unittest.main()
