"""Meshes as the bytes of a PLY file."""

from __future__ import annotations

import os
import tempfile
from typing import Any

import numpy as np

#: Arrays of a mesh, by the names that Mitsuba gives them, with their columns.
ARRAYS = {"vertex_positions": 3, "faces": 3, "vertex_normals": 3, "vertex_texcoords": 2}


def ply(arrays: dict[str, Any]) -> bytes:
    """A PLY of arrays. Positions keep 64 bits if they have them."""
    columns = {name: _columns(name, arrays[name], width) for name, width in ARRAYS.items() if name in arrays}
    faces = columns.pop("faces")
    count = len(columns["vertex_positions"])
    names = {"vertex_positions": "xyz", "vertex_normals": ("nx", "ny", "nz"), "vertex_texcoords": "uv"}
    for name, values in columns.items():
        if len(values) != count:
            raise ValueError(f"{name} has {len(values)} rows and vertex_positions {count}; allowed is the same number")
    wrong = faces[(faces < 0) | (faces >= count) | (faces != np.floor(faces))]
    if len(wrong):
        raise ValueError(f"faces names vertex {wrong[0]}; allowed are whole numbers 0..{count - 1}")
    fields: list[tuple[str, str]] = []
    head = [f"element vertex {count}"]
    for name, values in columns.items():
        is_single = values.dtype in (np.float32, np.float16)
        for field in names[name]:
            fields.append((field, "<f4" if is_single else "<f8"))
            head.append(f"property {'float' if is_single else 'double'} {field}")
    vertices = np.empty(count, dtype=fields)
    for name, values in columns.items():
        for column, field in enumerate(names[name]):
            vertices[field] = values[:, column]
    corners = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", (3,))])
    corners["count"] = 3
    corners["corners"] = faces
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    start = "\n".join(["ply", "format binary_little_endian 1.0", *head, "end_header", ""])
    return start.encode() + vertices.tobytes() + corners.tobytes()


def _columns(name: str, array: Any, width: int) -> Any:
    values = np.asarray(array)
    if values.dtype.kind not in "fiu" or not (values.ndim == 1 and values.size % width == 0 or values.shape[1:] == (width,)):
        raise ValueError(
            f"{name} is an array of shape {values.shape} and type {values.dtype}; allowed are numbers of shape (n, {width}) or "
            f"({width} n,)"
        )
    return values.reshape(-1, width)


def arrays_of(mesh: Any) -> dict[str, Any]:
    """The arrays of a mesh that Mitsuba holds."""
    arrays = {
        "vertex_positions": np.asarray(mesh.vertex_positions_buffer()),
        "faces": np.asarray(mesh.faces_buffer()),
    }
    if mesh.has_vertex_normals():
        arrays["vertex_normals"] = np.asarray(mesh.vertex_normals_buffer())
    if mesh.has_vertex_texcoords():
        arrays["vertex_texcoords"] = np.asarray(mesh.vertex_texcoords_buffer())
    return arrays


def written(value: Any, method: str, suffix: str) -> bytes:
    """What an object of Mitsuba writes by itself."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "file" + suffix)
        getattr(value, method)(path)
        with open(path, "rb") as file:
            return file.read()
