"""Promised against observed: how often the sites of a drive miss, with an interval by block bootstrap.

Neighbouring sites see the same walls, so what is drawn anew is blocks of route, not sites.
"""

import bisect
import collections
import math
import random

BLOCK_M = 60.0
DRAWS = 2000
TENTHS = 10


def blocks_of(pairs):
    """pairs: (run, s_m, value). The values by blocks of route."""
    blocks = collections.defaultdict(list)
    for run, s_m, value in pairs:
        blocks[(run, math.floor(s_m / BLOCK_M))].append(value)
    return list(blocks.values())


def mean(blocks):
    return sum(map(sum, blocks)) / sum(map(len, blocks))


def interval(places, seed=1, share=0.9):
    """Of the mean over all places, each a list of blocks; blocks are drawn anew within their place."""
    rng = random.Random(seed)
    sums = [[(sum(block), len(block)) for block in blocks] for blocks in places]
    means = []
    for _ in range(DRAWS):
        drawn = [rng.choice(blocks) for blocks in sums for _ in blocks]
        count = sum(n for _, n in drawn)
        means.append(sum(total for total, _ in drawn) / count)
    means.sort()
    at = (1.0 - share) / 2.0 * (DRAWS - 1)
    return means[math.floor(at)], means[math.ceil(DRAWS - 1 - at)]


def tenths(places):
    """places: for each a list of (run, s_m, promised, met). Per tenth of what was promised: its mean, the share that
    met the limit, the interval of their difference, and how many pairs."""
    edges = [i / TENTHS for i in range(1, TENTHS)]
    rows = []
    for tenth in range(TENTHS):
        of_tenth = [[pair for pair in place if bisect.bisect_right(edges, pair[2]) == tenth] for place in places]
        of_tenth = [place for place in of_tenth if place]
        pairs = [pair for place in of_tenth for pair in place]
        if not pairs:
            continue
        promised = sum(pair[2] for pair in pairs) / len(pairs)
        observed = sum(pair[3] for pair in pairs) / len(pairs)
        low, high = interval([blocks_of([(run, s_m, met - p) for run, s_m, p, met in place]) for place in of_tenth])
        rows.append({"promised": promised, "observed": observed, "low": promised + low, "high": promised + high,
                     "pairs": len(pairs), "kept": abs(observed - promised) <= 0.02 or low <= 0.0 <= high})
    return rows


def percent(value):
    return f"{100.0 * value:.1f}"


def misses_table(cases, alpha):
    """cases: (place, drive, statement, [(run, s_m, has_missed)]). A line for each, and one for all."""
    lines = [f"| place | drive | promise of {percent(alpha)} % | missed, % | 90 % interval | promise inside or above |",
             "|---|---|---|---|---|---|"]
    all_blocks, kept, by_drive = [], {}, collections.defaultdict(list)
    for place, drive, is_earned, pairs in cases:
        blocks = blocks_of(pairs)
        if not blocks:
            lines.append(f"| {place} | {drive} | {'earned' if is_earned else 'not earned'} | nothing is answered | - | yes |")
            kept[(place, drive)] = True
            continue
        all_blocks.append(blocks)
        by_drive[drive].append(blocks)
        low, high = interval([blocks])
        kept[(place, drive)] = alpha >= low
        lines.append(f"| {place} | {drive} | {'earned' if is_earned else 'not earned'} | {percent(mean(blocks))}"
                     f" | {percent(low)} to {percent(high)} | {'yes' if alpha >= low else 'NO'} |")
    for name, places in [] if not all_blocks else [*((drive, by_drive[drive]) for drive in sorted(by_drive)), ("all", all_blocks)]:
        low, high = interval(places)
        share = mean([block for place in places for block in place])
        verdict = "kept" if share <= alpha + 0.02 else "MISSED"
        lines.append(f"| all | {name} | at most {percent(alpha + 0.02)} | {percent(share)}"
                     f" | {percent(low)} to {percent(high)} | {verdict} |")
    for drive in sorted(by_drive):
        of_drive = [is_kept for (_, other), is_kept in kept.items() if other == drive]
        lines.append(f"\n{drive}: inside or above in {sum(of_drive)} of {len(of_drive)} places")
    return "\n".join(lines) + "\n"


def curve_table(rows):
    lines = ["| promised, % | observed, % | 90 % interval | pairs of site and range | within 2 points or its interval |",
             "|---|---|---|---|---|"]
    for row in rows:
        lines.append(f"| {percent(row['promised'])} | {percent(row['observed'])} | {percent(row['low'])} to"
                     f" {percent(row['high'])} | {row['pairs']} | {'yes' if row['kept'] else 'NO'} |")
    return "\n".join(lines) + "\n"
