//! Arguments of `nephroid compare`.

use std::path::PathBuf;

use clap::ValueEnum;

use super::super::args::parse_fraction;
use crate::metric::flip::PIXELS_PER_DEGREE;
use crate::metric::{CompareSettings, ImageSide, Window};

/// `nephroid compare`.
#[derive(Debug, clap::Args)]
pub struct CompareArgs {
    /// One image, EXR
    #[arg(value_name = "A.exr")]
    pub a: PathBuf,

    /// The other image, EXR
    #[arg(value_name = "B.exr")]
    pub b: PathBuf,

    /// Which image is the truth, that the other is judged by
    #[arg(long, value_enum, ignore_case = true, default_value_t = SideArg::A)]
    pub reference: SideArg,

    /// An image of the standard errors of A, where A has none itself
    #[arg(long, value_name = "FILE")]
    pub error_a: Option<PathBuf>,

    /// An image of the standard errors of B, where B has none itself
    #[arg(long, value_name = "FILE")]
    pub error_b: Option<PathBuf>,

    /// Independent samples or replicates behind A's standard errors [default: as A says, else their errors
    /// count as exact]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..))]
    pub samples_a: Option<u64>,

    /// Independent samples or replicates behind B's standard errors
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..))]
    pub samples_b: Option<u64>,

    /// The difference that matters, relative to the reference's mean; exit code 1 where it is exceeded
    #[arg(long, value_name = "FRACTION", default_value = "1%", value_parser = parse_fraction)]
    pub margin: f64,

    /// How often a test may go wrong where its hypothesis is true, below one half
    #[arg(long, value_name = "FRACTION", default_value = "5%", value_parser = parse_level)]
    pub level: f64,

    /// Exit code 1 unless equivalence within the margin is shown
    #[arg(long)]
    pub require_equivalence: bool,

    /// A layer to compare, `LTTD`; may be given again [default: all that both images have]
    #[arg(long, value_name = "NAME")]
    pub layer: Vec<String>,

    /// Compare these texels only: column and row of the upper left one, width, height
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_window)]
    pub crop: Option<Window>,

    /// Write maps of the difference, the relative difference and z into this folder, as PNG; made
    /// where missing
    #[arg(long, value_name = "DIR")]
    pub maps: Option<PathBuf>,

    /// Pixels a degree of vision, for FLIP
    #[arg(long, value_name = "N", default_value_t = PIXELS_PER_DEGREE, value_parser = parse_pixels_per_degree)]
    pub pixels_per_degree: f32,

    /// Leave FLIP out, which takes most of the time
    #[arg(long)]
    pub no_flip: bool,

    /// Print all figures as JSON
    #[arg(long)]
    pub json: bool,
}

/// One of the two images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SideArg {
    /// The first
    #[value(name = "A")]
    A,
    /// The second
    #[value(name = "B")]
    B,
}

impl CompareArgs {
    /// The settings that the flags ask for.
    pub fn settings(&self) -> CompareSettings {
        CompareSettings {
            reference: match self.reference {
                SideArg::A => ImageSide::A,
                SideArg::B => ImageSide::B,
            },
            layers: self.layer.clone(),
            margin: self.margin,
            level: self.level,
            pixels_per_degree: (!self.no_flip).then_some(self.pixels_per_degree),
        }
    }
}

fn parse_level(text: &str) -> Result<f64, String> {
    parse_fraction(text)
        .ok()
        .filter(|level| *level < 0.5)
        .ok_or_else(|| {
            "give a number > 0 and < 0.5, as a fraction (0.05) or in percent (5%)".to_owned()
        })
}

/// The kernels are some ⅓ degree wide: beyond a thousand pixels a degree they are larger than images.
fn parse_pixels_per_degree(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|value| (1.0..=1000.0).contains(value))
        .ok_or_else(|| "give a number in 1..=1000".to_owned())
}

fn parse_window(text: &str) -> Result<Window, String> {
    let numbers: Result<Vec<usize>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, width, height]) => Ok(Window {
            corner: [x, y],
            size: [width, height],
        }),
        _ => Err("give four whole numbers with commas between them, as in 0,0,64,64".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_four_whole_numbers() {
        let window = parse_window("1,2,30, 40").unwrap();
        assert_eq!((window.corner, window.size), ([1, 2], [30, 40]));
        for text in ["", "1,2,3", "1,2,3,4,5", "-1,0,1,1", "a,b,c,d", "1.5,0,1,1"] {
            assert!(parse_window(text).is_err(), "{text}");
        }
    }

    #[test]
    fn levels_are_probabilities_below_one_half() {
        assert_eq!(parse_level("5%"), Ok(0.05));
        for text in ["0", "50%", "1", "nan", ""] {
            assert!(parse_level(text).is_err(), "{text}");
        }
    }
}
