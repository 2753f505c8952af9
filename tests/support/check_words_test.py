#!/usr/bin/env python3
"""tests/support/check_words finds the dialect in what users read and in names, and leaves standard English alone."""
import importlib.machinery
import importlib.util
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
LOADER = importlib.machinery.SourceFileLoader("check_words", str(HERE / "check_words"))
check_words = importlib.util.module_from_spec(importlib.util.spec_from_loader("check_words", LOADER))
LOADER.exec_module(check_words)
user_texts = check_words.user_texts

NAMES, TEXTS, ALLOWED = check_words.read_list((HERE / "words.txt").read_text(encoding="utf-8"))

# Sentences that newcomers did not understand.
SENTENCES = [
    "nothing is promised",
    "the model explains nothing out of fold (R^2 -0.29)",
    "the model explains nothing out of fold (R^2 -0.29); everywhere it takes 15 m, where",
    "one look at all 601 sites",
    "the map's costs the same",
    "nothing is promised: one drive alone was measured, and 10 blocks of 60 m cannot earn 5 %, 19 can, 0.6 km more of measured "
    "route, by drives that the trees do not learn from; the threshold fits what was seen instead: 4.83 % missed out of fold in "
    "10 blocks of 1 place, 1 drive",
    "10 blocks of 60 m cannot earn 5 %",
    "by drives that the trees do not learn from",
    "the threshold fits what was seen instead",
    "4.83 % missed out of fold in 10 blocks of 1 place, 1 drive",
    "Not reached",
    "some minutes",
    "known are",
    "even beyond 30 m",
    "what stands",
    "told",
    "asked",
    "nobody",
    "what was parked on one day goes",
    "there the map may have its walls twice",
    "`--dry-run` tells what a compile would take",
    "several drives are one, part by part",
    "whoever judges hears them in turn",
    "when a vehicle that tracks looks again",
    "judged on 3 blocks of 18 m, whose figures flatter",
    "lie in no valid ND and tell nothing of the pose",
    "one drive told twice is no second witness",
    "the direction that the match holds least",
    "promise it with confidence 1 - delta rather than on average",
    "who has a map whole may hand it over where one in tiles is taken",
    "a pass that is not known here is our own mistake",
    "beside each stands the probability that it does",
]

OLD_NAMES = ["told_of", "hear_drives", "HeardAnswer", "Witnesses", "AtRest<X>", "of_samples", "Asked", "with_turns_that_pay",
             "trial_that_pays", "foretold_pose", "let_go_of_wholes", "bool stays", "bool waits", "tell_pieces", "alike_places",
             "tied_pieces", "lay_onto", "lay_aside", "laid_places"]

STANDARD = [
    "Cars that are present on only one day are removed.",
    "Cross-validated R^2 is -0.29, so one range is used for the whole map: 15 m.",
    "No promise yet: it needs 1.2 km of route measured by drives that the model was not trained on.",
    "The same recording is listed twice.",
    "Points outside valid cells are ignored. There is no scan at 3.2 s.",
    "NDT stands for normal distributions transform. The vehicle stands still.",
    "Returns evenly spaced beyond 30 m are used; the least constrained direction is across the road.",
    "Evaluation alternates between the drives. Matching takes 2.1 ms.",
]


def findings(name, text):
    masked = check_words.without_allowed(user_texts.masked(name, text).lower(), ALLOWED)
    return [row.expression for row in TEXTS if row.pattern.search(masked)]


class TextsThatUsersRead(unittest.TestCase):
    def test_every_sentence_of_the_old_dialect_is_found(self):
        for sentence in SENTENCES:
            self.assertTrue(findings("README.md", sentence), sentence)
            if " " in sentence:
                self.assertTrue(findings("compiler/a.cpp", f'print("{sentence}");'), sentence)

    def test_standard_english_is_not_found(self):
        for sentence in STANDARD:
            self.assertEqual(findings("README.md", sentence), [], sentence)

    def test_a_phrase_is_found_across_lines_and_literals(self):
        self.assertTrue(findings("README.md", "nothing is\npromised"))
        self.assertTrue(findings("passes/a.cpp", 'f("so nothing is "\n  "promised");'))
        self.assertTrue(findings("passes/a.cpp", 'f("a:\\nnothing is promised");'))
        self.assertTrue(findings("passes/a.cpp", 'f(R"(nothing is\npromised)");'))

    def test_comments_names_and_includes_of_a_source_are_not_texts(self):
        for source in ("// nothing is promised\n", "/* who has told */", '#include "told of.h"\n', 'key("told");', "char c = '\"'; // told"):
            self.assertEqual(findings("passes/a.cpp", source), [], source)

    def test_scripts_of_the_page_and_python_are_read(self):
        self.assertTrue(findings("compiler/views/report/page/a.js", "show(`of ${n} nobody knows`); // told"))
        self.assertEqual(findings("compiler/views/report/page/a.js", "x = 1; // nobody knows"), [])
        self.assertTrue(findings("formats/reader/python/sightline/a.py", 'def f():\n    """What the map was told."""'))
        self.assertEqual(findings("formats/reader/python/sightline/a.py", "x = 1  # what was told"), [])

    def test_descriptions_of_a_schema_are_read_and_its_keys_are_not(self):
        self.assertTrue(findings("schemas/a.schema.json", '{"description": "what it was told"}'))
        self.assertEqual(findings("schemas/a.schema.json", '{"told of": {"description": "inputs"}}'), [])

    def test_code_and_links_of_a_document_are_names(self):
        self.assertEqual(findings("examples/a.md", "see `told_of x` and [inputs](a.md#what-is-told)"), [])
        self.assertTrue(findings("examples/a.md", "```sh\nx   # what it was told\n```"))

    def test_what_users_read(self):
        for name in ("README.md", "examples/ci/README.md", "tests/bench/README.md", "tests/golden/help/compile.txt",
                     ".github/SECURITY.md", "schemas/config.schema.json", "compiler/a/b.h", "examples/town/run"):
            self.assertTrue(user_texts.is_read(name), name)
        for name in ("tests/compiler/a_test.cpp", "tests/golden/town/a.txt", "tests/bench/run"):
            self.assertFalse(user_texts.is_read(name), name)


class NamesAndComments(unittest.TestCase):
    def test_every_old_name_is_found(self):
        for name in OLD_NAMES:
            words = check_words.words_of(f"{name};")
            self.assertTrue([row for row in NAMES if row.pattern.search(words)], name)

    def test_a_use_too_many_is_a_fault_and_one_too_few(self):
        row = check_words.Row(1, "told", 1, "reports")
        self.assertEqual(len(check_words.faults_of([row], [("a", "told\ntold")], True)), 3)
        self.assertEqual(check_words.faults_of([row], [("a", "told")], True), [])
        self.assertEqual(len(check_words.faults_of([row], [("a", "")], True)), 1)
        self.assertEqual(check_words.faults_of([row], [("a", "")], False), [])


if __name__ == "__main__":
    unittest.main()
