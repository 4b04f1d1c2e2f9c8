"""Draws docs/picture.svg, the picture of the README, from a run of the record that comes with the sources:

    ardent run data/qzs_256.flac -o rig-run && /usr/bin/python3 docs/picture.py rig-run
"""
import csv
import pathlib
import re
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402

INK, ORANGE, BLUE, SKY, GREY = "#1a1a1a", "#d55e00", "#0072b2", "#56b4e9", "#b5b5b5"
run = pathlib.Path(sys.argv[1])


def series(name):
    """Of a figure: x and y by the label of the series."""
    with open(run / "figures" / (name + ".csv"), newline="") as file:
        rows = csv.reader(file)
        found = {}
        for label, x, y in list(rows)[1:]:
            found.setdefault(label, ([], []))
            found[label][0].append(float(x))
            found[label][1].append(float(y))
        return found


def columns(name):
    with open(run / "figures" / (name + ".csv"), newline="") as file:
        rows = list(csv.reader(file))
    return [[float(row[i]) if row[i] else float("nan") for row in rows[1:]] for i in range(len(rows[0]))]


mm = 1e3
plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "ardent", "font.family": "sans-serif", "font.size": 11,
                     "axes.spines.top": False, "axes.spines.right": False})
figure = plt.figure(figsize=(9.6, 4.7))
left, right = figure.add_gridspec(1, 2, width_ratios=(1, 1.25), left=0.07, right=0.985, bottom=0.12, top=0.8, wspace=0.2)
response = figure.add_subplot(left)
above, below = right.subgridspec(2, 1, height_ratios=(2.6, 1), hspace=0.12)
motion = figure.add_subplot(above)
error = figure.add_subplot(below, sharex=motion)

steps = series("steps-1-response")
for label, (f, x) in steps.items():
    size = [mm * value for value in x]
    if label.startswith("measured"):
        response.plot(f, size, "o", ms=4, color=BLUE if "down" in label else INK, label="measured, steps of a sine", zorder=3)
    else:
        response.plot(f, size, color=ORANGE if "down" in label else SKY, lw=2,
                      label="equation, frequency " + ("falling" if "down" in label else "rising"))
response.set(xlabel="frequency (Hz)", ylabel="amplitude of x (mm)", ylim=(0, None))
response.legend(frameon=False, fontsize=9, loc="upper left")
response.set_title("jump and hysteresis", loc="left", fontsize=11)

first_screen = (run / "equation.txt").read_text()
chosen = re.search(r"From range (\S+)", first_screen).group(1)
number = next(path.stem for path in (run / "figures").glob(f"range-*-{chosen}-free-run.csv"))
t, measured, free = columns(number)
last, shown_s = max(at for at, value in zip(t, free) if value == value), 9.0
keep = [i for i, at in enumerate(t) if last - shown_s <= at <= last]
motion.plot([t[i] for i in keep], [mm * measured[i] for i in keep], color=GREY, lw=4, label="measured, not fitted")
motion.plot([t[i] for i in keep], [mm * free[i] for i in keep], color=ORANGE, lw=1.6, ls=(0, (4, 2)), label="equation alone")
motion.set(ylabel="x (mm)")
motion.tick_params(labelbottom=False)
motion.legend(frameon=False, fontsize=9, loc="lower center", bbox_to_anchor=(0.5, 0.98), ncols=2)
error.plot([t[i] for i in keep], [mm * (measured[i] - free[i]) for i in keep], color=BLUE, lw=1.2)
error.axhline(0, color=INK, lw=0.6)
error.set(xlabel="time (s)", ylabel="error (mm)")
equation = first_screen.splitlines()[0].split(None, 1)[1]
figure.text(0.07, 0.93, equation.replace("x^3", "x³"), fontsize=13, color=INK)
figure.align_ylabels([motion, error])
figure.savefig(pathlib.Path(__file__).with_name("picture.svg"), metadata={"Date": None})
