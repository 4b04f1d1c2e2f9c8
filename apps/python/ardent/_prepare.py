"""From a recording to signals, and their regimes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator

import numpy as np

from . import _ardent
from ._errors import UsageError
from ._recording import Check, Interval, Path, Recording, read


class Prepared:
    """Signals ready for regression, by name: ``prepared["x"]``, "v", "a", "ddr", "f", ...; views on memory that the
    program holds, not to be written."""

    def __init__(self, core: "_ardent.Prepared"):
        self._core = core
        self.rate_hz: float = core.rate_hz
        self.cutoff_hz: float = core.cutoff_hz
        self.edge_samples: int = core.edge_samples  #: at either end, spoilt by filters
        found = core.signals
        self.signals: "dict[str, np.ndarray]" = {name: values for name, (values, _) in found.items()}
        self.units: "dict[str, str]" = {name: unit for name, (_, unit) in found.items()}
        self.is_excluded: np.ndarray = core.is_excluded  #: of each sample
        self.excluded = [Interval(*one) for one in core.excluded]
        self.checks = [Check(*one) for one in core.checks]

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.signals:
            raise KeyError(f"{name!r}; there are {', '.join(self)}")
        return self.signals[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.signals)

    def __repr__(self) -> str:
        size = len(self.is_excluded)
        return f"<ardent.Prepared {', '.join(self.signals)}; {size} samples at {self.rate_hz:g} Hz>"


def prepare(recording: "Recording | Path", *, rate_hz: float = 0.0, cutoff_hz: float = 0.0, recipe: str = "matched",
            num_threads: int = 1) -> Prepared:
    """Low-pass, decimation, x = y - r and derivatives. `rate_hz`, `cutoff_hz` left out: the recording's own rate, and
    0.4 of the rate. `recipe`: "matched", or "paper" as in [QZS23]. Arrays are read where they are. Raises Error."""
    if recipe not in ("matched", "paper"):
        raise UsageError(f"recipe is '{recipe}'; want \"matched\" or \"paper\"", "config.word")
    source = recording if isinstance(recording, Recording) else read(recording)
    return Prepared(_ardent.prepare(source._source, rate_hz=rate_hz, cutoff_hz=cutoff_hz, recipe=recipe,
                                    num_threads=num_threads))


@dataclass(frozen=True)
class Regime:
    """An interval of one kind of motion, in seconds from the first sample."""

    name: str  #: "low", "high", "stick", "excluded"
    from_s: float
    to_s: float
    reason: str
    probability: float  #: of low and high; NaN: not estimated


def find_regimes(prepared: Prepared, *, stick_speed_m_per_s: float = 0.0, stick_duration_s: float = 0.0,
                 high_amplitude_m: float = 0.0) -> "list[Regime]":
    """Amplitude regimes, one after the other. Thresholds left out are chosen from the record itself."""
    if not isinstance(prepared, Prepared):
        raise UsageError(f"find_regimes is given {type(prepared).__name__}; want what ardent.prepare() returns",
                         "array.kind")
    return [Regime(*one) for one in _ardent.find_regimes(prepared._core, stick_speed_m_per_s=stick_speed_m_per_s,
                                                         stick_duration_s=stick_duration_s,
                                                         high_amplitude_m=high_amplitude_m)]
