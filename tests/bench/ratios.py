#!/usr/bin/env python3
"""CPU time of our benchmarks beside that of the tools a user would pick instead, by turns, as ratios of each round.

usage: ratios.py BENCH [--peers DIR] [--rounds 5] [--only REGEX] [--json FILE]

BENCH: the program `bench`. DIR (or the environment's ARDENT_PEERS) has make_problems.py, which writes the regression
problems, and fit_peer.py, which times a peer on one of them and prints a line of JSON; without it, or where a peer
cannot be run, its rows are skipped and say so. Other peers are in peers.py beside this script. Peers run on one thread
(OPENBLAS_NUM_THREADS=1) with the system's python3.
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
# what, benchmark, the one it is compared with, ratio ours / other allowed, of CPU or wall time
OWN = [
    ("raw part / bare read, RF64", "rig/raw_part", "rig/bare_read", 1.6, "cpu"),
    ("raw part / bare read, FLAC", "raw_part/flac", "bare_read/flac", 1.4, "cpu"),
    ("decimator / bare read, RF64", "decimator/rf64", "bare_read/rf64", 2.5, "cpu"),
    ("whole run / bare read, wall", "rig/run_fast_rvm", "rig/bare_read", 3.3, "wall"),
]
# what, benchmark, the other, ratio other / ours asked for, of CPU or wall time
OWN_PEERS = [
    ("decimator against soxr HQ, RF64", "decimator/rf64", "soxr/rf64", 1.2, "cpu"),
    ("10^6 x 20, two threads against one, wall", "factor_on_2/poly1e6", "factor_on_1/poly1e6", 1.7, "wall"),
    ("10^7 x 20, two threads against one, wall", "factor_on_2/poly1e7", "factor_on_1/poly1e7", 1.7, "wall"),
]
# what, benchmark, task of peers.py, ratio peer / ours asked for
SCRIPTS = [
    ("decimator against scipy resample_poly of 115 dB", "decimator/rf64", "resample_poly", 12),
    ("decimator against scipy decimate", "decimator/rf64", "decimate", 15),
    ("spectral derivative against scipy.fft", "derivative/plan_kept", "derivative", 1.3),
    ("Duffing records against odeint", "simulate/duffing", "duffing_odeint", 8),
    ("Duffing records against solve_ivp DOP853", "simulate/duffing", "duffing_dop853", 30),
    ("Coulomb records against solve_ivp DOP853 with events", "simulate/coulomb", "coulomb_dop853", 60),
]
# what, benchmark, task of peers.py: our error is to be no larger
ERRORS = [
    ("Duffing records, error", "simulate/duffing", "duffing_odeint"),
    ("Duffing records, error", "simulate/duffing", "duffing_dop853"),
    ("Coulomb records, error", "simulate/coulomb", "coulomb_dop853"),
]
# what, benchmark, its figure, bar, whether it is the least
FIGURES = [
    ("Coulomb records, largest error", "simulate/coulomb", "error", 1e-6, False),
    ("Coulomb records, reversals found", "simulate/coulomb", "reversals", 1763, True),
]
# what streams a problem from its files, most MiB of the whole process
STREAMED = [("10^6 x 20 from files, MiB", "poly1e6", 32), ("10^7 x 20 from files, MiB", "poly1e7", 32)]


class Bench:
    def __init__(self, program, problems, files):
        self.program = program
        self.environment = dict(os.environ, ARDENT_BENCH_PROBLEMS=problems, ARDENT_BENCH_FILES=files)

    def command(self, names):
        wanted = "^(" + "|".join(map(re.escape, names)) + ")/(process|manual|real)_time$"
        return [self.program, "--benchmark_filter=" + wanted, "--benchmark_format=json"]

    def peak_mib(self, name):
        """Of the process that runs this one alone."""
        process = subprocess.Popen(self.command([name]), env=self.environment, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = status
        return used.ru_maxrss / 1024 if status == 0 else None

    def run(self, *names):
        """{name: its row of google-benchmark's JSON}."""
        done = subprocess.run(self.command(names), env=self.environment, capture_output=True, text=True)
        if done.returncode != 0 or not done.stdout.strip():
            return {}
        found = {}
        for row in json.loads(done.stdout)["benchmarks"]:
            name, _, how = row["name"].rpartition("/")
            row["cpu_ms"] = row["real_time" if how == "manual_time" else "cpu_time"]
            row.setdefault("wall_ms", row["real_time"])
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
        print(f"{what}: {middle:.3g} ({min(ratios):.3g} to {max(ratios):.3g}), asked "
              f"{'at least' if higher_is_better else 'at most'} {bar}{'' if held else '  MISSED'}", flush=True)
        self.rows.append({"what": what, "ratios": ratios, "asked": bar, "held": held, **figures})


def against_peer(bench, arguments, table, what, name, ask, time_peer):
    """By turns with a benchmark of ours; time_peer gives milliseconds, or None and why."""
    ratios = []
    for _ in range(arguments.rounds):
        theirs, why = time_peer()
        ours = bench.run(name).get(name)
        if theirs is None or ours is None:
            table.skip(what, why or f"no benchmark {name}")
            return
        ratios.append(theirs / ours["cpu_ms"])
    table.add(what, ratios, ask, True, ours_ms=ours["cpu_ms"], peer_ms=theirs)


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
        against_peer(bench, arguments, table, what, name, ask, lambda: peer_ms(folder, peer, problems, problem))


def own_rows(bench, arguments, table):
    for rows, higher_is_better in ((OWN, False), (OWN_PEERS, True)):
        for what, ours, other, bar, clock in rows:
            if arguments.only and not re.search(arguments.only, what):
                continue
            rounds = [bench.run(ours, other) for _ in range(arguments.rounds)]
            rounds = [times for times in rounds if len(times) == 2]
            if not rounds:
                table.skip(what, f"no benchmark {ours} or {other}")
                continue
            ratios = [times[ours][clock + "_ms"] / times[other][clock + "_ms"] for times in rounds]
            table.add(what, [1 / ratio for ratio in ratios] if higher_is_better else ratios, bar, higher_is_better,
                      ours_ms=[times[ours][clock + "_ms"] for times in rounds],
                      other_ms=[times[other][clock + "_ms"] for times in rounds])


def whole_run_row(bench, arguments, table):
    """What the hash costs is beside the rest where there are two cores: apart from it, CPU time."""
    what = "whole run without the hash / bare read, CPU"
    if arguments.only and not re.search(arguments.only, what):
        return
    names = "rig/run_fast_rvm", "rig/hash", "rig/bare_read"
    rounds = [bench.run(*names) for _ in range(arguments.rounds)]
    if all(len(times) == len(names) for times in rounds):
        times = [[one[name]["cpu_ms"] for name in names] for one in rounds]
        table.add(what, [(run - hashing) / bare for run, hashing, bare in times], 3.0, False, times_ms=times)
    else:
        table.skip(what, "the benchmark did not run")


def script_figures(task, *arguments):
    """Its line of JSON, or None and why."""
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "peers.py")
    done = subprocess.run([PYTHON, script, task, *arguments], env=dict(os.environ, OPENBLAS_NUM_THREADS="1"),
                          capture_output=True, text=True)
    if done.returncode != 0:
        return None, (done.stderr.strip().splitlines() or ["no message"])[-1]
    return json.loads(done.stdout), ""


