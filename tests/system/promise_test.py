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
LOOKS = ["100 m, 650 returns, 40 points by normals", "100 m, 1944 returns, 80 points"]
QUICK.append(f"annotation.looks={'; '.join(LOOKS)}")
SEEDS = ["1", "2", "3"]
RULES = ["paper", "map-10", "map-5", "history-5"]


def judge(promise, build, work, places):
    result = work / "result.json"
    table = subprocess.run(
        [promise, *places, "--build", build, "--work", work, "--json", result, "--rules", *RULES,
         "--look-bench", work / "look_bench.txt",
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
    # As look_bench prints them, one of a thousandth of static 50 m's time and one of two.
    (work / "look_bench.txt").write_text("".join(
        f" 99.1 ( 97.2)   99.3 ( 97.5)  2.1 cm    {40 * i}    9.1  0.03{i}  0.00{i}  0.02{i}  {look}\n"
        for i, look in enumerate(LOOKS, 1)))
    table, figures = judge(promise, build, work, ["--seeds", *SEEDS, "--length-m", "70"])
    tables, *promised = table.split("\n## ")
    rules, looks, answered, driving = tables.strip().split("\n\n")
    assert len(rules.splitlines()) == 7, rules  # two lines of heading, five targets
    assert len(looks.splitlines()) == 3, looks  # the one target of these rules
    assert 0.001 <= float(looks.splitlines()[2].split(" | ")[3]) <= 0.002, looks
    assert len(answered.splitlines()) == 2 + 2 * 2 * len(RULES), answered  # limits, ranges and looks
    assert len(driving.splitlines()) == 2 + 3 * len(RULES), driving  # by range, look and plan
    assert len(promised) == 3 * 2, table  # rules that name alpha, limits
    for text in promised:
        drives = 1 if text.startswith("history") else 2
        assert text.count("| town-") == 3 * drives, text
        assert "not earned" in text and "| earned" not in text, "210 m earn nothing\n" + text
        assert "promised, %" in text
    assert len(figures) == 3 * 4 * 2, len(figures)  # places, rules, limits
    for figure in figures:
        scores = figure["scores"]
        best = scores["oracle"]["coverage"]
        for rule, score in scores.items():
            assert 0.0 <= score["coverage"] <= best + 1e-12, (rule, score)
            assert 0.0 < score["work_ratio"] <= 1.0 + 1e-12, (rule, score)
        assert scores["static-longest"]["work_ratio"] == 1.0
        assert figure["looks"]["map"]["coverage"] <= figure["looks"]["oracle"]["coverage"] + 1e-12
        assert set(figure["look_counts"]) <= set(LOOKS), figure["look_counts"]
    # The same recordings, as anyone may bring them, with a configuration made for them.
    folders = [work / f"town-{seed}-70" for seed in SEEDS]
    for folder in folders:
        (folder / "place.yaml").unlink()
    _, again = judge(promise, build, work, ["--folders", *folders, "--reference", "known"])
    assert without_times(again) == without_times(figures)


if __name__ == "__main__":
    main(*sys.argv[1:])
