//! Why an image has no light.

use super::lookup::Looks;
use super::loss::Loss;
use super::tally::Tally;
use crate::setting::Words;

/// The reason for which a frame has no light, in one sentence that begins with it. `looks` are the look-ups
/// of a map that has light.
pub fn reason(tally: &Tally, looks: Option<&Looks>) -> String {
    let photons = tally.set_out.photons;
    if photons == 0 {
        return "no photon meets a specular object: all of the light's view passes beside them, or is hidden from \
                them"
            .to_owned();
    }
    let mut lost: Vec<(u64, &str)> = Loss::WORDS
        .iter()
        .map(|&(reason, loss, _)| (tally.lost(loss).photons, reason))
        .filter(|(count, _)| *count > 0)
        .collect();
    lost.sort_by_key(|(count, _)| std::cmp::Reverse(*count));
    let landed = tally.landed.photons;
    if landed == 0 {
        if let [(_, reason)] = lost[..] {
            return format!("all {} photons were dropped: {reason}", grouped(photons));
        }
        let each = lost
            .iter()
            .map(|(count, reason)| format!("{} {reason}", grouped(*count)));
        let each: Vec<String> = each.collect();
        return format!(
            "all {} photons were dropped: {}",
            grouped(photons),
            each.join(", ")
        );
    }
    if tally.landed.flux.is_black() {
        return format!(
            "interfaces let no light through: {} photons landed without any",
            grouped(landed)
        );
    }
    let flux = tally.landed.flux.mean();
    match looks {
        Some(looks) => format!(
            "the map's light is not seen by the sensor: {flux:.3e} W of {} photons landed; of {} look-ups {} are on \
             surfaces that face away from the light, {} outside of the map, {} on dark texels, {} in shadow",
            grouped(landed),
            grouped(looks.all()),
            grouped(looks.turned),
            grouped(looks.outside),
            grouped(looks.dark),
            grouped(looks.hidden)
        ),
        None => format!(
            "all light lands beside the sensor, or on its back: {flux:.3e} W of {} photons",
            grouped(landed)
        ),
    }
}

/// A number with its digits in groups of three.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::tally::Left;
    use super::*;
    use crate::radiometry::Rgb;

    #[test]
    fn digits_are_grouped_from_the_right() {
        assert_eq!(
            [0, 999, 1000, 1_234_567].map(grouped),
            ["0", "999", "1,000", "1,234,567"]
        );
    }

    #[test]
    fn the_reason_comes_first_with_its_figures() {
        let mut tally = Tally::default();
        assert!(reason(&tally, None).starts_with("no photon meets"));
        for _ in 0..3 {
            tally.lose(Loss::NoBackFace, Rgb::WHITE, Left::ALL);
        }
        assert_eq!(
            reason(&tally, None),
            "all 3 photons were dropped: no back face"
        );
        tally.lose(Loss::NoReceiver, Rgb::WHITE, Left::ALL);
        assert_eq!(
            reason(&tally, None),
            "all 4 photons were dropped: 3 no back face, 1 meets no receiver"
        );
        let none = Left {
            throughput: Rgb::BLACK,
            by_fresnel: Rgb::BLACK,
        };
        tally.land(Rgb::WHITE, none, Rgb::WHITE);
        assert!(reason(&tally, None).starts_with("interfaces let no light through"));
        tally.land(Rgb::WHITE, Left::ALL, Rgb::WHITE);
        assert!(reason(&tally, None).starts_with("all light lands beside the sensor"));
        let looks = Looks {
            turned: 5,
            ..Looks::default()
        };
        assert!(reason(&tally, Some(&looks)).contains("of 5 look-ups 5 are on surfaces"));
    }
}
