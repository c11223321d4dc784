"""Fits a water surface to a caustic with Mitsuba, and judges every step by the truth.

    pip install ./python mitsuba
    python python/examples/heightfield.py [SIZE]

An optimiser looks for the two waves that throw a given caustic onto the floor. It works with images by Mitsuba's `ptracer`,
whose noise is part of its loss. The truth says how far each step is from the goal, as an interval. It holds all that the
bounds of the films allow: if those of two steps do not overlap, one is better.

SIZE is the width of the images, a multiple of 8.
"""

from __future__ import annotations

import sys
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

import nephroid as ne

Array = NDArray[np.float64]

#: Amplitudes of the waves that threw the caustic, in the scene's units.
GOAL = np.array([0.03, -0.02])
#: Vertices each way of the water, and how far it reaches.
VERTICES, REACH = 49, 1.5
#: Amplitudes by which derivatives are taken.
STEP = 0.004


def water(amplitudes: Array) -> Array:
    """The positions of the water's vertices."""
    x, y = np.meshgrid(np.linspace(-REACH, REACH, VERTICES), np.linspace(-REACH, REACH, VERTICES))
    z = 1 + amplitudes[0] * np.cos(2 * np.pi * x + 0.5) + amplitudes[1] * np.cos(2 * np.pi * (x + y))
    return np.stack([x, y, z], 2).reshape(-1, 3)


def faces() -> NDArray[np.uint32]:
    """The triangles between them, which look up."""
    corner = (np.arange(VERTICES - 1)[:, None] * VERTICES + np.arange(VERTICES - 1)).reshape(-1)
    right, up = corner + 1, corner + VERTICES
    return np.concatenate([np.stack([corner, right, up + 1], 1), np.stack([corner, up + 1, up], 1)]).astype(np.uint32)


def pool(surface: Any, size: int) -> dict[str, Any]:
    """A floor under water below a lamp, as both programs read it. A camera in the water sees the floor alone."""
    to = mi.ScalarTransform4f
    return {
        "type": "scene",
        "water": surface,
        "floor": {
            "type": "rectangle",
            "to_world": to().scale([2, 2, 1]),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.8}},
        },
        "lamp": {
            "type": "spot",
            "to_world": to().look_at(origin=[0.3, 0, 5], target=[0, 0, 0], up=[0, 1, 0]),
            "intensity": {"type": "rgb", "value": 20},
            "cutoff_angle": 18,
            "beam_width": 17,
        },
        "eye": {
            "type": "perspective",
            "fov": 90,
            "to_world": to().look_at(origin=[0, 0, 0.7], target=[0, 0, 0], up=[0, 1, 0]),
            "film": {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}},
        },
    }


class Optimiser:
    """Steps of Gauss and Newton towards an image, by Mitsuba's images."""

    def __init__(self, goal: Array, size: int) -> None:
        self._goal = goal
        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict({"type": "dielectric", "int_ior": 1.33})
        surface = mi.Mesh("water", VERTICES**2, len(faces()), props=properties)
        self._water = mi.traverse(surface)
        self._water["faces"] = faces().ravel()
        self._place(np.zeros(2))
        # Lamp, water, floor and camera: what the truth's beams follow.
        self._scene = mi.load_dict({**pool(surface, size), "integrator": {"type": "ptracer", "max_depth": 4}})
        self._water = mi.traverse(self._scene)

    def _place(self, amplitudes: Array, key: str = "vertex_positions") -> None:
        self._water[key] = water(amplitudes).astype(np.float32).ravel()
        self._water.update()

    def _image(self, amplitudes: Array) -> Array:
        """The image, as means over squares: a caustic is too sharp for one step to follow its edges."""
        self._place(amplitudes, "water.vertex_positions")
        # The same numbers at each step: differences have less noise than images.
        return blurred(np.array(mi.render(self._scene, spp=256, seed=mi.UInt32(1)), dtype=np.float64))

    def step(self, amplitudes: Array) -> Array:
        """The amplitudes after a step."""
        here = self._image(amplitudes)
        slopes = [(self._image(amplitudes + STEP * one) - here) / STEP for one in np.eye(len(amplitudes))]
        jacobian = np.stack([slope.ravel() for slope in slopes], 1)
        change = np.linalg.lstsq(jacobian, (blurred(self._goal) - here).ravel(), rcond=None)[0]
        # No wave changes by more than a hundredth at once.
        changed: Array = amplitudes + change * min(1.0, 0.01 / np.abs(change).max())
        return changed


def blurred(image: Array) -> Array:
    """Means over an eighth of the image each way."""
    side = image.shape[0] // 8
    if 8 * side != image.shape[0]:
        raise ValueError(f"the size is {image.shape[0]}; allowed are multiples of 8")
    means: Array = image.reshape(8, side, 8, side, 3).mean((1, 3))
    return means


class Judge:
    """The truth of each step."""

    def __init__(self, size: int) -> None:
        self._scene = pool(
            {
                "type": "mesh",
                "vertex_positions": water(GOAL),
                "faces": faces(),
                "face_normals": True,
                "bsdf": {"type": "dielectric", "int_ior": 1.33},
            },
            size,
        )
        self.goal = self.film(GOAL)

    def film(self, amplitudes: Array) -> ne.Film:
        """The truth, with bounds of every pixel."""
        scene = ne.load_dict(self._scene, update={"water.vertex_positions": water(amplitudes)})
        film = ne.render(scene, sensor="eye", method="beams", error=0.003)
        assert film is not None
        return film

    def l1(self, amplitudes: Array) -> tuple[float, float]:
        """The L1 distance from the goal, relative: all that the bounds of both films allow."""
        film, goal = self.film(amplitudes), self.goal
        assert film.lo is not None and film.hi is not None and goal.lo is not None and goal.hi is not None
        least = np.maximum(np.maximum(film.lo - goal.hi, goal.lo - film.hi), 0).sum()
        most = np.maximum(film.hi - goal.lo, goal.hi - film.lo).sum()
        return float(least / goal.hi.sum()), float(most / goal.lo.sum())


def fit(size: int, steps: int = 6) -> list[tuple[Array, tuple[float, float]]]:
    """The amplitudes before each step and after the last, each with its distance from the goal."""
    mi.set_variant("scalar_rgb")
    # Without its bars of progress.
    mi.logger().clear_appenders()  # type: ignore[operator]
    judge = Judge(size)
    optimiser = Optimiser(np.asarray(judge.goal.value), size)
    amplitudes = np.array([0.01, 0.01])
    found = []
    for number in range(steps + 1):
        found.append((amplitudes, judge.l1(amplitudes)))
        (least, most), waves = found[-1][1], " ".join(f"{one:+.4f}" for one in amplitudes)
        print(f"step {number}: waves {waves}   L1 from the goal {least:.4f} .. {most:.4f}", flush=True)
        if number < steps:
            amplitudes = optimiser.step(amplitudes)
    return found


if __name__ == "__main__":
    fit(int(sys.argv[1]) if len(sys.argv) > 1 else 64)