def script_ms(task, *arguments):
    figures, why = script_figures(task, *arguments)
    return figures and 1e3 * figures["cpu_median"], why


def error_rows(bench, arguments, table):
    for what, name, task in ERRORS:
        what = f"{what} of {task} / ours"
        if arguments.only and not re.search(arguments.only, what):
            continue
        theirs, why = script_figures(task, "--reps", "1", "--error")
        ours = bench.run(name).get(name)
        if theirs is None or ours is None:
            table.skip(what, why or f"no benchmark {name}")
        else:
            table.add(what, [theirs["error"] / ours["error"]], 1, True, ours=ours["error"], peer=theirs["error"])
    for what, name, figure, bar, is_least in FIGURES:
        if arguments.only and not re.search(arguments.only, what):
            continue
        ours = bench.run(name).get(name)
        if ours is None:
            table.skip(what, f"no benchmark {name}")
        else:
            table.add(what, [ours[figure]], bar, is_least)


def script_rows(bench, arguments, table):
    for what, name, task, ask in SCRIPTS:
        if arguments.only and not re.search(arguments.only, what):
            continue
        against_peer(bench, arguments, table, what, name, ask, lambda: script_ms(task, "--reps", "1"))


def process_ms(command):
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = status
    return 1e3 * (used.ru_utime + used.ru_stime) if status == 0 else None


