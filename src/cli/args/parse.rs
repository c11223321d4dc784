//! From words to values, with a message that says what is allowed.

use std::time::Duration;

use glam::DVec2;

use crate::metric::Figure;
use crate::reference::shard::Shard;
use crate::setting::{self, Words as _};
use crate::transport::scatter::ShadingNormals;

/// A name and a value.
pub fn parse_define(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.to_owned(), value.to_owned())),
        _ => Err("give NAME=VALUE, as in samples=16".to_owned()),
    }
}

/// The id of an interface, and its glass.
pub fn parse_dispersion(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((id, glass)) if !id.is_empty() => Ok((id.to_owned(), glass.to_owned())),
        _ => Err("give ID=GLASS, as in prism=bk7".to_owned()),
    }
}

/// Two finite numbers; whether they are on the receiver is for the probe to say.
pub fn parse_uv(text: &str) -> Result<DVec2, String> {
    let number = |text: &str| {
        text.trim()
            .parse()
            .ok()
            .filter(|value: &f64| value.is_finite())
    };
    text.split_once(',')
        .and_then(|(u, v)| Some(DVec2::new(number(u)?, number(v)?)))
        .ok_or_else(|| {
            "give two numbers in 0..=1 with a comma between them, as in 0.5,0.25".to_owned()
        })
}

/// A number of bytes with its unit, to powers of 1000.
///
/// # Errors
///
/// For anything else, and less than one byte.
pub fn parse_bytes(text: &str) -> Result<u64, String> {
    let units = [("kB", 1e3), ("MB", 1e6), ("GB", 1e9), ("TB", 1e12)];
    let found = units.into_iter().find_map(|(unit, size)| {
        let number: f64 = text.strip_suffix(unit)?.trim_end().parse().ok()?;
        Some(number * size)
    });
    found
        .filter(|bytes| (1.0..1e18).contains(bytes))
        .map(|bytes| bytes as u64)
        .ok_or_else(|| "give a number > 0 with a unit: kB, MB, GB or TB, as in 2GB".to_owned())
}

/// A time with its unit.
pub fn parse_duration(text: &str) -> Result<Duration, String> {
    setting::parse_duration(text)
        .ok_or_else(|| "give a number >= 0 with a unit: ms, s, m or h, as in 30s".to_owned())
}

/// The effect of interpolated normals on flux.
pub fn parse_shading_normals(text: &str) -> Result<ShadingNormals, String> {
    ShadingNormals::of_word(text).ok_or_else(|| "give flux or adjoint".to_owned())
}

/// A positive number, or a percentage.
///
/// # Errors
///
/// For anything else.
pub fn parse_fraction(text: &str) -> Result<f64, String> {
    setting::parse_fraction(text)
        .ok_or_else(|| "give a number > 0, as a fraction (0.01) or in percent (1%)".to_owned())
}

/// A figure that can be shared out among stages.
pub fn parse_figure(text: &str) -> Result<Figure, String> {
    let figure = Figure::of_word(text).filter(|figure| Figure::OF_LIGHT.contains(figure));
    figure.ok_or_else(|| {
        let names: Vec<&str> = Figure::OF_LIGHT.iter().map(|one| one.word()).collect();
        format!("give one of {}", names.join(", "))
    })
}

/// A part of a run, counted from 1.
pub fn parse_shard(text: &str) -> Result<Shard, String> {
    let parsed = text
        .split_once('/')
        .and_then(|(part, of)| Some((part.parse::<u32>().ok()?, of.parse::<u32>().ok()?)));
    match parsed {
        Some((part, count)) if (1..=count).contains(&part) => Ok(Shard {
            index: part - 1,
            count,
        }),
        _ => Err("give K/N with K from 1 to N, as in 1/3".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_count_from_one() {
        assert_eq!(parse_shard("3/3"), Ok(Shard { index: 2, count: 3 }));
        for text in ["0/3", "4/3", "1", "/", "a/b", "1/0"] {
            assert!(parse_shard(text).is_err(), "{text}");
        }
    }
}
