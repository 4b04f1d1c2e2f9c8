"""The package `ardent` of Python: the same answers as the program's, arrays where they lie, errors as exceptions."""

import contextlib
import copy
import io
import json
import logging
import os
import pathlib
import pickle
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
    """x'' = -0.6 v - 40 x - 2000 x^3 + f, stepped in quarters of a sample by the classical Runge-Kutta method; f is a
    sum of sines below 2 Hz."""
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
        self.assertIn("x", equation)
        self.assertEqual([term.name for term in equation], [term.name for term in equation.terms])
        with self.assertRaises(TypeError):  # its folder goes with this process
            pickle.dumps(self.result)
        self.assertEqual(copy.deepcopy(self.result).free_run().t[0], self.result.free_run().t[0])
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
        for name in ("equation.json", "metrics.json"):
            self.assertEqual((self.folder / "cli" / name).read_bytes(), (self.folder / "here" / name).read_bytes())
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
        before = os.getcwd()
        os.chdir(self.folder)
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                exec("\n".join(lines), names)
        finally:
            os.chdir(before)
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
        bodies = ardent.Recording({"x [mm]": 1e3 * np.column_stack((self.x, 2 * self.x))}, rate_hz=100)
        self.assertEqual([(one.role, one.body, one.unit) for one in bodies.channels], [("x", 1, "m"), ("x", 2, "m")])
        np.testing.assert_allclose(bodies.samples[:, 1], 2 * self.x, rtol=1e-14, atol=0)  # rounded twice
        column = ardent.Recording({"x": self.x[:, None]}, rate_hz=100)
        self.assertEqual(column.channels[0].role, "x")

    def test_numbers_that_are_not_real_or_not_there(self):
        hidden = np.ma.masked_array(self.x, mask=np.arange(self.x.size) == 1000)
        masked = ardent.Recording({"x": hidden}, rate_hz=100)
        self.assertTrue(any(one.from_s <= 10.0 <= one.to_s for one in masked.bad))
        stamps = np.datetime64("2026-03-01T12:00") + (10 * np.arange(self.x.size)).astype("timedelta64[ms]")
        self.assertAlmostEqual(ardent.Recording({"t": stamps, "x": self.x}).rate_hz, 100.0)
        for wrong in (self.x + 1j, np.array(["a", "b"]), np.array([None] * 9), np.zeros(0), np.zeros((2, 2, 2))):
            with self.assertRaises(ardent.UsageError):
                ardent.Recording({"x": wrong}, rate_hz=100)

    def test_names_units_roles_and_clock(self):
        arrays = {"t": self.t, "weg [mm]": 1e3 * self.x, "motor": 1e-3 * self.f}
        found = ardent.Recording(arrays, units={"motor": "kN"}, roles={"motor": "f", "weg": "x"}, name="hof")
        self.assertAlmostEqual(found.rate_hz, 100.0)
        np.testing.assert_allclose(found["x"], self.x, rtol=1e-14, atol=0)  # rounded twice
        np.testing.assert_allclose(found["f"], self.f, rtol=1e-14, atol=0)
        self.assertEqual([one.unit for one in found.channels], ["m", "N"])
        self.assertEqual(found.num_samples, self.x.size)
        self.assertEqual(list(found), ["weg", "motor"])
        saved = ardent.read(found.save(self.folder / "hof"))
        self.assertEqual(saved.channels, found.channels)
        np.testing.assert_array_equal(saved.samples, found.samples)
        # What is said of one array changes nothing in the others.
        plain = ardent.Recording({"x": self.x, "f": self.f}, rate_hz=100)
        for said in ({"units": {"f": "N"}}, {"roles": {"f": "f"}}, {"bodies": {}}):
            self.assertEqual(ardent.Recording({"x": self.x, "f": self.f}, rate_hz=100, **said).channels, plain.channels)
        named = ardent.Recording({"x": self.x, "Kraft \U0001f600": self.f}, rate_hz=100,
                                 units={"Kraft \U0001f600": "N"}, roles={"Kraft \U0001f600": "f"}, name="\U0001f600")
        np.testing.assert_array_equal(ardent.read(named.save(self.folder / "smile"))["f"], self.f)

    def test_what_is_there_is_left_alone(self):
        (self.folder / "mine.npz").write_bytes(b"mine")
        with self.assertRaises(ardent.OutputError):
            self.recording.save(self.folder / "mine")
        self.assertEqual([one.name for one in self.folder.iterdir()], ["mine.npz"])
        (self.folder / "swing.npz").write_bytes(b"mine")
        with self.assertRaises(ardent.UsageError):
            ardent.identify(self.recording, self.folder / "run", set={"library.ordre": 3})
        self.assertEqual(sorted(one.name for one in self.folder.iterdir()), ["mine.npz", "swing.npz"])
        for _ in range(2):  # the same arrays are the same file
            ardent.identify(self.recording, self.folder / "run", rows=False, figures=False, force=True)
        self.assertEqual(sorted(one.name for one in self.folder.iterdir()),
                         ["mine.npz", "run", "swing-2.npz", "swing-2.npz.toml", "swing.npz"])

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
        again = [ardent.prepare(self.recording)["x"] for _ in range(5)]  # would take memory that was given back
        np.testing.assert_array_equal(samples[:, 0], self.x)
        for one in again:
            np.testing.assert_array_equal(x, one)

    def test_arrays_are_not_doubled(self):
        """160 MB of arrays, prepared at a thousandth of their rate: less than a quarter of that is added."""
        code = ("import numpy as np, ardent\n"
                "x = np.zeros(10_000_000); t = np.zeros(10_000_000)\n"
                "for k in range(0, x.size, 1000): x[k:k + 1000] = np.sin(2e-4 * np.arange(k, k + 1000))\n"
                "t[:] = x\n"
                "recording = ardent.Recording({'x': x, 'f': t}, rate_hz=1e5)\n"
                "def peak(): return int(open('/proc/self/status').read().split('VmHWM:')[1].split()[0])\n"
                "open('/proc/self/clear_refs', 'w').write('5'); before = peak()\n"
                "WORK\n"
                "print(peak() - before)\n")

        def added(work):
            said = subprocess.run([sys.executable, "-c", code.replace("WORK", work)], capture_output=True, text=True)
            self.assertEqual(said.returncode, 0, said.stderr)
            return int(said.stdout)

        self.assertGreater(added("copies = x.copy(), t.copy()"), 150_000)
        self.assertLess(added("ardent.prepare(recording, rate_hz=100, cutoff_hz=40)"), 40_000)

    def test_memory_that_is_refused_is_an_exception(self):
        code = ("import resource, numpy as np, ardent\n"
                "recording = ardent.Recording({'x': np.zeros(20_000_000)}, rate_hz=100)\n"
                "used = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()\n"
                "resource.setrlimit(resource.RLIMIT_AS, (used + 50_000_000,) * 2)\n"
                "try: recording.samples\n"
                "except MemoryError: print('goes on')\n")
        said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        self.assertEqual((said.returncode, said.stdout), (0, "goes on\n"), said.stderr)

    def test_predict_test_recordings_and_frc(self):
        _, x, f = oscillator(40118)
        other = ardent.Recording({"x": x, "f": f}, rate_hz=100, name="other")
        prediction = self.result.predict(other)
        self.assertLess(prediction.nmse, 1e-3)
        self.assertIn("t", prediction.table)
        self.assertEqual(prediction.table["t"].dtype, np.dtype(float))
        both = ardent.identify([self.recording, other], self.folder / "both", rows=False, figures=False)
        self.assertEqual({term.name for term in both.equation.terms}, {"x", "v", "x^3", "f"})
        tested = ardent.identify(self.recording, test=other, rows=False, figures=False)
        self.assertLess(tested.tests[0]["nmse"], 1e-3)
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
        with self.assertRaises(KeyError):
            result.free_run("3")
        self.assertIn("a2 = ", repr(result))

    def test_errors_have_name_and_remedy(self):
        with self.assertRaises(ardent.InputError) as missing:
            ardent.identify(self.folder / "nothing.csv")
        self.assertEqual(missing.exception.name, "file.missing")
        with self.assertRaises(ardent.UsageError) as setting:
            ardent.identify(self.recording, set={"library.ordre": 3})
        self.assertIn("order", str(setting.exception))
        with self.assertRaises(ardent.UsageError):
            ardent.Recording({"x": self.x}, rate_hz=100, roles={"y": "y"})
        with self.assertRaises(ardent.InputError) as rate:
            ardent.Recording({"x": self.x})
        self.assertIn("rate_hz=", str(rate.exception))
        with self.assertRaises(ardent.InputError) as unit:
            ardent.Recording({"x": self.x, "motor": self.f}, rate_hz=100, roles={"motor": "f"})
        self.assertIn("units=", str(unit.exception))
        with self.assertRaises(ardent.UsageError):
            ardent.load(self.folder)
        with self.assertRaises(ardent.UsageError) as lengths:
            ardent.Recording({"x": self.x, "f": self.f[:-1]}, rate_hz=100)
        self.assertIn("3999", str(lengths.exception))
        with self.assertRaises(ardent.UsageError):
            self.result.predict(["a.csv", "b.csv"])
        with self.assertRaises(ardent.InputError):  # of a generator, as of a list
            ardent.identify(name for name in [self.folder / "nothing.csv"])
        for wrong in (lambda: ardent.Recording([self.x, self.f], rate_hz=100), lambda: ardent.identify({"x": self.x}),
                      lambda: ardent.Recording({"x": self.x}, rate_hz="fast"), lambda: ardent.identify(self.x),
                      lambda: ardent.Recording({"x": self.x}, rate_hz=100, units={"x": "furlong"}),
                      lambda: ardent.Recording({"x": self.x}, rate_hz=100, units="mm"),
                      lambda: ardent.Recording({"x": self.x}, rate_hz=100, roles={"x": "force"}),
                      lambda: ardent.find_regimes(self.recording),
                      lambda: self.result.export("pyton", self.folder / "x"),
                      lambda: ardent.identify(self.recording, set=["library.order=5"])):
            with self.assertRaises(ardent.UsageError) as refused:
                wrong()
            self.assertNotIn("no option --", str(refused.exception))
        with self.assertRaises(ardent.UsageError) as batch:
            ardent.command("batch", "a.toml", "b.csv", folder=self.folder / "batch")
        self.assertEqual(batch.exception.name, "command.process")
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
        ticks = []
        stopper = threading.Timer(0.8, os.kill, (os.getpid(), signal.SIGINT))
        ticking = threading.Timer(0.3, lambda: ticks.append(time.monotonic()))
        ticking.start()
        stopper.start()
        begun = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            ardent.identify(wide, self.folder / "stopped", set={"library.order": 9})
        self.assertLess(time.monotonic() - begun, 10.0)  # of a run of minutes; the machine may be busy
        self.assertTrue(ticks and ticks[0] - begun < 0.75)
        self.assertEqual(list(self.folder.iterdir()), [])
        with self.assertRaises(KeyboardInterrupt):  # Python's own handler is back
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(5.0)
        self.assertEqual(ardent.command("terms").code, 0)

    def test_threads_at_once(self):
        found = []
        identify = lambda: found.append(ardent.identify(self.recording, rows=False, figures=False))
        work = [threading.Thread(target=identify) for _ in range(2)]
        for one in work:
            one.start()
        for one in work:
            one.join()
        self.assertEqual(len(found), 2)
        texts = {json.dumps(one.found, sort_keys=True) for one in (*found, self.result)}
        self.assertEqual(len(texts), 1)


if __name__ == "__main__":
    unittest.main()
