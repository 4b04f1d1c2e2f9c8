#!/usr/bin/env python3
"""CPU time of our benchmarks beside that of the tools a user would pick instead, by turns, as ratios of each round.

usage: ratios.py BENCH [--peers DIR] [--rounds 5] [--only REGEX] [--json FILE]

BENCH: the program `bench`. DIR (or the environment's ARDENT_PEERS) has make_problems.py, which writes the regression
problems, and fit_peer.py, which times a peer on one of them and prints a line of JSON; without it, or where a peer
cannot be run, its rows are skipped and say so. Peers run on one thread (OPENBLAS_NUM_THREADS=1) with the system's
python3.
"""
import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile

PYTHON = "/usr/bin/python3"

# what, benchmark, peer and problem, ratio peer / ours asked for
FITS = [
    ("Duffing 17507 x 11 x 2", "fast_rvm/duffing", "ard", "duffing", 20),
    ("Duffing 17507 x 11 x 2", "fast_rvm/duffing", "ard_norm", "duffing", 20),
    ("Duffing, slow RVM", "slow_rvm/duffing", "ard", "duffing", 15),
    ("Valanis 17507 x 14 x 3", "fast_rvm/valanis", "ard_norm", "valanis", 15),
    ("QZS 44032 x 12", "fast_rvm/qzs44032", "ard_norm", "qzs44032", 5),
    ("17507 x 100", "fast_rvm/wide100", "ard_norm", "wide100", 1.2),
    ("17507 x 500", "fast_rvm/wide500", "ard_norm", "wide500", 0.6),
    ("10^6 x 20 from files", "streamed/poly1e6", "ard", "poly1e6", 15),
]
# what, benchmark, the one it is compared with, ratio ours / other allowed
OWN = [
    ("raw part / bare read, RF64", "raw_part/rf64", "bare_read/rf64", 1.6),
    ("raw part / bare read, FLAC", "raw_part/flac", "bare_read/flac", 1.4),
    ("whole run / bare read", "rig/run_fast_rvm", "rig/bare_read", 3.3),
]
# what, benchmark, the peer's, ratio peer / ours asked for
OWN_PEERS = [("decimator against soxr HQ, RF64", "decimator/rf64", "soxr/rf64", 1.2)]


class Bench:
    def __init__(self, program, problems):
        self.program = program
        self.environment = dict(os.environ, ARDENT_BENCH_PROBLEMS=problems or "")

    def run(self, *names):
        """{name: its row of google-benchmark's JSON}."""
        wanted = "^(" + "|".join(map(re.escape, names)) + ")/(process|manual)_time$"
        done = subprocess.run([self.program, "--benchmark_filter=" + wanted, "--benchmark_format=json"],
                              env=self.environment, capture_output=True, text=True)
        if done.returncode != 0 or not done.stdout.strip():
            return {}
        found = {}
        for row in json.loads(done.stdout)["benchmarks"]:
            name, _, how = row["name"].rpartition("/")
            row["cpu_ms"] = row["real_time" if how == "manual_time" else "cpu_time"]
            found[name] = row
        return found


def peer_ms(folder, peer, problems, problem):
    done = subprocess.run([PYTHON, os.path.join(folder, "fit_peer.py"), peer, problems, problem, "--reps", "3"],
                          env=dict(os.environ, OPENBLAS_NUM_THREADS="1"), capture_output=True, text=True)
    if done.returncode != 0:
        return None, (done.stderr.strip().splitlines() or ["no message"])[-1]
    return 1e3 * json.loads(done.stdout)["cpu_median"], ""


class Table:
    def __init__(self):
        self.rows = []

    def skip(self, what, why):
        print(f"{what}: skipped: {why}", flush=True)
        self.rows.append({"what": what, "skipped": why})

    def add(self, what, ratios, bar, higher_is_better, **figures):
        middle = statistics.median(ratios)
        held = middle >= bar if higher_is_better else middle <= bar
        print(f"{what}: {middle:.3g} x ({min(ratios):.3g} to {max(ratios):.3g}), asked "
              f"{'at least' if higher_is_better else 'at most'} {bar}{'' if held else '  MISSED'}", flush=True)
        self.rows.append({"what": what, "ratios": ratios, "asked": bar, "held": held, **figures})


