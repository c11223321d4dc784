"""Renders third-party scenes with Mitsuba, for a comparison that is made on demand.

    pip install mitsuba==3.9.1 numpy==2.4.6
    python tests/mitsuba/parity/third_party.py SCENES OUT
    NEPHROID_PARITY_DIR=OUT cargo test --release --test mitsuba_parity_third_party -- --ignored --nocapture

SCENES is the folder that the paths in tests/mitsuba/third_party_quick.txt begin at. The scenes are not part of this
repository, and neither are their images: OUT should be a temporary folder. Every scene is rendered unmodified but for
its film, scaled to 32 pixels a row, and its integrator: path, max_depth 8.
"""
import pathlib
import sys
import mitsuba as mi
import render

LIST = pathlib.Path(__file__).parent.parent / "third_party_quick.txt"
WIDTH = 32
DEPTH = 8


def scaled_sensor(scene):
    sensor = scene.sensors()[0]
    params = mi.traverse(sensor)
    width, height = params["film.size"]
    rows = max(1, (WIDTH * int(height) + int(width) // 2) // int(width))
    params["film.size"] = [WIDTH, rows]
    params["film.crop_size"] = [WIDTH, rows]
    params["film.crop_offset"] = [0, 0]
    params.update()
    return sensor


def main():
    scenes, out = map(pathlib.Path, sys.argv[1:])
    out.mkdir(parents=True, exist_ok=True)
    integrator = mi.load_dict({"type": "path", "max_depth": DEPTH})
    for line in LIST.read_text().splitlines():
        if line.startswith("#"):
            continue
        name = line.split(" | ")[0]
        file = scenes / name
        try:
            scene = mi.load_file(str(file))
            mean, error = render.mean_and_error(scene, scaled_sensor(scene), integrator=integrator)
        except Exception as problem:  # One scene that Mitsuba refuses is no reason to leave the others out.
            print(f"{name}: {problem}", flush=True)
            continue
        render.write(out / (name.replace("/", "__") + ".exr"), file, mean, error)
        print(f"{name}: {mean.shape}, mean {mean.mean():.4g}", flush=True)


if __name__ == "__main__":
    main()
