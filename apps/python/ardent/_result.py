"""What a run found, from its folder: the same files that `ardent run` writes."""

from __future__ import annotations

import csv
import html
import json
import os
import pathlib
import shutil
import tempfile
import weakref
from dataclasses import dataclass, field
from typing import Iterator, Optional

import numpy as np

from ._commands import command
from ._errors import UsageError
from ._recording import Path, Recording


@dataclass(frozen=True)
class Term:
    name: str
    mean: float
    std: float  #: standard deviation
    unit: str
    inclusion_probability: Optional[float] = None


@dataclass(frozen=True)
class Equation:
    """One of a range, or of a body."""

    of: str  #: the range's or body's name
    target: str
    terms: "list[Term]"
    verdict: str  #: "describes", "in_part", "does_not", "undecided"
    sentence: str  #: why
    text: str
    covariance: np.ndarray = field(repr=False, compare=False)

    def __iter__(self) -> "Iterator[Term]":
        return iter(self.terms)

    def __len__(self) -> int:
        return len(self.terms)

    def __bool__(self) -> bool:  # also without terms
        return True

    def __contains__(self, term: object) -> bool:
        return any(one.name == term for one in self.terms)

    def __getitem__(self, term: str) -> Term:
        for one in self.terms:
            if one.name == term:
                return one
        raise KeyError(f"{term!r}; there are {', '.join(one.name for one in self.terms)}")

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True)
class Curves:
    """Against t in seconds: what was measured, and the equation on its own."""

    t: np.ndarray
    measured: np.ndarray
    free_run: np.ndarray


class Temporary:
    """A folder that goes with the last that refers to it."""

    def __init__(self) -> None:
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="ardent-"))
        weakref.finalize(self, _remove, self.folder, os.getpid())

    def __deepcopy__(self, _: dict) -> "Temporary":
        return self

    def __reduce__(self):
        raise TypeError("results in a temporary folder stay in their process; give folder= to keep them for others")


def _remove(folder: pathlib.Path, owner: int) -> None:
    if os.getpid() == owner:  # and no fork of it
        shutil.rmtree(folder, ignore_errors=True)


class _Folder:
    """A folder of results."""

    def __init__(self, folder: Path, kept: Optional[Temporary]):
        self.folder = pathlib.Path(folder)
        self._kept = kept

    def _json(self, name: str) -> dict:
        return json.loads((self.folder / name).read_text(encoding="utf-8"))

    def _text(self, name: str) -> str:
        return (self.folder / name).read_text(encoding="utf-8")


def _column(cells: "tuple[str, ...]") -> np.ndarray:
    """Numbers, NaN where a cell is empty; text where it is none."""
    try:
        return np.array([cell or "nan" for cell in cells], dtype=float)
    except ValueError:
        return np.array(cells)


def _columns(file: pathlib.Path) -> "dict[str, np.ndarray]":
    with open(file, newline="", encoding="utf-8") as rows:
        head, *cells = csv.reader(rows)
    return {name: _column(column) for name, column in zip(head, zip(*cells))}


def _curves(folder: pathlib.Path, pattern: str) -> Optional[Curves]:
    files = sorted((folder / "figures").glob(pattern))
    if not files:
        return None
    columns = list(_columns(files[0]).values())
    return Curves(*columns[:3]) if len(columns) >= 3 else None


class _Outcome(_Folder):
    """Of a command that leaves NAME.json and NAME.csv: `found` and `table`, and `text` as the program prints it."""

    _name = ""

    def __init__(self, folder: Path, kept: Optional[Temporary], text: str):
        super().__init__(folder, kept)
        self.found = self._json(f"{self._name}.json")
        self.text = text

    @property
    def table(self) -> "dict[str, np.ndarray]":
        return _columns(self.folder / f"{self._name}.csv")

    def __repr__(self) -> str:
        return self.text.rstrip()


