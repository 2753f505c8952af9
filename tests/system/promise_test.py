"""tests/bench/promise judges generated towns and plain folders of recordings alike.

usage: promise_test.py PROMISE BUILD WORK
"""

import json
import pathlib
import shutil
import subprocess
import sys

# Towns as small as the model allows: this shows that the table is made, not what is in it.
QUICK = ["annotation.ranges_m=[10, 20, 40]", "measure-error.offset_count=3", "train-model.trees=20",
         "train-model.block_m=25", "train-model.buffer_m=5"]
SEEDS = ["1", "2", "3"]


def judge(promise, build, work, places):
    result = work / "result.json"
    table = subprocess.run(
        [promise, *places, "--build", build, "--work", work, "--json", result,
         *[part for value in QUICK for part in ("--set", value)]],
        check=True, capture_output=True, text=True).stdout
    return table, json.loads(result.read_text())


def without_times(figures):
    return [{rule: {key: value for key, value in score.items() if "time" not in key}
             for rule, score in figure["scores"].items()} for figure in figures]


def main(promise, build, work):
    work = pathlib.Path(work)
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    table, figures = judge(promise, build, work, ["--seeds", *SEEDS, "--length-m", "100"])
    rules, *promised = table.split("\n## ")
    assert rules.count("\n") == 7, rules  # two lines of heading, five targets
    assert len(promised) == 3 * 2, table  # rules that name alpha, limits
    for text in promised:
        drives = 1 if text.startswith("history") else 2
        assert text.count("| town-") == 3 * drives, text
        assert "not earned" in text and "| earned" not in text, "300 m earn nothing\n" + text
        assert "promised, %" in text
    assert len(figures) == 3 * 4 * 2, len(figures)  # places, rules, limits
    for figure in figures:
        scores = figure["scores"]
        best = scores["oracle"]["coverage"]
        for rule, score in scores.items():
            assert 0.0 <= score["coverage"] <= best + 1e-12, (rule, score)
            assert 0.0 < score["work_ratio"] <= 1.0 + 1e-12, (rule, score)
        assert scores["static-longest"]["work_ratio"] == 1.0
    # The same recordings, as anyone may bring them, with a configuration made for them.
    folders = [work / f"town-{seed}-100" for seed in SEEDS]
    for folder in folders:
        (folder / "place.yaml").unlink()
    _, again = judge(promise, build, work, ["--folders", *folders, "--reference", "known"])
    assert without_times(again) == without_times(figures)


if __name__ == "__main__":
    main(*sys.argv[1:])
