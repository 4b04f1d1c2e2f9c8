from typing import Any, Callable, Mapping, Sequence

import numpy as np

version: str

class Source:
    def __init__(self, *args: Any, **options: Any) -> None: ...
    def described(self) -> list[tuple[str, str, str, int]]: ...
    def describe(self) -> dict[str, Any]: ...
    def read(self) -> tuple[np.ndarray, list[tuple[float, float, str]], list[tuple[str, str, str, str]]]: ...

class Prepared:
    rate_hz: float
    cutoff_hz: float
    edge_samples: int
    checks: list[tuple[str, str, str, str]]
    excluded: list[tuple[float, float, str]]
    signals: Mapping[str, tuple[np.ndarray, str]]
    is_excluded: np.ndarray

def prepare(source: Source, *, rate_hz: float, cutoff_hz: float, recipe: str, num_threads: int) -> Prepared: ...
def find_regimes(prepared: Prepared, *, stick_speed_m_per_s: float, stick_duration_s: float,
                 high_amplitude_m: float) -> list[tuple[str, float, float, str, float]]: ...
def command(words: Sequence[str], said: Callable[[str], None]) -> tuple[int, str, list[str], list[str]]: ...
