"""How the program judges labelled records: what it says of right laws and of wrong ones.

python3 judge_kinds.py PROGRAM RECORDS RUNS [--jobs N] [--read]

Runs `PROGRAM run RECORD -o RUN` on each CSV of the folder RECORDS that has a label beside it (see make_kinds), keeps the
documents of each in RUNS, and prints tables. With --read nothing is run and the documents in RUNS are read again.
"""
import argparse
import concurrent.futures
import json
import math
import pathlib
import shutil
import subprocess
import time

VERDICTS = ["describes", "in_part", "does_not", "undecided"]
KEPT = ["equation.json", "equation.txt", "quality.json", "segments.json", "metrics.json"]
TIMEOUT_S = 900


def run_one(program, record, runs):
    """Exit code, seconds, what it said in `outcome.json`; the documents that count."""
    kept, whole = runs / record.stem, runs / (record.stem + ".whole")
    shutil.rmtree(kept, ignore_errors=True)
    shutil.rmtree(whole, ignore_errors=True)
    kept.mkdir(parents=True)
    begin = time.monotonic()
    try:
        done = subprocess.run([program, "run", record, "-o", whole], capture_output=True, text=True, timeout=TIMEOUT_S)
        code, said = done.returncode, done.stderr[-2000:]
    except subprocess.TimeoutExpired:
        code, said = "timeout", ""
    for name in KEPT:
        if (whole / name).exists():
            shutil.copy(whole / name, kept / name)
    shutil.rmtree(whole, ignore_errors=True)
    (kept / "outcome.json").write_text(json.dumps({"code": code, "seconds": time.monotonic() - begin, "said": said}))


def powers(name):
    """Exponents of x and v of a polynomial's term; nothing for another."""
    exponents = {"x": 0, "v": 0}
    for factor in [] if name == "1" else name.split("*"):
        base, _, power = factor.partition("^")
        if base not in exponents:
            return None
        exponents[base] += int(power or 1)
    return exponents["x"], exponents["v"]


def name_of(x, v):
    parts = [base + ("^%d" % power if power > 1 else "") for base, power in (("x", x), ("v", v)) if power]
    return "*".join(parts) or "1"


def about(terms, zero):
    """The coefficients in x - zero of an equation in x."""
    moved = {}
    for name, value in terms.items():
        exponents = powers(name)
        if exponents is None:
            moved[name] = value
            continue
        x, v = exponents
        for k in range(x + 1):
            other = name_of(k, v)
            moved[other] = moved.get(other, 0.0) + value * math.comb(x, k) * zero ** (x - k)
    return moved


def read_one(record, runs):
    outcome = json.loads((runs / record.stem / "outcome.json").read_text())
    label = json.loads(record.with_suffix(".json").read_text())
    result = {"label": label, "verdict": "failed", "cause": None, "held": 0, "known": 0, "exact": False, **outcome}
    document = runs / record.stem / "equation.json"
    if not document.exists():
        return result
    equations = json.loads(document.read_text())
    chosen = equations["chosen"] or {}
    part = next((r for r in equations["ranges"] if r["name"] == chosen.get("range")), equations["ranges"][0])
    fit = next((m for m in part["methods"] if m["method"] == chosen.get("method")), part["methods"][0])
    true = about(label["terms"], fit["coordinates"][0]["zero"] if fit["coordinates"] else 0.0)
    found = {term["name"]: term for term in fit["terms"]}
    known = [name for name in label["terms"] if name in found and found[name]["std"]]
    return {**result, "verdict": part["verdict"], "cause": part["cause"], "sentence": fit["sentence"],
            "exact": set(found) == set(label["terms"]), "missing": ",".join(sorted(set(label["terms"]) - set(found))),
            "false": ",".join(sorted(set(found) - set(label["terms"]))), "known": len(known),
            "held": sum(abs(found[name]["mean"] - true[name]) <= 1.96 * found[name]["std"] for name in known)}


def table(title, results, key):
    """A row for each value of the key and one for all."""
    print("\n%-22s %4s %10s %8s %9s %10s %7s %7s %7s   %s" %
          (title, "all", *VERDICTS, "failed", "caused", "exact", "95 % intervals hold"))
    groups = {}
    for result in results:
        groups.setdefault(str(key(result)), []).append(result)
    for name, members in [*sorted(groups.items()), ("all", results)]:
        exact = [r for r in members if r["exact"]]
        print("%-22s %4d %10d %8d %9d %10d %7d %7d %7d   %d of %d" %
              (name, len(members), *(sum(r["verdict"] == verdict for r in members) for verdict in [*VERDICTS, "failed"]),
               sum(r["cause"] is not None for r in members), len(exact), sum(r["held"] for r in exact),
               sum(r["known"] for r in exact)))


def band(percent, edges):
    return next(("below %4.1f %%" % edge for edge in edges if percent < edge), "more")


def listed(title, results):
    print("\n" + title)
    for r in results:
        print("  %(record)s: left %(share_left).3f, noise %(noise).4f, %(excitation)s, %(drive)s, %(natural_hz).3g Hz, "
              "%(duration_s)g s at %(rate_hz)g Hz" % r["label"],
              "; misses %s; has too much %s\n      %s" % (r["missing"], r["false"], r["sentence"]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("records", type=pathlib.Path)
    parser.add_argument("runs", type=pathlib.Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--read", action="store_true")
    options = parser.parse_args()
    records = [r for r in sorted(options.records.glob("*.csv")) if r.with_suffix(".json").exists()]
    if not options.read:
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            list(pool.map(lambda record: run_one(options.program, record, options.runs), records))
    results = [read_one(record, options.runs) for record in records
               if (options.runs / record.stem / "outcome.json").exists()]
    for word in ("right", "wrong"):
        some = [r for r in results if r["label"]["right"] == (word == "right")]
        table(word + ", kind", some, lambda r: r["label"]["kind"])
        table(word + ", drive", some, lambda r: r["label"]["excitation"] + ", " + r["label"]["drive"])
        table(word + ", noise", some, lambda r: band(100 * r["label"]["noise"], [0.1, 0.5, 1]))
        table(word + ", share left", some, lambda r: band(100 * r["label"]["share_left"], [5, 10, 20]))
        table(word + ", cause", some, lambda r: r["cause"])
    listed("wrong and `describes`", [r for r in results if not r["label"]["right"] and r["verdict"] == "describes"])
    listed("right and `does_not`", [r for r in results if r["label"]["right"] and r["verdict"] == "does_not"])
    print("\nfailed")
    for r in results:
        if r["verdict"] == "failed" or r["code"] != 0:
            print("  %s: %s, %s" % (r["label"]["record"], r["code"], r["said"].strip()[-300:]))
    print("\n%d records, %.0f s of runs" % (len(results), sum(r["seconds"] for r in results)))


if __name__ == "__main__":
    main()