class Prediction(_Outcome):
    """A recording that was not fitted, beside the equation on its own. `table` has the columns of predict.csv; `found`
    is predict.json."""

    _name = "predict"

    @property
    def nmse(self) -> Optional[float]:
        """Of the free run, as a fraction of the power of x; of several bodies the largest. None: it did not reach the
        end."""
        if "bodies" in self.found:
            errors = [body.get("nmse") for body in self.found["bodies"]]
            return None if None in errors else max(errors)
        return self.found.get("nmse")


class Response(_Outcome):
    """A frequency response: `table` has the columns of frc.csv, `found` is frc.json."""

    _name = "frc"


class Result(_Folder):
    """The equation of motion of one or several recordings, with all that was found of it.

    ``print(result)`` is the first screen of the program. `equation` is the one that speaks for the run, None where none
    was found; `equations` has those of all ranges, or of all bodies.
    """

    def __init__(self, folder: Path, kept: Optional[Temporary] = None,
                 warnings: "Optional[list[str]]" = None):
        super().__init__(folder, kept)
        if not (self.folder / "manifest.json").is_file():
            raise UsageError(f"{self.folder} is no folder of a finished run", "run.incomplete")
        #: "[name] message"
        self.warnings = list(self._json("manifest.json").get("warnings", []) if warnings is None else warnings)
        self.found = self._json("equation.json")  #: as docs/reference.md has it
        self.text = self._text("equation.txt")
        self.equations = [*self._of_ranges(), *self._of_bodies()]
        chosen = self.found.get("chosen")
        named = [one for one in self.equations if chosen and one.of == chosen["range"]]
        self.equation: Optional[Equation] = (named or self.equations or [None])[0]

    def _of_ranges(self) -> "list[Equation]":
        chosen, found = self.found.get("chosen"), []
        for one in self.found["ranges"]:
            method = chosen["method"] if chosen and chosen["range"] == one["name"] else one.get("method")
            for fit in one.get("methods", []):
                if fit["method"] == method:
                    found.append(_equation(one["name"], fit, fit["verdict"], fit["sentence"], fit["text"]))
        return found

    def _of_bodies(self) -> "list[Equation]":
        found, at = [], 0
        covariance = np.array(self.found.get("covariance") or np.empty((0, 0)), dtype=float)
        for body in self.found.get("bodies", []):
            count = len(body["terms"])
            own = covariance[at:at + count, at:at + count]
            at += count
            text = f"{body['target']} = " + " + ".join(f"{one['mean']:.6g} {one['name']}" for one in body["terms"])
            fit = {**body, "covariance": own}
            found.append(_equation(str(body["body"]), fit, self.found["verdict"], self.found["sentence"],
                                   text.replace("+ -", "- ")))
        return found

    @property
    def verdict(self) -> str:
        return self.equation.verdict if self.equation is not None else "undecided"

    @property
    def report(self) -> pathlib.Path:
        """The page, one file that needs nothing else."""
        return self.folder / "report.html"

    @property
    def tests(self) -> "list[dict]":
        """Of the recordings that were given as `test`, in order: predict-N-NAME.json."""
        files = sorted(self.folder.glob("predict-*.json"), key=lambda file: int(file.name.split("-")[1]))
        return [self._json(file.name) for file in files]

    @property
    def details(self) -> str:
        return self._text("details.txt")

    def free_run(self, of: str = "") -> Optional[Curves]:
        """Of the test rows of a range, or of a body; left out: those of `equation`. None where there is none, or no
        figures. Raises KeyError for another name."""
        of = of or (self.equation.of if self.equation is not None else "")
        if not of:
            return None
        for number, one in enumerate(self.found["ranges"], 1):
            if one["name"] == of:
                return _curves(self.folder, f"range-{number}-*free-run.csv")
        if all(str(body["body"]) != of for body in self.found.get("bodies", [])):
            raise KeyError(f"{of!r}; there are {', '.join(one.of for one in self.equations)}")
        return _curves(self.folder, f"body-{of}-free-run*.csv")

    def predict(self, recording: "Recording | Path", folder: Optional[Path] = None, *, range: str = "",
                method: str = "", sidecar: Path = "", set: "Optional[dict[str, object]]" = None, force: bool = False,
                num_threads: int = 0) -> Prediction:
        """`ardent predict`: the equation on another recording of the same set-up, read as those of the run were. `set`:
        of [prepare] and [[recording]], such as {"prepare.cutoff_hz": 20} for a lower rate."""
        from ._identify import Place, options_of  # which needs this module

        own = options_of(recording)
        sidecar = os.fspath(sidecar) or str(own.pop("sidecar", ""))
        if own:
            raise UsageError(f"{', '.join(own)}: a recording is predicted as those of the run were read; read it "
                             "without", "recording.options")
        options = [f"--{name}={value}" for name, value in
                   (("range", range), ("method", method), ("sidecar", sidecar)) if value]
        with Place(folder, "predict") as place:
            said = command("predict", self.folder, place.file_of(recording), options=options, folder=place.folder,
                           force=force, num_threads=num_threads, set=set)
            return Prediction(place.folder, place.kept, said.text)

    def frc(self, folder: Optional[Path] = None, *, range: str = "", method: str = "", body: int = 0, input: str = "",
            draws: int = 40, static_friction: Optional[float] = None, set: "Optional[dict[str, object]]" = None,
            seed: int = 1, force: bool = False, num_threads: int = 0) -> Response:
        """`ardent frc`: frequency response, up and down; of several bodies that of one to one input. `set`: from_hz,
        to_hz, step_hz, amplitude_mm (amplitude of a force)."""
        from ._identify import Place

        options = [f"--draws={draws}", f"--seed={seed}"]
        options += [f"--{name}={value}" for name, value in
                    (("range", range), ("method", method), ("body", body or None), ("input", input),
                     ("static-friction", static_friction))
                    if value not in ("", None)]
        with Place(folder, "frc") as place:
            said = command("frc", self.folder, options=options, folder=place.folder, force=force,
                           num_threads=num_threads, set=set)
            return Response(place.folder, place.kept, said.text)

    def export(self, to: str, folder: Path, *, force: bool = False) -> pathlib.Path:
        """`ardent export`: to "python", "matlab", "c", "modelica", "latex", "json" or "fmu"."""
        command("export", self.folder, options=[f"--to={to}"], folder=folder, force=force)
        return pathlib.Path(folder)

    def plot(self, of: str = ""):
        """Free run and measured, and the difference, with matplotlib; returns its figure."""
        from matplotlib import pyplot

        curves = self.free_run(of)
        if curves is None:
            raise UsageError("there is no free run to plot: `text` says why, or figures=False left it out",
                             "plot.no_free_run")
        figure, (above, below) = pyplot.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": (3, 1)})
        above.plot(curves.t, curves.measured, label="measured")
        above.plot(curves.t, curves.free_run, "--", label="free run")
        above.set_ylabel(f"x{of} ({self._length_unit()})")
        above.legend(loc="upper right")
        below.plot(curves.t, curves.measured - curves.free_run)
        below.set_ylabel(f"difference ({self._length_unit()})")
        below.set_xlabel("t (s)")
        return figure

    def _length_unit(self) -> str:
        for one in self.found["ranges"]:
            for fit in one.get("methods", []):
                for coordinates in fit.get("coordinates", []):
                    return coordinates["unit"]
        return self.found.get("length_unit", "m")

    def __str__(self) -> str:
        return self.text.rstrip()

    def __repr__(self) -> str:
        if self.equation is None:
            return f"<ardent.Result: no equation, in {self.folder}>"
        spoken = self.equations if self.found.get("bodies") else [self.equation]
        return "\n".join(one.text for one in spoken) + f"  ({self.verdict})"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


def _equation(of: str, fit: dict, verdict: str, sentence: str, text: str) -> Equation:
    terms = [Term(one["name"], one["mean"], one["std"], one["unit"], one.get("inclusion_probability"))
             for one in fit["terms"]]
    return Equation(of, fit["target"], terms, verdict, sentence, text, np.array(fit["covariance"], dtype=float))


def load(folder: Path) -> Result:
    """The folder of a run that is finished."""
    return Result(folder)
