"""What Mitsuba says of textures, point by point: writes texture_oracle.txt and its images.

    pip install mitsuba==3.9.1 numpy==2.4.6
    python tests/mitsuba/texture_oracle.py

Variant scalar_rgb. Each case is a texture as in a scene file; lines are u v, red green blue and, for
bitmaps, how the luminance changes with u and v. Needs bsdf_oracle.py to have written color.png.
"""
import pathlib
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
FOLDER = pathlib.Path(__file__).parent


def write_images():
    rng = np.random.default_rng(8)
    mi.Bitmap(rng.random((3, 5, 3), dtype=np.float32)).write(str(FOLDER / "color.exr"))
    mi.Bitmap(rng.random((2, 3, 1), dtype=np.float32)).write(str(FOLDER / "grey.exr"))
    mi.Bitmap(rng.integers(0, 65536, (2, 2, 3), dtype=np.uint16)).write(str(FOLDER / "deep.png"))
    mi.Bitmap(rng.integers(0, 256, (3, 2, 4), dtype=np.uint8)).write(str(FOLDER / "alpha.png"))
    mi.Bitmap(rng.random((3, 4, 3), dtype=np.float32) * 0.9).write(str(FOLDER / "color.hdr"))
    # Flat blocks: what JPEG decoders agree on.
    flat = np.kron(np.array([[200, 60], [30, 120]], dtype=np.uint8), np.ones((16, 16), dtype=np.uint8))
    mi.Bitmap(np.repeat(flat[..., None], 3, axis=2)).write(str(FOLDER / "flat.jpg"))


TO_UV = ('<transform name="to_uv"><scale x="2" y="3" z="4"/><rotate z="1" angle="30"/>'
         '<translate x="0.1" y="0.2" z="0.3"/></transform>')


def bitmap(name, rest=""):
    return (f'<texture type="bitmap" name="reflectance"><string name="filename" value="{name}"/>'
            f'<string name="format" value="variant"/>{rest}</texture>')


def choice(name, value):
    return f'<string name="{name}" value="{value}"/>'


CASES = [bitmap("color.exr", choice("filter_type", f) + choice("wrap_mode", w))
         for f in ("nearest", "bilinear") for w in ("repeat", "mirror", "clamp")]
CASES += [
    bitmap("color.exr", TO_UV),
    bitmap("color.exr", choice("filter_type", "nearest") + TO_UV),
    bitmap("grey.exr"),
    bitmap("color.png"),
    bitmap("color.png", '<boolean name="raw" value="true"/>'),
    bitmap("deep.png"),
    bitmap("deep.png", '<boolean name="raw" value="true"/>'),
    bitmap("alpha.png"),
    bitmap("color.hdr"),
    bitmap("flat.jpg", choice("filter_type", "nearest")),
    '<texture type="checkerboard" name="reflectance"/>',
    f'<texture type="checkerboard" name="reflectance"><rgb name="color0" value="0.1, 0.2, 0.3"/><rgb name="color1" value="0.6, 0.5, 0.4"/>{TO_UV}</texture>',
]

UV = [(0.1, 0.2), (0.9, 0.95), (-0.3, 1.4), (1.02, -0.55), (0.43, 0.61), (-2.7, 3.1), (0.33, 0.02),
      (0.77, 0.48), (1.66, 0.9)]


def main():
    write_images()
    mi.file_resolver().prepend(str(FOLDER))
    with open(FOLDER / "texture_oracle.txt", "w") as file:
        print(f"# Mitsuba {mi.__version__}, scalar_rgb, by texture_oracle.py", file=file)
        for text in CASES:
            head, rest = text.split(" ", 1)
            texture = mi.load_string(f'{head} version="3.0.0" {rest.replace(chr(32) + "name=" + chr(34) + "reflectance" + chr(34), "", 1)}')
            print("case", text, file=file)
            for uv in UV:
                si = mi.SurfaceInteraction3f()
                si.t = 1
                si.uv = mi.Point2f(uv)
                values = [float(x) for x in texture.eval(si)]
                if "bitmap" in text:
                    values += [float(x) for x in texture.eval_1_grad(si)]
                print(*uv, " ".join(f"{x:.8g}" for x in values), file=file)


if __name__ == "__main__":
    main()