def csv_row(bench, problems, arguments, table):
    """A table of the Duffing records to its equation, whole processes."""
    what = "Duffing, CSV to equation, against Python and ARD"
    if arguments.only and not re.search(arguments.only, what):
        return
    ardent = os.path.join(os.path.dirname(bench.program), "ardent")
    csv = os.path.join(problems, "duffing_states.csv")
    write = ("import numpy as np, sys; d = sys.argv[1]; np.savetxt(sys.argv[2], np.column_stack([np.load(d + '_X.npy'),"
             " np.load(d + '_T.npy')[:, 1]]), delimiter=',', header='x,v,f,a', comments='', fmt='%.17g')")
    made = subprocess.run([PYTHON, "-c", write, os.path.join(problems, "duffing"), csv], stderr=subprocess.DEVNULL)
    if made.returncode != 0:
        table.skip(what, f"no problem duffing in {problems}")
        return
    ratios = []
    for _ in range(arguments.rounds):
        theirs, why = script_ms("csv_ard", csv)
        ours = process_ms([ardent, "fit", csv, "--target", "a", "--terms",
                           "1,x,v,x^2,x*v,v^2,x^3,x^2*v,x*v^2,v^3,f", "--methods", "fast_rvm", "--threads", "1"])
        if theirs is None or ours is None:
            table.skip(what, why or f"{ardent} failed")
            return
        ratios.append(theirs / ours)
    table.add(what, ratios, 35, True, ours_ms=ours, peer_ms=theirs)


def memory_rows(bench, problems, arguments, table):
    for what, problem, most in STREAMED:
        if arguments.only and not re.search(arguments.only, what):
            continue
        if not os.path.exists(os.path.join(problems, problem + "_X.npy")):
            table.skip(what, f"no problem {problem} in {problems}")
            continue
        peak = bench.peak_mib("streamed/" + problem)
        if peak is None:
            table.skip(what, "the benchmark did not run")
        else:
            table.add(what, [peak], most, False)


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
    with tempfile.TemporaryDirectory() as problems, tempfile.TemporaryDirectory() as files:
        if folder:
            subprocess.run([PYTHON, os.path.join(folder, "make_problems.py"), problems, *arguments.problems.split()],
                           env=dict(os.environ, OPENBLAS_NUM_THREADS="1"), stdout=subprocess.DEVNULL, check=True)
        bench = Bench(arguments.bench, problems, files)
        fit_rows(bench, folder, problems, arguments, table)
        if not arguments.only:
            share_of_the_machine(bench, arguments, table)
        own_rows(bench, arguments, table)
        whole_run_row(bench, arguments, table)
        script_rows(bench, arguments, table)
        error_rows(bench, arguments, table)
        csv_row(bench, problems, arguments, table)
        memory_rows(bench, problems, arguments, table)
    if arguments.json:
        with open(arguments.json, "w") as out:
            json.dump(table.rows, out, indent=1)
    sys.exit(0 if all(row.get("held", True) for row in table.rows) else 1)


if __name__ == "__main__":
    main()
