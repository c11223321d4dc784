"""Writes src/spectrum/daylight/data/*.f32 from the tables that Mitsuba 3.9.1 ships.

    pip install mitsuba==3.9.1 numpy==2.4.6
    python tests/mitsuba/sunsky_tables.py

They are Hosek's and Wilkie's (LICENSE-SKY beside them). The sun's irradiance is their radiance integrated over its disc
by Mitsuba's authors. Single precision, little-endian, the last index fastest.
"""
import pathlib
import struct
import mitsuba
import numpy as np

FROM = pathlib.Path(mitsuba.__file__).parent / "data" / "sunsky"
TO = pathlib.Path(__file__).parents[2] / "src" / "spectrum" / "daylight" / "data"


def tensors(path):
    """The arrays of a tensor file: a head, then for each its name, dimensions, type, offset and shape."""
    data = path.read_bytes()
    assert data[:12] == b"tensor_file\0"
    (count,) = struct.unpack_from("<I", data, 14)
    at, found = 18, {}
    for _ in range(count):
        (length,) = struct.unpack_from("<H", data, at)
        name = data[at + 2:at + 2 + length].decode()
        at += 2 + length
        (dimensions, kind, offset) = struct.unpack_from("<HBQ", data, at)
        shape = struct.unpack_from(f"<{dimensions}Q", data, at + 11)
        at += 11 + 8 * dimensions
        found[name] = np.frombuffer(data, {10: "<f4", 11: "<f8"}[kind], int(np.prod(shape)), offset)
    return found


sky, sampling = tensors(FROM / "sunsky_datasets.bin"), tensors(FROM / "sampling_data.bin")
for name, table in [
    ("sky-shape", sky["sky_params_rgb"]),
    ("sky-radiance", sky["sky_rad_rgb"]),
    ("sun-irradiance", sampling["sun_irradiance"]),
]:
    table.astype("<f4").tofile(TO / f"{name}.f32")
