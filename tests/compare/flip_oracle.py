"""Values of NVIDIA's own FLIP for the image pairs of tests/compare/flip.rs.

    pip install flip-evaluator==1.7 numpy
    python3 tests/compare/flip_oracle.py > tests/compare/flip_oracle.txt

Each line: pair, kind, mean, first and last exposure, number of exposures, then the error of every 7th
texel, row by row. The pairs are formulas, written here and in the Rust test.
"""

import flip_evaluator
import numpy as np

WIDTH, HEIGHT = 61, 47


def coordinates():
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH].astype(np.float64)
    return x, y


def stack(*planes):
    return np.stack(np.broadcast_arrays(*planes), axis=-1).astype(np.float32)


def waves():
    """Smooth colours in 0..1, and the same a little brighter, shifted and tinted."""
    x, y = coordinates()
    red = 0.5 + 0.4 * np.sin(0.21 * x + 0.05 * y)
    green = 0.5 + 0.4 * np.sin(0.13 * y - 0.02 * x)
    blue = 0.5 + 0.4 * np.cos(0.17 * x + 0.11 * y)
    test = 0.5 + 0.4 * np.sin(0.21 * (x + 1.5) + 0.05 * y)
    return stack(red, green, blue), stack(test, 0.95 * green, blue + 0.05)


def edges():
    """A checkerboard of nine texels, and the same of lower contrast with a bright point in every 13th column."""
    x, y = coordinates()
    board = ((x // 9) + (y // 9)) % 2
    test = 0.1 + 0.8 * board + np.where((x % 13 == 6) & (y % 11 == 5), 0.5, 0.0)
    return stack(board, board, board), stack(test, test, test)


def caustic():
    """Grey light over four decades: a bright ring on a dim ground; the other ring is wider."""
    x, y = coordinates()
    distance = np.hypot(x - 30.0, y - 23.0)
    ring = lambda radius: 0.02 + 40.0 / (1.0 + (distance - radius) ** 2)
    return stack(*[ring(12.0)] * 3), stack(*[ring(12.4)] * 3)


def coloured():
    """Coloured light from 1e-3 to 1e2, and the same with an error of some per cent that alternates."""
    x, y = coordinates()
    red = 10.0 ** (-3.0 + 5.0 * x / (WIDTH - 1))
    green = 10.0 ** (-2.0 + 3.0 * y / (HEIGHT - 1))
    blue = 0.3 + 0.2 * np.sin(0.3 * x) * np.cos(0.2 * y)
    factor = 1.0 + 0.06 * np.sin(1.1 * x) * np.sin(0.7 * y)
    return stack(red, green, blue), stack(red * factor, green, blue / factor)


for name, pair, kind in [
    ("waves", waves, "LDR"),
    ("edges", edges, "LDR"),
    ("waves", waves, "HDR"),
    ("caustic", caustic, "HDR"),
    ("coloured", coloured, "HDR"),
]:
    reference, test = pair()
    errors, mean, used = flip_evaluator.evaluate(
        reference, test, kind, inputsRGB=False, applyMagma=False
    )
    exposures = [used.get(key, 0) for key in ("startExposure", "stopExposure", "numExposures")]
    if kind == "LDR":
        exposures = [0, 0, 0]
    texels = errors[:, :, 0].ravel()[::7]
    print(name, kind, f"{mean:.7f}", *[f"{e:.6g}" for e in exposures], *[f"{e:.6f}" for e in texels])
