"""Recordings: a file, or arrays of NumPy, with what is known of their channels."""

from __future__ import annotations

import json
import math
import os
import pathlib
import re
import shutil
import tempfile
import zipfile
from dataclasses import dataclass
from typing import Iterator, Mapping, Optional, Union

import numpy as np

from . import _ardent
from ._errors import InputError, OutputError, UsageError

Path = Union[str, "os.PathLike[str]"]


@dataclass(frozen=True)
class Channel:
    name: str
    role: str  #: "x", "y", "r", "ddy", "f", ..., or "other"
    unit: str  #: of the samples: SI
    body: int  #: of several, from 1; 0: there is one
    calibrated: bool


@dataclass(frozen=True)
class Interval:
    """That must not be used, in seconds from the first sample."""

    from_s: float
    to_s: float
    why: str


@dataclass(frozen=True)
class Check:
    """One thing looked at in the data; `status` is "ok", "note", "warning" or "failed"."""

    name: str
    channel: str
    status: str
    message: str


_UNIT = re.compile(r"\s*[\[(][^\[(]*[\])]\s*$")  # what is behind the name in "x [mm]"


#: Of arrays, by the name of what is wrong: of files a sidecar is to say it.
_REMEDIES = {
    "rate.missing": "neither rate_hz nor a clock among the arrays; want rate_hz=, or an array t in seconds",
    "calibration.missing": "an array with a role and no unit; want units=, as units={\"motor\": \"N\"}",
    "clock.jitter": "the times are not even; want even ones, as np.interp(np.arange(t[0], t[-1], step), t, x)",
    "clock.repeated": "times repeat; leave t out and give rate_hz=, if the samples are even",
}
_NAMES = ('In Python: roles={"NAME": "x"} (y, r, ddy, ddr, f, ...), units={"NAME": "mm"}, bodies={"NAME": 1} say of an '
          "array what its name does not.")
_UNITS = "m, mm, um, in, m/s, m/s^2, g, N, kN, rad, deg, V"


def _pairs(what: str, given: object, example: str) -> list:
    """Names and values; of a structured array its fields."""
    if given is None:
        return []
    if isinstance(given, np.ndarray) and given.dtype.names:
        return [(name, given[name]) for name in given.dtype.names]
    if not hasattr(given, "items"):
        raise UsageError(f"{what} is of type {type(given).__name__}; want names and values, as {example}", "array.kind")
    return list(given.items())


