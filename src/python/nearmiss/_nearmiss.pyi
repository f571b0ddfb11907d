# Types of the compiled module; mypy's stubtest compares them with it.

from collections.abc import Callable, Sequence
from datetime import timedelta
from os import PathLike
from pathlib import Path
from typing import Any, Protocol, TypeAlias, final

class _ArrowStream(Protocol):
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...

class _ArrowArray(Protocol):
    def __arrow_c_array__(self, requested_schema: object | None = None) -> tuple[object, object]: ...

_Path: TypeAlias = str | PathLike[str]
_Paths: TypeAlias = _Path | Sequence[_Path]
_Tracks: TypeAlias = _ArrowStream | _ArrowArray | Any  # Any: a DataFrame of an older pandas
_Moment: TypeAlias = int | float | timedelta | str
_Names: TypeAlias = str | Sequence[str]
_Setting: TypeAlias = str | int | float | bool
_Planner: TypeAlias = str | Callable[[dict[str, Any]], dict[str, Any]]

__version__: str

class Error(Exception):
    file: str | None
    line: int | None

@final
class Table:
    @property
    def columns(self) -> dict[str, str]: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...
    def __len__(self) -> int: ...
    def _repr_html_(self) -> str: ...
    def rows(self) -> list[dict[str, Any]]: ...
    def to_pandas(self) -> Any: ...
    def to_polars(self) -> Any: ...
    def write(self, path: _Path) -> None: ...

@final
class Figure:
    @property
    def svg(self) -> str: ...
    def _repr_svg_(self) -> str: ...
    def write(self, path: _Path) -> None: ...

@final
class Window:
    @property
    def task(self) -> str: ...
    @property
    def steps(self) -> tuple[int, int]: ...
    @property
    def description(self) -> str: ...
    @property
    def tokens(self) -> int: ...

@final
class Scenario:
    @property
    def name(self) -> str: ...
    @property
    def file(self) -> str: ...
    @property
    def hash(self) -> str: ...
    @property
    def ego(self) -> int | None: ...
    @property
    def time_step(self) -> float: ...
    @property
    def steps(self) -> range: ...
    @property
    def diagnostics(self) -> list[str]: ...
    def tracks(self) -> Table: ...
    def lanes(self) -> Table: ...
    def measures(
        self, names: _Names | None = None, *, radius: float | None = None, reasons: bool = False
    ) -> Table: ...
    def windows(
        self,
        *,
        length: float | None = None,
        stride: float | None = None,
        radius: float | None = None,
        measures: _Names | None = None,
    ) -> Table: ...
    def encounters(self) -> Table: ...
    def worst(self) -> dict[str, Any]: ...
    def story(self) -> str: ...
    def window(
        self,
        task: str = "collision",
        *,
        at: _Moment | None = None,
        history: int | None = None,
        frame: str | None = None,
        techniques: str | None = None,
        obstacle: int | None = None,
        **settings: _Setting,
    ) -> Window: ...
    def describe(
        self,
        frame: str = "ego",
        *,
        at: _Moment | None = None,
        history: int | None = None,
        obstacle: int | None = None,
        **settings: _Setting,
    ) -> str: ...
    def figure(self, at: _Moment | None = None, *, plot: _Names | None = None, ego_up: bool = False) -> Figure: ...
    def page(self) -> str: ...
    def write(self, path: _Path, *, overwrite: bool = False) -> None: ...

@final
class Drive:
    @property
    def record(self) -> dict[str, Any]: ...
    @property
    def scenario(self) -> Scenario: ...

@final
class Variant:
    @property
    def record(self) -> dict[str, Any]: ...
    @property
    def certificate(self) -> dict[str, dict[str, Any]] | None: ...
    @property
    def scenario(self) -> Scenario | None: ...
    def write(self, folder: _Path) -> Path: ...

def open(
    path: _Path,
    *,
    ego: int | _Path | None = None,
    map: _Path | None = None,
    columns: str | None = None,
    rate: float | None = None,
) -> Scenario: ...
def scenarios(*paths: _Paths) -> list[str]: ...
def from_tracks(
    table: _Tracks,
    *,
    name: str = "tracks",
    ego: int | _Path | None = None,
    map: _Path | None = None,
    columns: str | None = None,
    rate: float | None = None,
) -> Scenario: ...
def inspect(paths: _Paths) -> Table: ...
def measures(
    paths: _Paths,
    names: _Names | None = None,
    *,
    radius: float | None = None,
    reasons: bool = False,
) -> Table: ...
def windows(
    paths: _Paths,
    *,
    length: float | None = None,
    stride: float | None = None,
    radius: float | None = None,
    measures: _Names | None = None,
) -> Table: ...
def encounters(paths: _Paths) -> Table: ...
def drivers() -> list[dict[str, Any]]: ...
def index_batch(
    batch: _Tracks,
    *,
    length: float | None = None,
    stride: float | None = None,
    radius: float | None = None,
    measures: _Names | None = None,
    columns: str | None = None,
    rate: float | None = None,
    map: _Path | None = None,
) -> Table: ...
def measure_batch(
    batch: _Tracks,
    *,
    names: _Names | None = None,
    radius: float | None = None,
    columns: str | None = None,
    rate: float | None = None,
    map: _Path | None = None,
) -> Table: ...
def of_bytes(data: bytes, name: str, *, ego: int | _Path | None = None) -> Scenario: ...
def prompt(window: Window) -> list[dict[str, Any]]: ...
def judge(window: Window) -> dict[str, Any]: ...
def ask(
    window: Window,
    model: str | None = None,
    *,
    base_url: str | None = None,
    budget: float | None = None,
    fresh: bool = False,
    sample: int = 0,
    store: bool = True,
    **settings: _Setting,
) -> dict[str, Any]: ...
def read_verdict(window: Window, answer: str) -> dict[str, Any]: ...
def check(
    text: str,
    scenario: Scenario,
    window: tuple[int, int] | Window | None = None,
    *,
    prompt: str | None = None,
    trajectory: Sequence[tuple[float, float, float]] | None = None,
) -> list[dict[str, Any]]: ...
def plan(
    scenario: Scenario,
    planner: _Planner | None = None,
    *,
    problem: int | None = None,
    traffic: str | None = None,
    **settings: _Setting,
) -> Drive: ...
def attack(
    scenario: Scenario,
    *,
    attacker: int | Sequence[int] | None = None,
    wish: str | None = None,
    attackers: int | None = None,
    candidates: int | None = None,
    seed: int | None = None,
    survive: float | None = None,
    style: str | None = None,
    planner: _Planner | None = None,
    problem: int | None = None,
    **settings: _Setting,
) -> list[Variant]: ...
