#!/usr/bin/env python3
"""CPU seconds of what scipy and scikit-learn do instead, as a line of JSON: the median of --reps. Of simulated records
also the error: the largest difference of a state from that at a tolerance of 1e-13, over its root mean square.

usage: peers.py TASK [FILE] [--reps 3] [--error]

derivative       forward, times i 2 pi f, back, of 44,032 samples (scipy.fft)
duffing_odeint, duffing_dop853, duffing_lsoda
                 seven records of 25 s of the paper's Duffing oscillator, rtol 1e-8
coulomb_dop853   the same of its Coulomb oscillator, restarted at every velocity reversal
resample_poly    600 s of four channels at 25.6 kHz to 25.6 Hz by one filter of 115 dB, given in memory
decimate         the same by 10 x 10 x 10 with scipy.signal.decimate's own filter
csv_ard          a table x, v, f, a from its FILE, eleven terms, ARDRegression
"""
import argparse
import json
import math
import statistics
import time

import numpy as np


def derivative():
    import scipy.fft
    n = 44032
    x = np.linspace(-1.0, 1.0, n) ** 3
    w = 2j * np.pi * np.arange(n // 2 + 1) * 25.6 / n
    many = 50
    start = time.process_time()
    for _ in range(many):
        scipy.fft.irfft(w * scipy.fft.rfft(x), n)
    return (time.process_time() - start) / many


def duffing(method, rtol=1e-8):
    """CPU seconds and the states of each record."""
    from scipy.integrate import odeint, solve_ivp
    t = np.arange(2501) * 0.01
    records = []
    start = time.process_time()
    for j in range(7):
        w = (0.7 + 0.1 * j) * 5.0

        def rates(s, y):
            return y[1], 100.0 * math.cos(w * s) - y[1] - 25.0 * y[0] - 2500.0 * y[0] ** 3
        if method == "odeint":
            records.append(odeint(rates, [0.0, 0.0], t, tfirst=True, rtol=rtol, atol=0.01 * rtol, mxstep=5000))
        else:
            run = solve_ivp(rates, (0.0, 25.0), [0.0, 0.0], method=method, t_eval=t, rtol=rtol, atol=0.01 * rtol)
            records.append(run.y.T)
    return time.process_time() - start, np.array(records)


def coulomb(rtol=1e-8):
    """The same, restarted at every velocity reversal."""
    from scipy.integrate import solve_ivp
    t = np.arange(2501) * 0.01
    records = np.zeros((7, 2501, 2))
    start = time.process_time()
    for j in range(7):
        w = (0.7 + 0.1 * j) * math.sqrt(1000.0)
        now, state, sign, done = 0.0, [0.0, 0.0], 1.0, 1
        while done < len(t):
            def rates(s, y, sign=sign):
                return y[1], 100.0 * math.cos(w * s) - 2.0 * y[1] - 1000.0 * y[0] - sign

            def turn(_, y):
                return y[1]
            turn.terminal, turn.direction = True, -sign
            run = solve_ivp(rates, (now, 25.0), state, method="DOP853", t_eval=t[done:], events=turn, rtol=rtol,
                            atol=0.01 * rtol, first_step=1e-5)
            reached = len(run.t)
            if reached:
                records[j, done:done + reached] = run.y.T
            done += reached
            if run.status != 1:
                break
            now, state, sign = run.t_events[0][0], [run.y_events[0][0][0], 0.0], -sign
    return time.process_time() - start, records


def simulated(simulate, exact):
    """A task that also knows its error."""
    def task():
        seconds, records = simulate()
        task.records = records
        return seconds

    def error():
        reference = exact()[1]
        return float(np.max(np.abs(task.records - reference) / np.sqrt((reference ** 2).mean(axis=(0, 1)))))
    task.error = error
    return task


def decimation(how):
    from scipy import signal
    x = np.random.default_rng(1).standard_normal(600 * 25600)
    taps = int(np.ceil((115 - 7.95) / (2.285 * 2 * np.pi * 2.56 / 25600))) | 1
    window = signal.firwin(taps, (10.24 + 12.8) / 25600, window=("kaiser", 0.1102 * (115 - 8.7)))
    start = time.process_time()
    if how == "resample_poly":
        signal.resample_poly(x, 1, 1000, window=window)
    else:
        signal.decimate(signal.decimate(signal.decimate(x, 10), 10), 10)
    return 4.0 * (time.process_time() - start)  # the channels one after the other


def csv_ard(file):
    from sklearn.linear_model import ARDRegression
    x, v, f, a = np.loadtxt(file, delimiter=",", skiprows=1, unpack=True)
    phi = np.column_stack([x**i * v**j for n in range(4) for i in range(n, -1, -1) for j in [n - i]] + [f])
    ARDRegression(fit_intercept=False).fit(phi / np.linalg.norm(phi, axis=0), a)
    return time.process_time()  # of the whole process


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("task")
    parser.add_argument("file", nargs="?")
    parser.add_argument("--reps", type=int, default=3)
    parser.add_argument("--error", action="store_true", help="of simulated records, with another run that takes long")
    arguments = parser.parse_args()
    tasks = {
        "derivative": derivative,
        "duffing_odeint": simulated(lambda: duffing("odeint"), lambda: duffing("DOP853", 1e-13)),
        "duffing_dop853": simulated(lambda: duffing("DOP853"), lambda: duffing("DOP853", 1e-13)),
        "duffing_lsoda": simulated(lambda: duffing("LSODA"), lambda: duffing("DOP853", 1e-13)),
        "coulomb_dop853": simulated(coulomb, lambda: coulomb(1e-13)),
        "resample_poly": lambda: decimation("resample_poly"),
        "decimate": lambda: decimation("decimate"),
    }
    if arguments.task == "csv_ard":
        times = [csv_ard(arguments.file)]
    else:
        times = [tasks[arguments.task]() for _ in range(arguments.reps)]
    figures = {"cpu_median": statistics.median(times)}
    if arguments.error:
        figures["error"] = tasks[arguments.task].error()
    print(json.dumps(figures))


if __name__ == "__main__":
    main()
