"""Renders one image a line of stdin, for benches/mitsuba.rs: `python render_with_mitsuba.py VARIANT`.

A line is JSON: {"scene", "integrator", "max_depth", "samples", "seed"}, and "width" and "height" for the sensor "camera"
of a shipped scene. Without them the first sensor's film is as in tests/mitsuba/parity/third_party.py. The answer is a line
of JSON: wall and CPU seconds of the render, its compilation left out, the image's numbers, row by row, and their rows. Or
it has the "error" by which the scene does not load.
"""
import json
import os
import pathlib
import sys
import time

import mitsuba as mi
import numpy as np

mi.set_variant(sys.argv[1])
mi.set_log_level(mi.LogLevel.Error)
sys.path.append(str(pathlib.Path(__file__).parent.parent / "tests/mitsuba/parity"))
scenes = {}


def prepare(job):
    integrator = mi.load_dict({"type": job["integrator"], "max_depth": job["max_depth"]})
    if "width" not in job:
        from third_party import load_with_small_film
        scene = load_with_small_film(pathlib.Path(job["scene"]))
        return scene, scene.sensors()[0], integrator
    scene = mi.load_file(job["scene"])
    sensor = next(it for it in scene.sensors() if it.id() == "camera")
    params = mi.traverse(sensor)
    params["film.size"] = params["film.crop_size"] = [job["width"], job["height"]]
    params.update()
    return scene, sensor, integrator


def cpu_seconds():
    times = os.times()
    return times.user + times.system


# Mitsuba's progress bar goes to stdout: answers have a descriptor of their own.
answers = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)
print(json.dumps({"version": mi.__version__}), file=answers, flush=True)
for line in sys.stdin:
    job = json.loads(line)
    key = tuple(job.get(it) for it in ("scene", "integrator", "width", "height"))
    first = key not in scenes
    try:
        if first:
            scenes[key] = prepare(job)
    except Exception as problem:
        print(json.dumps({"error": str(problem).splitlines()[-1]}), file=answers, flush=True)
        continue
    scene, sensor, integrator = scenes[key]

    def render(seed):
        return np.array(mi.render(scene, sensor=sensor, integrator=integrator, spp=job["samples"], seed=seed))

    if first:
        render(0)
    wall, cpu = time.perf_counter(), cpu_seconds()
    image = render(job["seed"])
    wall, cpu = time.perf_counter() - wall, cpu_seconds() - cpu
    values = image[..., :3].astype(float).mean(axis=2).ravel()
    print(json.dumps({"wall": wall, "cpu": cpu, "values": values.tolist(), "rows": len(image)}), file=answers, flush=True)
