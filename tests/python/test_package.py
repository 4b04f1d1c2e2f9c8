"""The package `ardent` of Python: the same answers as the program's, arrays where they lie, errors as exceptions."""

import contextlib
import io
import json
import logging
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import ardent

ROOT = pathlib.Path(os.environ["ARDENT_ROOT"])
PROGRAM = os.environ["ARDENT"]


def program(*words, cwd=None):
    return subprocess.run([PROGRAM, "-q", *map(str, words)], cwd=cwd, capture_output=True, text=True)


def oscillator(seed, seconds=40.0, rate_hz=100.0, noise=1e-6):
    """x'' = -0.6 v - 40 x - 2000 x^3 + f, stepped in tenths of a sample by the classical Runge-Kutta method; f is a sum of
    sines below 2 Hz."""
    draw = np.random.default_rng(seed)
    lines = np.arange(0.2, 2.0, 0.09)
    sizes, phases = draw.normal(0.0, 0.12, lines.size), draw.uniform(0.0, 2 * np.pi, lines.size)
    force = lambda t: float(sizes @ np.sin(2 * np.pi * lines * t + phases))

    def rates(t, state):
        x, v = state
        return np.array([v, -0.6 * v - 40.0 * x - 2000.0 * x**3 + force(t)])

    step, state, rows = 1.0 / rate_hz / 4, np.zeros(2), []
    t = np.arange(int(seconds * rate_hz)) / rate_hz
    for at in t:
        rows.append(state[0])
        for k in range(4):
            now = at + k * step
            a = rates(now, state)
            b = rates(now + step / 2, state + step / 2 * a)
            c = rates(now + step / 2, state + step / 2 * b)
            d = rates(now + step, state + step * c)
            state = state + step / 6 * (a + 2 * b + 2 * c + d)
    x = np.array(rows)
    return t, x + draw.normal(0.0, noise, x.size), np.array([force(at) for at in t])


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.t, cls.x, cls.f = oscillator(40117)
        cls.recording = ardent.Recording({"x": cls.x, "f": cls.f}, rate_hz=100, name="swing")
        cls.result = ardent.identify(cls.recording)

    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.scratch.name)

    def tearDown(self):
        self.scratch.cleanup()

    def test_equation_of_arrays_covers_the_truth(self):
        equation = self.result.equation
        self.assertEqual(self.result.verdict, "describes")
        truth = {"x": -40.0, "v": -0.6, "x^3": -2000.0, "f": 1.0}
        self.assertEqual({term.name for term in equation.terms}, set(truth))
        for name, value in truth.items():  # five standard deviations: one in a million draws lies outside
            self.assertLess(abs(equation[name].mean - value), 5 * equation[name].std, name)
        self.assertEqual(equation.covariance.shape, (4, 4))
        self.assertIn("x^3", repr(self.result))
        self.assertTrue(str(self.result).startswith("equation "))
        self.assertTrue(self.result.report.is_file())

    def test_result_is_the_programs_to_the_byte(self):
        saved = self.recording.save(self.folder / "swing")
        self.assertEqual(program("run", saved, "-o", "cli", cwd=self.folder).returncode, 0)
        for name in ("equation.json", "metrics.json", "predictions.csv"):
            self.assertEqual((self.folder / "cli" / name).read_bytes(), (self.result.folder / name).read_bytes(), name)

    def test_rig_record_in_ten_lines_as_by_the_command_line(self):
        flac = ROOT / "data" / "qzs_256.flac"
        here = ardent.identify(flac, self.folder / "here", rows=False, figures=False)
        ended = program("run", flac, "-o", self.folder / "cli", "--no-rows", "--no-figures")
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertEqual((self.folder / "cli/equation.json").read_bytes(), (self.folder / "here/equation.json").read_bytes())
        self.assertEqual(here.equation.of, "mixed")
        loaded = ardent.load(self.folder / "cli")
        self.assertEqual(loaded.equation, here.equation)

    def test_readme_example(self):
        text = (ROOT / "README.md").read_text(encoding="utf-8")
        block = re.search(r"(?m)^    import ardent\n(?:(?:    .*)?\n)+", text).group(0)
        lines = [line[4:] for line in block.rstrip("\n").split("\n")]
        self.assertLessEqual(len(lines), 10)
        np.savetxt(self.folder / "drive.csv", np.column_stack((self.t, 1e3 * self.x, self.f)), delimiter=",",
                   header="t,x_mm,f_n", comments="", fmt="%.17g")
        names = {}
        with contextlib.chdir(self.folder):
            with contextlib.redirect_stdout(io.StringIO()):
                exec("\n".join(lines), names)
        self.assertEqual(names["result"].verdict, "describes")

    def test_arrays_are_read_as_they_lie(self):
        wide = np.zeros((self.x.size, 3), order="C")
        wide[:, 1] = self.x
        big_endian = self.f.astype(">f8")
        found = ardent.Recording({"x": wide[:, 1], "f": big_endian}, rate_hz=100)
        np.testing.assert_array_equal(found["x"], self.x)
        np.testing.assert_array_equal(found["f"], self.f)
        backwards = ardent.Recording({"x": self.x[::-1]}, rate_hz=100)
        np.testing.assert_array_equal(backwards["x"], self.x[::-1])
        singles = ardent.Recording({"x": self.x.astype(np.float32)}, rate_hz=100)
        np.testing.assert_array_equal(singles["x"], self.x.astype(np.float32).astype(np.float64))
        bodies = ardent.Recording({"x": np.column_stack((self.x, 2 * self.x))}, rate_hz=100)
        self.assertEqual([(one.role, one.body) for one in bodies.channels], [("x", 1), ("x", 2)])

    def test_names_units_roles_and_clock(self):
        found = ardent.Recording({"t": self.t, "weg [mm]": 1e3 * self.x, "motor": 1e-3 * self.f},
                                 units={"motor": "kN"}, roles={"motor": "f", "weg [mm]": "x"})
        self.assertAlmostEqual(found.rate_hz, 100.0)
        np.testing.assert_allclose(found["x"], self.x, rtol=1e-14, atol=0)  # twice rounded
        np.testing.assert_allclose(found["f"], self.f, rtol=1e-14, atol=0)
        self.assertEqual([one.unit for one in found.channels], ["m", "N"])
        self.assertEqual(found.num_samples, self.x.size)

    def test_file_is_read_as_samples(self):
        file = ROOT / "data" / "qzs_256.flac"
        found = ardent.read(file)
        self.assertEqual((found.rate_hz, found.samples.shape), (256.0, (found.num_samples, len(found.channels))))
        self.assertTrue(any("held by hand" in interval.why for interval in found.bad))
        with self.assertRaises(ValueError):
            found.samples[0, 0] = 1.0

    def test_prepare_and_regimes(self):
        prepared = ardent.prepare(ROOT / "data" / "qzs_256.flac", rate_hz=25.6, cutoff_hz=10.24)
        self.assertEqual(prepared.rate_hz, 25.6)
        self.assertLessEqual({"t", "x", "v", "a", "ddr"}, set(prepared))
        self.assertEqual(prepared["x"].shape, prepared.is_excluded.shape)
        regimes = ardent.find_regimes(prepared)
        self.assertLessEqual({"low", "high"}, {one.name for one in regimes})
        for one, after in zip(regimes, regimes[1:]):
            self.assertEqual(one.to_s, after.from_s)

    def test_views_outlive_what_they_came_from(self):
        x = ardent.prepare(self.recording).signals["x"]
        samples = ardent.Recording({"x": self.x}, rate_hz=100).samples
        np.testing.assert_array_equal(samples[:, 0], self.x)
        self.assertEqual(float(x[0]), float(ardent.prepare(self.recording)["x"][0]))

    def test_arrays_are_not_doubled(self):
        """160 MB of arrays, prepared at a hundredth of their rate: less than a quarter of that is added."""
        code = ("import resource, numpy as np, ardent\n"
                "t = np.arange(10_000_000) / 1e5\n"
                "x = np.sin(2 * np.pi * 3 * t); x += 1e-6 * np.cos(1e3 * t)\n"
                "peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
                "recording = ardent.Recording({'x': x, 'f': t}, rate_hz=1e5)\n"
                "before = peak(); ardent.prepare(recording, rate_hz=1e3, cutoff_hz=400)\n"
                "print(peak() - before)\n")
        said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        self.assertEqual(said.returncode, 0, said.stderr)
        self.assertLess(int(said.stdout), 40_000)

    def test_predict_test_recordings_and_frc(self):
        _, x, f = oscillator(40118)
        other = ardent.Recording({"x": x, "f": f}, rate_hz=100, name="other")
        prediction = self.result.predict(other)
        self.assertLess(prediction.nmse, 1e-3)
        self.assertIn("t", prediction.table)
        self.assertEqual(prediction.table["t"].dtype, np.dtype(float))
        both = ardent.identify([self.recording, other], self.folder / "both", rows=False, figures=False)
        self.assertEqual({term.name for term in both.equation.terms}, {"x", "v", "x^3", "f"})
        tested = ardent.identify(self.recording, test=[other], rows=False, figures=False)
        self.assertEqual(len(list(tested.folder.glob("predict-1-*.json"))), 1)
        response = self.result.frc(draws=0, set={"from_hz": 0.5, "to_hz": 1.5, "step_hz": 0.1, "amplitude": 0.1})
        self.assertGreater(len(next(iter(response.table.values()))), 10)

    def test_free_run_export_and_plot(self):
        curves = self.result.free_run()
        self.assertLess(np.abs(curves.measured - curves.free_run).max(), 0.01 * np.abs(curves.measured).max())
        folder = self.result.export("python", self.folder / "exported")
        self.assertTrue(list(folder.glob("*.py")))
        try:
            import matplotlib
        except ImportError:
            self.skipTest("skipped: matplotlib is not installed")
        matplotlib.use("Agg")
        self.result.plot().savefig(self.folder / "free-run.png")
        self.assertGreater((self.folder / "free-run.png").stat().st_size, 1000)

    def test_bodies(self):
        self.assertEqual(program("sim", "chain", "-o", "chain", "--duration", "30", cwd=self.folder).returncode, 0)
        result = ardent.identify(self.folder / "chain" / "response.csv")
        self.assertEqual([one.of for one in result.equations], ["1", "2"])
        self.assertEqual(result.equations[1].covariance.shape, (len(result.equations[1].terms),) * 2)
        self.assertIsNotNone(result.free_run("2"))
        self.assertIn("a2 = ", repr(result))

    def test_errors_have_name_and_remedy(self):
        with self.assertRaises(ardent.InputError) as missing:
            ardent.identify(self.folder / "nothing.csv")
        self.assertEqual(missing.exception.name, "file.missing")
        with self.assertRaises(ardent.UsageError) as setting:
            ardent.identify(self.recording, set={"library.ordre": 3})
        self.assertIn("order", str(setting.exception))
        with self.assertRaises(ardent.UsageError):
            ardent.Recording({"x": np.array(["a", "b"])}, rate_hz=1)
        with self.assertRaises(ardent.UsageError):
            ardent.Recording({"x": self.x}, rate_hz=100, roles={"y": "y"})
        with self.assertRaises(ardent.InputError) as rate:
            ardent.Recording({"x": self.x})
        self.assertEqual(rate.exception.name, "rate.missing")
        with self.assertRaises(ardent.UsageError):
            ardent.load(self.folder)
        again = self.folder / "run"
        ardent.identify(self.recording, again, rows=False, figures=False)
        with self.assertRaises(ardent.Error):
            ardent.identify(self.recording, again)

    def test_what_is_said_on_the_way_is_logged(self):
        with self.assertLogs("ardent", logging.INFO) as log:
            ardent.command("info", self.recording.save(self.folder / "swing"))
            ardent.identify(self.recording, rows=False, figures=False)
        self.assertTrue(any("preparing" in line for line in log.output))

    def test_other_threads_go_on_and_interrupts_stop(self):
        wide = ardent.Recording({"x": np.tile(self.x, 20), "f": np.tile(self.f, 20)}, rate_hz=100)
        before, ticks = signal.getsignal(signal.SIGINT), []
        stopper = threading.Timer(0.8, os.kill, (os.getpid(), signal.SIGINT))
        ticking = threading.Timer(0.3, lambda: ticks.append(time.monotonic()))
        ticking.start()
        stopper.start()
        begun = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            ardent.identify(wide, self.folder / "stopped", set={"library.order": 9})
        self.assertLess(time.monotonic() - begun, 10.0)  # of a run of minutes; the machine may be busy
        self.assertTrue(ticks and ticks[0] - begun < 0.75)
        self.assertFalse((self.folder / "stopped").exists())
        self.assertIs(signal.getsignal(signal.SIGINT), before)
        self.assertEqual(ardent.command("terms").code, 0)

    def test_threads_at_once(self):
        found = []
        work = [threading.Thread(target=lambda: found.append(ardent.identify(self.recording, rows=False, figures=False)))
                for _ in range(2)]
        for one in work:
            one.start()
        for one in work:
            one.join()
        texts = {json.dumps(one.found, sort_keys=True) for one in (*found, self.result)}
        self.assertEqual(len(texts), 1)


if __name__ == "__main__":
    unittest.main()
