"""Which way surfaces run, as bsdfs see it: writes frame_oracle.txt beside itself.

    pip install mitsuba==3.9.1 numpy==2.4.6
    python tests/mitsuba/frame_oracle.py

Variant scalar_rgb. Each case is a shape with a bsdf that cares about tangents, met by a ray straight down
from (x, y, 5). Lines: x y, theta and phi of wi and wo in degrees in world space, f cos of the green channel.
Needs bsdf_oracle.py to have written its images.
"""
import pathlib
import mitsuba as mi
import numpy as np
from bsdf_oracle import bitmap, direction, rough

mi.set_variant("scalar_rgb")
FOLDER = pathlib.Path(__file__).parent

BSDFS = [
    rough("roughconductor", "ggx", (0.5, 0.15)),
    f'<bsdf type="bumpmap">{bitmap("height.png", "map")}<float name="scale" value="0.6"/><bsdf type="diffuse"/></bsdf>',
    f'<bsdf type="normalmap">{bitmap("color.png", "normalmap")}<bsdf type="diffuse"/></bsdf>',
]
TO_WORLD = ('<transform name="to_world"><scale value="1.5"/><rotate x="0.6" y="0.8" angle="40"/>'
            '<translate x="0.2" y="0.1"/></transform>')
PLY = '<string name="filename" value="leaning.ply"/>'
SHAPES = [
    ("sphere", TO_WORLD), ("sphere", TO_WORLD + '<boolean name="flip_normals" value="true"/>'),
    ("rectangle", TO_WORLD), ("disk", TO_WORLD), ("cylinder", TO_WORLD), ("ply", PLY),
    ("ply", PLY + '<boolean name="face_normals" value="true"/>'),
    ("ply", PLY + '<transform name="to_world"><scale x="1.2" y="0.8"/><rotate y="1" angle="20"/></transform>'),
]
PLACES = [(0.3, 0.2), (0.1, 0.45)]
WI = [(20, 30), (55, 250)]
WO = [(15, 200), (50, 80), (60, 310), (120, 20)]


def main():
    mi.file_resolver().prepend(str(FOLDER))
    context = mi.BSDFContext()
    with open(FOLDER / "frame_oracle.txt", "w") as file:
        print(f"# Mitsuba {mi.__version__}, scalar_rgb, by frame_oracle.py", file=file)
        for shape, rest in SHAPES:
            for bsdf in BSDFS:
                text = f'<shape type="{shape}">{rest}{bsdf}</shape>'
                scene = mi.load_string(f'<scene version="3.0.0">{text}</scene>')
                print("case", text, file=file)
                for x, y in PLACES:
                    si = scene.ray_intersect(mi.Ray3f(mi.Point3f(x, y, 5), mi.Vector3f(0, 0, -1)))
                    if not si.is_valid():
                        continue
                    for wi in WI:
                        for wo in WO:
                            si.wi = si.to_local(mi.Vector3f(direction(wi)))
                            to = si.to_local(mi.Vector3f(direction(wo)))
                            value = si.bsdf().eval(context, si, to)
                            print(x, y, *wi, *wo, f"{float(value[1]):.8g}", file=file)


if __name__ == "__main__":
    main()
