//! Pictures are written whole, and show what is no number.

use nephroid::film::Grid;
use nephroid::film::picture::{self, Content, PictureSpec, Range, Scale};

/// A made-up caustic: the nephroid's envelope as a bright line over a slow slope.
fn cup(size: usize) -> Grid<f32> {
    Grid::from_fn(size, size, |x, y| {
        let [x, y] = [x, y].map(|i| (i as f64 + 0.5) / size as f64 * 2.2 - 1.1);
        let radius = x.hypot(y);
        if radius > 1.0 {
            return 0.0;
        }
        // Nephroid of a unit circle: 4 (r^2 - 1/4)^3 = 27/16 y^2 / 4 ... as a level set.
        let level = 4.0 * (radius * radius - 0.25).powi(3) - 27.0 / 16.0 * y * y;
        (0.2 + 0.05 / (level.abs() + 1e-4).sqrt() + 0.1 * x) as f32
    })
}

#[test]
#[ignore = "writes pictures to look at into the folder NEPHROID_PICTURES"]
fn gallery() {
    let folder = std::path::PathBuf::from(std::env::var("NEPHROID_PICTURES").unwrap());
    for size in [8, 64, 200, 512, 1000, 2048] {
        let values = cup(size);
        for (scale, name) in [(Scale::Linear, "linear"), (Scale::Logarithmic, "log")] {
            let content = Content::FalseColour {
                values: &values,
                scale,
            };
            let spec = PictureSpec {
                title: "cup.xml: irradiance",
                unit: "W/m²",
                content,
                range: None,
            };
            picture::write(&folder.join(format!("{name}_{size}.png")), &spec).unwrap();
        }
    }
    let values = cup(300);
    let signed = values.map(|v| (v - 0.5) * 1e-6);
    let rgb = values.map(|&v| [v, v * 0.6, v * 0.3]);
    let mut holes = values.clone();
    for i in 0..40 {
        assert!(holes.set(100 + i, 150, f32::NAN));
    }
    let range = Some(Range {
        low: 0.3,
        high: 0.9,
    });
    let pictures = [
        (
            "signed",
            Content::Signed { values: &signed },
            None,
            "beams - photons, a title that is far too long for one line of this map",
        ),
        ("rgb", Content::ToneMapped { values: &rgb }, None, "LTTD"),
        (
            "nan",
            Content::FalseColour {
                values: &holes,
                scale: Scale::Linear,
            },
            range,
            "holes",
        ),
        (
            "narrow",
            Content::FalseColour {
                values: &holes,
                scale: Scale::Logarithmic,
            },
            range,
            "narrow",
        ),
    ];
    for (name, content, range, title) in pictures {
        let spec = PictureSpec {
            title,
            unit: "W/m²",
            content,
            range,
        };
        picture::write(&folder.join(format!("{name}.png")), &spec).unwrap();
    }
    let strip = Grid::from_fn(900, 20, |x, y| (x * y) as f32);
    let content = Content::FalseColour {
        values: &strip,
        scale: Scale::Linear,
    };
    let spec = PictureSpec {
        title: "strip",
        unit: "W/m²/sr",
        content,
        range: None,
    };
    picture::write(&folder.join("strip.png"), &spec).unwrap();
}
