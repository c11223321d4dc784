"""Comparison of two images."""

from __future__ import annotations

import html
import os
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _nephroid
from ._errors import SettingError


@dataclass(frozen=True)
class Comparison:
    """Figures of the difference of two images, as ``nephroid compare --json`` has them."""

    #: All figures by name.
    report: dict[str, Any]

    @property
    def verdict(self) -> str:
        """``equivalent``, ``undecided`` or ``different``, within the margin."""
        return str(self.report["verdict"])

    @property
    def layers(self) -> list[dict[str, Any]]:
        """Figures layer by layer."""
        return list(self.report["layers"])

    def __repr__(self) -> str:
        return f"<nephroid.Comparison {self.verdict}, {len(self.layers)} layers>"

    def _repr_html_(self) -> str:
        names = ", ".join(str(one.get("name", one.get("layer", ""))) for one in self.layers)
        return f"<p><b>{html.escape(self.verdict)}</b>: {html.escape(names)}</p>"


def _side(image: Any, name: str) -> Any:
    if isinstance(image, (_nephroid.Film, str, os.PathLike)):
        return image
    array = np.asarray(image, dtype=np.float64)
    if array.ndim == 2:
        array = np.repeat(array[:, :, None], 3, axis=2)
    if array.ndim != 3 or array.shape[2] != 3:
        raise SettingError(f"{name} has the shape {array.shape}; allowed are (rows, columns) and (rows, columns, 3)")
    return np.ascontiguousarray(array)


def compare(a: Any, b: Any, margin: float | None = None) -> Comparison:
    """Compares two images: films, arrays or tensors (rows, columns, 3), or EXR files. ``b`` is the reference unless
    only ``a`` has error bars. ``margin`` is the difference that matters, relative to the reference's mean."""
    return Comparison(_nephroid.compare(_side(a, "a"), _side(b, "b"), margin))
