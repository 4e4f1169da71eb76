"""Many problems, several planners: how much shorter, how fast, how true.

    pip install ./ipc/python -r examples/planners/requirements-ompl.txt -r examples/planners/requirements-hpp.txt
    taut serve &
    python examples/planners/compare.py config/problems --queries 5 --planner ompl --planner hpp
    python examples/planners/compare.py FOLDER --planner hpp -o table.json

FOLDER is searched for taut-problem/1 files. Query 0 is a file's own start and goal, the others are
sampled: free ends that no free straight line joins.
"""

import argparse
import importlib
import json
import statistics
import sys
from pathlib import Path

import taut

from comparison import NoPath, compare, connection, options
from problem import Problem, Refused

PLANNERS = {"ompl": "ompl_planner", "hpp": "hpp_planner", "vamp": "vamp_planner"}
SAME = 1e-3  # lengths nearer than a thousandth are as short
HEAD = ("problem", "query", "planner", "before", "own", "own ms", "own is", "taut", "taut ms", "passed ms", "taut is")


def cells(row, query):
    """One line of the table."""
    start = [row.problem, query, row.planner, f"{row.before:.3f}", f"{row.own:.3f}", f"{row.own_s * 1e3:.1f}"]
    start.append(f"COLLIDES {row.own_hits}" if row.own_hits else "free")
    if row.refused:
        return start + ["-", "-", "-", f"refused: {row.refused}"]
    passed = "-" if row.passed_own_s is None else f"{row.passed_own_s * 1e3:.1f}"
    proof = f"proved, {row.clearance * 1e3:.1f} mm" if row.proved else "NOT PROVED"
    if row.taut_hits:
        proof += f", but coal: {row.taut_hits}"
    return start + [f"{row.taut:.3f}", f"{row.taut_s * 1e3:.1f}", passed, proof]


def summary(name, rows):
    """What the rows of one planner come to."""
    done = [row for row in rows if not row.refused]
    if not done:
        return f"{name}: no path that taut took, of {len(rows)}"
    shorter = sum(row.taut < row.own * (1 - SAME) for row in done)
    longer = sum(row.taut > row.own * (1 + SAME) for row in done)
    figures = {
        "remaining length, own": [row.own / row.before for row in done],
        "taut": [row.taut / row.before for row in done],
        "time, own": [row.own_s * 1e3 for row in done],
    }
    medians = ", ".join(f"{what} {statistics.median(values):.3g}" for what, values in figures.items())
    times = statistics.median(row.taut_s * 1e3 for row in done)
    return (
        f"{name}: {len(done)} paths, taut shorter on {shorter}, as short on {len(done) - shorter - longer}, "
        f"longer on {longer}; proved {sum(row.proved for row in done)}, contradicted by coal "
        f"{sum(bool(row.taut_hits) for row in done)}; own answers that collide {sum(bool(row.own_hits) for row in done)}; "
        f"medians: {medians} ms, taut {times:.3g} ms; planner's own path refused {len(rows) - len(done)}"
    )


def files(folders):
    """The problem files below some folders, in order; a file is taken as it is."""
    found = []
    for folder in map(Path, folders):
        found += [folder] if folder.is_file() else sorted(folder.rglob("*.json"))
    if not found:
        raise SystemExit(f"no problem file in {', '.join(folders)}; give a folder such as config/problems")
    return found


def main():
    """Plans, compares, prints."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", help="folders of taut-problem/1 files, or such files")
    parser.add_argument("--planner", action="append", choices=list(PLANNERS), help="may be repeated; default: ompl, hpp")
    parser.add_argument("--queries", type=int, default=1, help="for each problem")
    parser.add_argument("-o", "--output", help="all rows, as JSON")
    options(parser)
    given = parser.parse_args()
    if given.queries < 1:
        parser.error(f"--queries is {given.queries}; at least 1")
    planners = {name: importlib.import_module(PLANNERS[name]) for name in given.planner or ["ompl", "hpp"]}
    rows, records = {name: [] for name in planners}, []
    print("| " + " | ".join(HEAD) + " |\n|" + "---|" * len(HEAD))
    with connection(given) as daemon:
        for file in files(given.folders):
            for query in range(given.queries):
                for name, planner in planners.items():
                    try:
                        problem = Problem(file, spheres=planner.SPHERES)
                        planned = planner.plan(problem, *problem.query(query), given)
                        row = compare(problem, planner, planned, daemon, given)
                    except (Refused, NoPath) as error:
                        print(f"{name}: query {query}: {error}", file=sys.stderr)
                        continue
                    rows[name].append(row)
                    records.append({"query": query, **row.record()})
                    print("| " + " | ".join(map(str, cells(row, query))) + " |", flush=True)
    print()
    for name, found in rows.items():
        print(summary(name, found))
    if given.output:
        Path(given.output).write_text(json.dumps(records, indent=1) + "\n")
    if any(row.taut_hits or not (row.proved or row.refused) for found in rows.values() for row in found):
        raise SystemExit(1)


if __name__ == "__main__":
    try:
        main()
    except taut.Error as error:
        raise SystemExit(f"taut: {error}") from None
