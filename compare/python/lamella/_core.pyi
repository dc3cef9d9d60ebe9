from typing import Any, Callable, Optional, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Show = Optional[Callable[[Optional[str]], None]]
Keywords = dict[str, Any]

__version__: str

class Stack:
    name: str
    is_grey: bool
    is_half_space: bool
    is_open_below: bool
    is_symmetric: bool
    is_reciprocal: bool
    def toml(self) -> str: ...
    def save(self, path: str) -> None: ...
    def json(self) -> str: ...

class Model:
    name: str
    doc: str
    source: str
    transmits: bool
    is_built_in: bool
    lobe_names: tuple[str, ...]
    channels: int
    request: str
    parameters: dict[str, Any]
    sources: dict[str, str]
    def eval(self, wi: Array, wo: Array, lobe: str, isa: str) -> Array: ...
    def pdf(self, wi: Array, wo: Array) -> Array: ...
    def sample(self, wo: Array, u: Array) -> Array: ...
    def albedo(self, wi: Array) -> tuple[Array, Array]: ...

class Lobes:
    keys: list[tuple[str, str]]
    theta: Array
    phi: Array
    directions: Array
    mu_edges: Array
    phi_edges: Array
    folded: bool
    channels: int
    attributes: dict[str, str]
    is_bounded: bool
    answer: str
    estimator: str
    interrupted: bool
    def values(self, side: str, name: str) -> Array: ...
    def errors(self, side: str, name: str) -> Array: ...
    def energies(self) -> list[tuple[str, str, Any, Any]]: ...
    def save_exr(self, path: str) -> None: ...
    def save_archive(self, path: str) -> None: ...

class Samples:
    w_i: NDArray[np.float32]
    w_o: NDArray[np.float32]
    weight: NDArray[np.float32]
    order: NDArray[np.uint32]
    side: NDArray[np.int8]
    walks: int
    directions: Array
    direction_walks: NDArray[np.uint64]
    direction_rows: NDArray[np.uint64]
    about: str
    interrupted: bool
    def save(self, path: str) -> int: ...

class Report:
    answer: str
    summary: str
    page: str
    names: list[str]
    worst_relative_rmse: float
    interrupted: bool
    def truth(self) -> Lobes: ...
    def save(self, folder: str, pictures: Sequence[str]) -> None: ...

class Family:
    name: str

class Fits:
    answer: str
    summary: str
    interrupted: bool
    def report(self) -> Report: ...

class Check:
    answer: str
    text: str
    page: str
    interrupted: bool

def models() -> list[dict[str, Any]]: ...
def media() -> list[dict[str, Any]]: ...
def stacks() -> list[dict[str, Any]]: ...
def directions_from_degrees(theta: Array, phi: Array) -> Array: ...
def builtin_stack(name: str) -> Stack: ...
def read_stack(path: str, at: Optional[tuple[float, float]]) -> Stack: ...
def parse_stack(text: str, file: str, name: str) -> Stack: ...
def make_model(text: str, further: Sequence[tuple[str, str]], stack: Optional[Stack]) -> Model: ...
def make_function(name: str, function: Any, transmits: bool) -> Model: ...
def read_measured(path: str) -> Model: ...
def save_brdf(
    model: Model, path: str, format: str, size: str
) -> tuple[int, float, list[str]]: ...
def lobes_of_model(model: Model, keywords: Keywords) -> Lobes: ...
def read_lobes(path: str, part: str) -> Lobes: ...
def simulate(stack: Stack, keywords: Keywords, show: Show) -> tuple[Lobes, list[str]]: ...
def truth(
    stack: Stack, wi: Array, wo: Array, keywords: Keywords, show: Show
) -> tuple[Array, Array, bool, list[str]]: ...
def samples(stack: Stack, keywords: Keywords, show: Show) -> tuple[Samples, list[str]]: ...
def compare(
    stack: Stack, models: Sequence[Any], keywords: Keywords, show: Show
) -> tuple[Report, list[str]]: ...
def compare_measured(
    measured: Model, models: Sequence[Any], keywords: Keywords, show: Show
) -> tuple[Report, list[str]]: ...
def check(
    model: Any, stack: Optional[Stack], reciprocal: Optional[bool], configurations: Optional[int],
    samples: Optional[int], library: str, entries: Sequence[str], keywords: Keywords, show: Show
) -> tuple[Check, list[str]]: ...
def library_index(folder: str) -> str: ...
def library_entry(folder: str, name: str) -> tuple[Lobes, Array, Array, Array, Array]: ...
def make_family(
    name: str, function: Any, ranges: Sequence[tuple[str, float, float, bool]], transmits: bool
) -> Family: ...
def fit(
    target: Any, models: Sequence[Any], norm: str, sides: str, keywords: Keywords, show: Show
) -> tuple[Fits, list[str]]: ...
def fit_stack(
    target: Any, stack: Stack, vary: Sequence[str], norm: str, sides: str, keywords: Keywords,
    show: Show
) -> tuple[Fits, list[str]]: ...
def furnace(
    stack: Stack, model: str, keywords: Keywords, show: Show
) -> tuple[str, list[str]]: ...
def model_furnace(model: Model, keywords: Keywords) -> str: ...
