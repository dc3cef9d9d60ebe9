"""Stacks of layers: read, written as text, made from Python values."""

from __future__ import annotations

import json
import os
from typing import Any, Iterable, Mapping, Optional, Union

from . import _core


class Entry(dict):
    """A table of a stack file: keys and values, as layer(), interface() and substrate() make it."""

    def toml(self) -> str:
        """The lines `key = value`."""
        return "".join(f"{key} = {_value(key, value)}\n" for key, value in self.items())


def _value(key: str, value: Any) -> str:
    """A value as TOML has it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, os.PathLike):
        return json.dumps(os.fspath(value))
    if hasattr(value, "tolist"):  # NumPy's arrays and numbers
        return _value(key, value.tolist())
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return "nan" if value != value else repr(value)
    if isinstance(value, Iterable):
        return "[" + ", ".join(_value(key, v) for v in value) + "]"
    raise ValueError(f'key "{key}": found {value!r}; allowed: a number, a text, or a list of them')


def layer(medium: str, **keys: Any) -> Entry:
    """A layer of a medium, or explicit geometry.

    medium: "sggx", "vmf_flake", "lambert_sphere", "henyey_greenstein", ... (see media()).
    keys: of a stack file: thickness [mm] (required, may be math.inf), density [1/mm], albedo (a
        number or three), and the medium's own.

    >>> layer("sggx", roughness=0.5, thickness=1)
    {'medium': 'sggx', 'roughness': 0.5, 'thickness': 1}
    """
    return Entry(medium=medium, **keys)


def interface(kind: str, **keys: Any) -> Entry:
    """An interface between layers: "smooth", "ggx" or "beckmann"; keys `ior`, `roughness`,
    `scattering`, as in a stack file."""
    return Entry(interface=kind, **keys)


def substrate(bsdf: str, **keys: Any) -> Entry:
    """What lies below the last layer: "lambert", "black", "conductor" or a closed form, with its
    keys."""
    return Entry(bsdf=bsdf, **keys)


class Stack:
    """Layers from the top down, and what lies below: what is simulated, solved and compared with.

    Stack(layers=[layer("sggx", roughness=0.5, thickness=1)], substrate=substrate("lambert"))
    Stack.builtin("vmf_sand"), Stack.read("mine.toml"), Stack.parse(text)

    A stack is immutable; two are equal if their texts are. It can be pickled.
    """

    def __init__(self, layers: Iterable[Mapping[str, Any]],
                 substrate: Optional[Mapping[str, Any]] = None, name: str = "stack") -> None:
        text = "".join("[[layer]]\n" + Entry(entry).toml() + "\n" for entry in layers)
        if substrate is not None:
            text += "[substrate]\n" + Entry(substrate).toml()
        self._core = _core.parse_stack(text, name, name)

    @classmethod
    def _of(cls, core: Any) -> "Stack":
        stack = cls.__new__(cls)
        stack._core = core
        return stack

    @classmethod
    def builtin(cls, name: str) -> "Stack":
        """A built-in stack; lamella.stacks() lists them."""
        return cls._of(_core.builtin_stack(name))

    @classmethod
    def read(cls, path: Union[str, "os.PathLike[str]"],
             at: Optional[tuple[float, float]] = None) -> "Stack":
        """A stack file (TOML). Grids and pictures that it names are relative to it. `at`: the place
        (u, v), both from 0 to 1, on a stack with pictures among its values."""
        return cls._of(_core.read_stack(os.fspath(path), at))

    @classmethod
    def parse(cls, text: str, name: str = "stack") -> "Stack":
        """The text of a stack file; `name` stands in errors as the file's name."""
        return cls._of(_core.parse_stack(text, name, name))

    @property
    def name(self) -> str:
        """Of the built-in stack, or of the file without its ending."""
        return self._core.name

    @property
    def text(self) -> str:
        """The stack file, every default filled in: parse() gives the same stack again."""
        return self._core.toml()

    @property
    def resolved(self) -> dict[str, Any]:
        """Every key of every layer as a dictionary; infinity is the string "inf"."""
        return json.loads(self._core.json())

    @property
    def layers(self) -> list[dict[str, Any]]:
        """Of `resolved`: a dictionary per layer, from the top down."""
        return self.resolved["layer"]

    @property
    def is_grey(self) -> bool:
        """Whether no albedo, f0 or substrate differs between the channels."""
        return self._core.is_grey

    @property
    def is_half_space(self) -> bool:
        """Whether the last layer is infinitely thick."""
        return self._core.is_half_space

    @property
    def is_open_below(self) -> bool:
        """Whether light can come from below, and leave there."""
        return self._core.is_open_below

    @property
    def is_symmetric(self) -> bool:
        """Whether every rotation about z leaves the stack as it is."""
        return self._core.is_symmetric

    @property
    def is_reciprocal(self) -> bool:
        """Whether f(w_i, w_o) = f(w_o, w_i) is known to hold for reflection."""
        return self._core.is_reciprocal

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes the text to a file, grids named relative to it."""
        self._core.save(os.fspath(path))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Stack) and self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return f"<lamella.Stack {self.name}: {len(self.layers)} layers>"

    def __reduce__(self) -> tuple[Any, ...]:
        return Stack.parse, (self.text, self.name)


def as_stack(stack: Union[Stack, str, "os.PathLike[str]"]) -> Stack:
    """A stack, the name of a built-in one, or the path of a stack file."""
    if isinstance(stack, Stack):
        return stack
    if isinstance(stack, (str, os.PathLike)):
        text = os.fspath(stack)
        if "/" in text or text.endswith(".toml"):
            return Stack.read(text)
        return Stack.builtin(text)
    raise ValueError(f"stack: found {stack!r}; allowed: a Stack, the name of a built-in one, or "
                     "the path of a stack file")