def fit_rows(bench, folder, problems, arguments, table):
    for what, name, peer, problem, ask in FITS:
        what = f"{what} against {peer}"
        if arguments.only and not re.search(arguments.only, what):
            continue
        if not folder:
            table.skip(what, "no folder of peers: give --peers or set ARDENT_PEERS")
            continue
        if not os.path.exists(os.path.join(problems, problem + "_Phi.npy")):
            table.skip(what, f"no problem {problem} in {problems}")
            continue
        ratios, why = [], ""
        for _ in range(arguments.rounds):
            theirs, why = peer_ms(folder, peer, problems, problem)
            ours = bench.run(name).get(name)
            if theirs is None or ours is None:
                why = why or f"no benchmark {name}"
                break
            ratios.append(theirs / ours["cpu_ms"])
        if why:
            table.skip(what, why)
        else:
            table.add(what, ratios, ask, True, ours_ms=ours["cpu_ms"], peer_ms=theirs)


def own_rows(bench, arguments, table):
    for rows, higher_is_better in ((OWN, False), (OWN_PEERS, True)):
        for what, ours, other, bar in rows:
            if arguments.only and not re.search(arguments.only, what):
                continue
            ratios = []
            for _ in range(arguments.rounds):
                times = bench.run(ours, other)
                if len(times) < 2:
                    break
                ratio = times[ours]["cpu_ms"] / times[other]["cpu_ms"]
                ratios.append(1 / ratio if higher_is_better else ratio)
            if ratios:
                table.add(what, ratios, bar, higher_is_better)
            else:
                table.skip(what, "the benchmark did not run")


def share_of_the_machine(bench, arguments, table):
    """Of the R factors, in the same run as the machine's own figures."""
    names = [name.replace("fast_rvm/", "factor/") for _, name, _, _, _ in FITS if name.startswith("fast_rvm/")]
    rounds = [bench.run("machine/multiply_add", "machine/read_memory", *dict.fromkeys(names))
              for _ in range(arguments.rounds)]
    rounds = [rows for rows in rounds if "machine/multiply_add" in rows]
    if not rounds:
        table.skip("share of the machine", "the benchmark did not run")
        return
    peak = statistics.median(rows["machine/multiply_add"]["GFLOP"] for rows in rounds)
    print(f"one core: {peak:.1f} GFLOP/s, "
          f"{statistics.median(rows['machine/read_memory']['GB'] for rows in rounds):.1f} GB/s read")
    for name in dict.fromkeys(names):
        shares = [rows[name]["GFLOP"] / rows["machine/multiply_add"]["GFLOP"] for rows in rounds if name in rows]
        if shares:
            table.add(f"{name}, share of the multiply-add peak", shares, 0.15, True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bench")
    parser.add_argument("--peers", default=os.environ.get("ARDENT_PEERS"))
    parser.add_argument("--problems", default="duffing valanis qzs44032 wide100 wide500",
                        help="what make_problems.py is asked for; poly1e6 and poly1e7 take 0.3 and 3 GB of disk")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--only", help="rows whose title has this pattern")
    parser.add_argument("--json", help="file for all figures")
    arguments = parser.parse_args()
    folder = arguments.peers if arguments.peers and os.path.isdir(arguments.peers) else None
    table = Table()
    with tempfile.TemporaryDirectory() as problems:
        if folder:
            subprocess.run([PYTHON, os.path.join(folder, "make_problems.py"), problems, *arguments.problems.split()],
                           env=dict(os.environ, OPENBLAS_NUM_THREADS="1"), stdout=subprocess.DEVNULL, check=True)
        bench = Bench(arguments.bench, problems)
        fit_rows(bench, folder, problems, arguments, table)
        if not arguments.only:
            share_of_the_machine(bench, arguments, table)
        own_rows(bench, arguments, table)
    if arguments.json:
        with open(arguments.json, "w") as out:
            json.dump(table.rows, out, indent=1)
    sys.exit(0 if all(row.get("held", True) for row in table.rows) else 1)


if __name__ == "__main__":
    main()
