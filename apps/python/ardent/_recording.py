"""Recordings: a file, or arrays of NumPy, with what is known of their channels."""

from __future__ import annotations

import json
import os
import pathlib
import re
import zipfile
from dataclasses import dataclass
from typing import Mapping, Optional, Union

import numpy as np

from . import _ardent
from ._errors import UsageError

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


def _named(name: str, values) -> "list[tuple[str, np.ndarray]]":
    """Arrays as they can be read without a copy; a copy where they cannot. A matrix is several, NAME_1, NAME_2, ..."""
    array = np.asarray(values)
    if array.dtype.kind not in "iuf" or array.dtype.itemsize > 8:
        try:
            array = array.astype(np.float64)
        except (TypeError, ValueError):
            raise UsageError(f"'{name}' holds {array.dtype}; want real numbers", "array.kind") from None
    if any(stride <= 0 for side, stride in zip(array.shape, array.strides) if side > 1):
        array = np.ascontiguousarray(array)
    if array.ndim > 2:
        raise UsageError(f"'{name}' has {array.ndim} axes; want a vector, or a matrix with a column a channel", "array.shape")
    if array.ndim < 2:
        return [(name, array)]
    if array.shape[0] < array.shape[1]:
        array = array.T
    return [(f"{name}_{k + 1}", array[:, k]) for k in range(array.shape[1])]


class Recording:
    """Simultaneous channels on one clock.

    From arrays: ``Recording({"x [mm]": x, "f": f}, rate_hz=200)``. A time column (``t``) may stand in the place of the
    rate. Names and units are understood as those in the head of a CSV file; `units`, `roles` and `bodies` say of an array
    what its name does not (``roles={"motor": "f"}``). Arrays are kept, not copied; what is changed in them is changed in
    the recording.

    From a file: ardent.read().
    """

    def __init__(self, arrays: Mapping[str, object], rate_hz: Optional[float] = None, *, units: Mapping[str, str] = {},
                 roles: Mapping[str, str] = {}, bodies: Mapping[str, int] = {}, name: str = "recording"):
        if not name or name.startswith(".") or any(sign in name for sign in "/\\\0\n"):
            raise UsageError(f"a recording cannot be called '{name}'; want a name that a file could have", "array.name")
        self.path: Optional[pathlib.Path] = None
        self.name = name
        self._arrays = dict(pair for key, values in arrays.items() for pair in _named(str(key), values))
        for what, given in (("units", units), ("roles", roles), ("bodies", bodies)):
            for unknown in set(given) - set(self._arrays):
                raise UsageError(f"{what}: there is no array '{unknown}', only {', '.join(self._arrays)}", "array.name")
        self._sidecar = _sidecar_text(self._arrays, rate_hz, units, roles, bodies)
        self._options: dict = {}
        self._source = _ardent.Source(f"{name}.npz", list(self._arrays.items()), self._sidecar)
        self._begin()

    @classmethod
    def _of_file(cls, file: Path, options: dict) -> "Recording":
        self = cls.__new__(cls)
        self.path = pathlib.Path(file)
        self.name = self.path.stem
        self._arrays, self._sidecar, self._options = {}, "", options
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
        """num_samples x channels in SI units, read when first asked for, and not to be written."""
        return self._all()[0]

    @property
    def bad(self) -> "list[Interval]":
        return [Interval(*one) for one in self._all()[1]]

    @property
    def checks(self) -> "list[Check]":
        return [Check(*one) for one in self._all()[2]]

    def _all(self) -> tuple:
        if self._read is None:
            self._read = self._source.read()
        return self._read

    def __getitem__(self, name: str) -> np.ndarray:
        """The samples of a channel, by its name or its role."""
        for of in ("name", "role"):
            for k, channel in enumerate(self.channels):
                if getattr(channel, of) == name:
                    return self.samples[:, k]
        raise KeyError(f"{name!r}; there are {', '.join(channel.name for channel in self.channels)}")

    def __repr__(self) -> str:
        names = ", ".join(f"{one.name} [{one.unit}]" for one in self.channels)
        return f"<ardent.Recording {self.name}: {names}; {self.duration_s:g} s at {self.rate_hz:g} Hz>"

    def save(self, file: Path) -> pathlib.Path:
        """Arrays as FILE.npz with FILE.npz.toml beside it, for the program and for anybody else. Existing files are
        refused."""
        if self.path is not None:
            raise UsageError(f"{self.name} is a file already: {self.path}", "array.file")
        file = pathlib.Path(file)
        if file.suffix != ".npz":
            file = file.with_name(file.name + ".npz")
        # The sidecar first: an archive without it would be read otherwise.
        with open(f"{file}.toml", "x", encoding="utf-8") as sidecar:
            sidecar.write(self._sidecar)
        with open(file, "xb") as out, zipfile.ZipFile(out, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
            for name, array in self._arrays.items():
                member = zipfile.ZipInfo(f"{name}.npy")  # of 1980: the same arrays are the same bytes
                with archive.open(member, "w", force_zip64=True) as npy:
                    np.lib.format.write_array(npy, array, allow_pickle=False)
        return file


_BASE = re.compile(r"\s*[\[(].*[\])]\s*$")  # what is behind the name in "x [mm]"


def _sidecar_text(arrays: Mapping[str, np.ndarray], rate_hz: Optional[float], units: Mapping[str, str],
                  roles: Mapping[str, str], bodies: Mapping[str, int]) -> str:
    text = "" if rate_hz is None else f"rate = {json.dumps(float(rate_hz))}\n"
    if not (units or roles or bodies):
        return text
    for name, array in arrays.items():
        base = _BASE.sub("", name)
        if array.size < 2 or base.lower() in ("t", "time"):
            continue
        text += f"\n[[channel]]\nname = {json.dumps(base)}\ncolumn = {json.dumps(name)}\n"
        if name in units:
            text += f"unit = {json.dumps(units[name])}\n"
        if name in roles:
            text += f"role = {json.dumps(roles[name])}\n"
        if name in bodies:
            text += f"body = {int(bodies[name])}\n"
    return text


def read(file: Path, *, sidecar: Path = "", salvage: bool = False, uncalibrated: bool = False,
         use: Mapping[str, str] = {}, run: int = 0) -> Recording:
    """A recording of any kind that the program reads. Its samples are read when they are asked for.

    `sidecar`: left out, NAME.ext.toml beside the file, if there. `use`: role -> channel. `run`: which of several runs
    side by side in a table, from 1. Raises InputError, UsageError.
    """
    return Recording._of_file(file, {"sidecar": str(sidecar), "salvage": salvage, "uncalibrated": uncalibrated,
                                     "use": dict(use), "run": run})