def toml_text(text: str) -> str:
    """A text of TOML."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _beside(file: pathlib.Path) -> pathlib.Path:
    """The sidecar of a recording."""
    return file.with_name(file.name + ".toml")


def put(made: pathlib.Path, there: pathlib.Path) -> None:
    """Under another name on the same disk, if nothing has that name."""
    try:
        os.link(made, there)
    except FileExistsError:
        raise
    except OSError:  # a disk without links
        with open(made, "rb") as source, open(there, "xb") as out:
            shutil.copyfileobj(source, out)


def _readable(name: str, values: object) -> np.ndarray:
    """As it can be read without a copy; a copy where it cannot: flags, long doubles, times (in seconds), masked values
    (which are missing), and what runs backwards."""
    if np.ma.isMaskedArray(values):
        values = np.ma.filled(np.ma.asarray(values).astype(np.float64), np.nan)
    array = np.asarray(values)
    kind = array.dtype.kind
    if array.size == 0 or array.ndim > 2:
        raise UsageError(f"'{name}' is of shape {array.shape}; want a vector, or a matrix with a column a channel",
                         "array.shape")
    if kind == "M":
        array = (array - array.flat[0]) / np.timedelta64(1, "s")
    elif kind == "m":
        array = array / np.timedelta64(1, "s")
    elif kind == "b" or (kind == "f" and array.dtype.itemsize > 8):
        array = array.astype(np.float64)
    elif kind not in "iuf":
        raise UsageError(f"'{name}' holds {array.dtype}; want real numbers, as {name}.real or {name}.astype(float)",
                         "array.kind")
    if any(stride <= 0 for side, stride in zip(array.shape, array.strides) if side > 1):
        array = np.ascontiguousarray(array)
    return array


class Recording:
    """Simultaneous channels on one clock.

    From arrays: ``Recording({"x [mm]": x, "f": f}, rate_hz=200)``. A time column (``t``) may stand in the place of the
    rate. Names and units are understood as those in the head of a CSV file; `units`, `roles` and `bodies` say of an
    array what its name does not (``units={"motor": "kN"}, roles={"motor": "f"}``). Of a matrix each column is one,
    NAME_1, NAME_2, ... Arrays are read where they lie whenever they are used, and not copied unless their numbers have
    to be converted (flags, long doubles, times, masked arrays).

    From a file: ardent.read().
    """

    def __init__(self, arrays: Mapping[str, object], rate_hz: Optional[float] = None, *,
                 units: Optional[Mapping[str, str]] = None, roles: Optional[Mapping[str, str]] = None,
                 bodies: Optional[Mapping[str, int]] = None, name: str = "recording"):
        if not name or name.startswith((".", "-")) or any(sign in name for sign in "/\\\0\n"):
            raise UsageError(f"a recording cannot be called '{name}'; want a name that a file could have", "array.name")
        named = _pairs("arrays", arrays, "ardent.Recording({\"x\": x, \"f\": f}, rate_hz=100)")
        unused = {key: unit for key, unit in _pairs("units", units, "units={\"x\": \"mm\"}") if unit}
        roles = dict(_pairs("roles", roles, "roles={\"motor\": \"f\"}"))
        bodies = dict(_pairs("bodies", bodies, "bodies={\"floor\": 2}"))
        for unit in unused.values():
            if not _ardent.is_unit(str(unit)):
                raise UsageError(f"units: '{unit}' is not known; want such as {_UNITS}", "unit.unknown")
        try:
            rate_hz = None if rate_hz is None else float(rate_hz)
        except (TypeError, ValueError):
            raise UsageError(f"rate_hz is {rate_hz!r}; want a number", "array.rate") from None
        if rate_hz is not None and not (math.isfinite(rate_hz) and rate_hz > 0):
            raise UsageError(f"rate_hz is {rate_hz}; want samples a second, above 0", "array.rate")
        self.path: Optional[pathlib.Path] = None
        self.name = name
        self.rate_is_given = rate_hz is not None
        self._arrays: "dict[str, np.ndarray]" = {}
        for key, values in named:
            own = str(key)
            base = _UNIT.sub("", own)
            unit = unused.pop(own, None) or unused.pop(base, None)
            called = f"{base} [{unit}]" if unit else own
            if not own or any(sign in own for sign in "/\\\0\n") or called in self._arrays:
                raise UsageError(f"an array cannot be called '{own}'; want a name without / that no other has",
                                 "array.name")
            self._arrays[called] = _readable(own, values)
        if unused:
            known = ", ".join(str(key) for key, _ in named)
            raise UsageError(f"units: there is no array {', '.join(unused)}, only {known}", "array.name")
        # A number by itself is a parameter; of a matrix either side may be time.
        lengths = {called: array.size for called, array in self._arrays.items()
                   if array.size > 1 and max(array.shape) == array.size}
        if len(set(lengths.values())) > 1:
            listed = ", ".join(f"{one} has {count} values" for one, count in lengths.items())
            raise UsageError(f"arrays differ in length: {listed}; want one length", "array.length")
        self._options: dict = {}
        try:
            self._source = _ardent.Source(f"{name}.npz", list(self._arrays.items()), rate_hz,
                                          {str(key): str(role) for key, role in roles.items()},
                                          {str(key): int(body) for key, body in bodies.items()})
            self._begin()
        except InputError as error:
            if error.name in _REMEDIES:
                raise InputError(f"{name}: {_REMEDIES[error.name]}", error.name) from None
            raise InputError(f"{error.args[0]} {_NAMES}", error.name) from None
        except UsageError as error:
            raise UsageError(f"{error.args[0]} {_NAMES}", error.name) from None
        except (TypeError, ValueError) as error:
            raise UsageError(f"{name}: {error}. {_NAMES}", "array.role") from None

    @classmethod
    def _of_file(cls, file: Path, options: dict) -> "Recording":
        self = cls.__new__(cls)
        self.path = pathlib.Path(file)
        self.name = self.path.stem
        self._arrays, self._options = {}, options
        self._source = _ardent.Source(self.path, **options)
        self._begin()
        return self

    def _begin(self) -> None:
        found = self._source.describe()
        self.rate_hz: float = found["rate_hz"]
        self.num_samples: int = found["num_samples"]
        self.channels = [Channel(*one) for one in found["channels"]]
        self._read: Optional[tuple] = None

    @property
    def duration_s(self) -> float:
        return self.num_samples / self.rate_hz

    @property
    def t(self) -> np.ndarray:
        """Seconds from the first sample."""
        return np.arange(self.num_samples) / self.rate_hz

    @property
    def samples(self) -> np.ndarray:
        """num_samples x channels in SI units, not to be written. Of a file they are read once, when first asked for; of
        arrays each time."""
        return self._all()[0]

    @property
    def bad(self) -> "list[Interval]":
        return [Interval(*one) for one in self._all()[1]]

    @property
    def checks(self) -> "list[Check]":
        return [Check(*one) for one in self._all()[2]]

    def _all(self) -> tuple:
        if self._read is not None:
            return self._read
        read = self._source.read()
        if self.path is not None:
            self._read = read
        return read

    def __getitem__(self, name: str) -> np.ndarray:
        """The samples of a channel, by its name or its role."""
        for of in ("name", "role"):
            for k, channel in enumerate(self.channels):
                if getattr(channel, of) == name:
                    return self.samples[:, k]
        raise KeyError(f"{name!r}; there are {', '.join(self)}")

    def __iter__(self) -> Iterator[str]:
        return (channel.name for channel in self.channels)

    def __contains__(self, name: object) -> bool:
        return any(name in (channel.name, channel.role) for channel in self.channels)

    def __repr__(self) -> str:
        names = ", ".join(f"{one.name} [{one.unit}]" + ("" if one.role in (one.name, "other") else f" as {one.role}")
                          for one in self.channels)
        return f"<ardent.Recording {self.name}: {names}; {self.duration_s:g} s at {self.rate_hz:g} Hz>"

    def save(self, file: Path) -> pathlib.Path:
        """Arrays as FILE.npz, with FILE.npz.toml beside it for what their names do not say. Files that are there are
        left alone: raises OutputError."""
        if self.path is not None:
            raise UsageError(f"{self.name} is a file already: {self.path}", "array.file")
        file = pathlib.Path(file)
        if file.suffix != ".npz":
            file = file.with_name(file.name + ".npz")
        sidecar = _beside(file)
        try:
            with tempfile.TemporaryDirectory(prefix=".ardent-", dir=file.parent) as folder:
                written = pathlib.Path(folder) / "arrays"
                self._write(written)
                put(_beside(written), sidecar)
                try:
                    put(written, file)
                except OSError:
                    sidecar.unlink()
                    raise
        except FileExistsError:
            raise OutputError(f"{file} or {sidecar.name} exists. Choose another name", "output.exists") from None
        except OSError as error:
            raise OutputError(f"{file} cannot be written: {error.strerror}. Choose another place",
                              "output.path") from None
        return file

    def _write(self, file: pathlib.Path) -> None:
        """Arrays and sidecar, in a folder of our own."""
        with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
            for name, array in self._arrays.items():
                member = zipfile.ZipInfo(f"{name}.npy")  # of 1980: the same arrays are the same bytes
                with archive.open(member, "w", force_zip64=True) as npy:
                    np.lib.format.write_array(npy, array, allow_pickle=False)
        _beside(file).write_text(self._sidecar_text(), encoding="utf-8")

    def _sidecar_text(self) -> str:
        text = f"rate = {self.rate_hz!r}\n" if self.rate_is_given else "# of the arrays beside it\n"
        for name, column, role, body in self._source.described():
            text += f"\n[[channel]]\nname = {toml_text(name)}\ncolumn = {toml_text(column)}\n"
            text += "" if role == "other" else f"role = {toml_text(role)}\n"
            text += f"body = {body}\n" if body else ""
        return text


def read(file: Path, *, sidecar: Path = "", salvage: bool = False, uncalibrated: bool = False,
         use: Optional[Mapping[str, str]] = None, run: int = 0) -> Recording:
    """A recording of any kind that the program reads. Its samples are read when they are asked for.

    `sidecar`: left out, NAME.ext.toml beside the file, if there. `use`: role -> channel. `run`: which of several runs
    side by side in a table, from 1. Raises InputError, UsageError.
    """
    return Recording._of_file(file, {"sidecar": os.fspath(sidecar), "salvage": salvage, "uncalibrated": uncalibrated,
                                     "use": dict(use or {}), "run": run})
