"""What tests/bench/promised.py makes of misses and probabilities that are known.

usage: promised_test.py FOLDER_OF_PROMISED
"""

import random
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, sys.argv[1])
import promised  # noqa: E402


def cuts_blocks_within_a_run():
    blocks = promised.blocks_of([(run, s_m, 0) for run in (0, 1) for s_m in range(130)])
    assert sorted(map(len, blocks)) == [10, 10, 60, 60, 60, 60], blocks


def knows_no_spread_where_blocks_are_alike():
    low, high = promised.interval([promised.blocks_of([(0, s_m, int(s_m % 20 == 0)) for s_m in range(600)])])
    assert abs(low - 0.05) < 1e-12 and abs(high - 0.05) < 1e-12, (low, high)


def covers_the_truth_as_often_as_it_says():
    """30 blocks that miss by a share of their own, 0.2 on average."""
    rng = random.Random(3)
    promised.DRAWS = 200
    covered = 0
    for _ in range(100):
        blocks = []
        for _ in range(30):
            share = rng.uniform(0.0, 0.4)
            blocks.append([int(rng.random() < share) for _ in range(20)])
        low, high = promised.interval([blocks], seed=rng.random())
        covered += low <= 0.2 <= high
    assert 80 <= covered <= 97, covered


def believes_honest_probabilities_and_no_others():
    rng = random.Random(4)
    honest = [(0, s_m, p, int(rng.random() < p)) for s_m in range(6000) for p in [rng.random()]]
    assert sum(not row["kept"] for row in promised.tenths([honest])) <= 2
    boastful = [(run, s_m, p, int(rng.random() < p - 0.2)) for run, s_m, p, _ in honest]
    assert sum(not row["kept"] for row in promised.tenths([boastful])) >= 7


def names_the_place_that_misses_more_than_was_promised():
    few = [(0, s_m, 0) for s_m in range(600)]
    many = [(0, s_m, int(s_m % 5 == 0)) for s_m in range(600)]
    table = promised.misses_table([("few", "first", True, few), ("many", "first", True, many)], 0.05)
    assert "| few | first | earned | 0.0 | 0.0 to 0.0 | yes |" in table, table
    assert "| many | first | earned | 20.0 | 20.0 to 20.0 | NO |" in table, table
    assert "| all | all | at most 7.0 | 10.0" in table and "MISSED" in table, table
    assert "inside or above in 1 of 2 places" in table, table


cuts_blocks_within_a_run()
knows_no_spread_where_blocks_are_alike()
covers_the_truth_as_often_as_it_says()
believes_honest_probabilities_and_no_others()
names_the_place_that_misses_more_than_was_promised()
