"""Renders a few scenes of the suite with Mitsuba, now, and has `nephroid compare` judge ours by them.

    python tests/mitsuba/parity/live.py target/release/nephroid

Other seeds than the references' (render.py), fixed all the same: a comparison that fails, fails again. Exit code 1 where an image
is not shown to be the same within MARGIN: twice the noise of a pixel that so few seeds leave.
"""
import pathlib
import subprocess
import sys
import tempfile
import mitsuba as mi
import render

NAMES = ["bsdf-dielectric", "bsdf-roughconductor-ggx", "mesh-normalmap", "emitter-envmap", "sensor-thinlens", "refraction-into-glass"]
SEEDS = 16
MARGIN = "3%"


def main():
    program = sys.argv[1]
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        for name in NAMES:
            file = render.FOLDER / f"{name}.xml"
            theirs, ours = (pathlib.Path(folder) / f"{who}.exr" for who in ["theirs", "ours"])
            mean, error = render.mean_and_error(mi.load_file(str(file)), seeds=SEEDS, first=1000)
            render.write(theirs, file, mean, error, seeds=SEEDS)
            subprocess.run([program, "render", file, "--method", "path", "--spp", "512", "-o", ours], check=True, capture_output=True)
            found = subprocess.run([program, "compare", theirs, ours, "--margin", MARGIN], capture_output=True, text=True)
            print(f"{name}: {'same' if found.returncode == 0 else 'not shown to be the same'} within {MARGIN}", flush=True)
            if found.returncode != 0:
                print(found.stdout, found.stderr)
                failed.append(name)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
