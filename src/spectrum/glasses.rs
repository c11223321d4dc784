//! Published glasses by name.
//!
//! Most indices are relative to air, as they were measured: see [`Glass`](super::Glass) for what follows.

/// A published material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Published {
    /// The names by which it is known here, the first of them its own.
    pub names: &'static [&'static str],
    /// Sellmeier's B and C \[µm²\], term by term.
    pub terms: &'static [[f64; 2]],
    /// True if the index is relative to air, false if it is absolute.
    pub is_in_air: bool,
    /// Where the numbers were published.
    pub source: &'static str,
}

/// Malitson gives the resonances themselves \[µm\].
const SILICA: [[f64; 2]; 3] = [
    [0.6961663, 0.0684043 * 0.0684043],
    [0.4079426, 0.1162414 * 0.1162414],
    [0.8974794, 9.896161 * 9.896161],
];

/// Peter gives the resonances themselves \[µm\].
const DIAMOND: [[f64; 2]; 2] = [[0.3306, 0.1750 * 0.1750], [4.3356, 0.1060 * 0.1060]];

/// All of them.
pub const GLASSES: &[Published] = &[
    Published {
        names: &["bk7", "n-bk7"],
        terms: &[
            [1.03961212, 0.00600069867],
            [0.231792344, 0.0200179144],
            [1.01046945, 103.560653],
        ],
        is_in_air: true,
        source: "Schott, optical glass data sheets, N-BK7",
    },
    Published {
        names: &["f2"],
        terms: &[
            [1.34533359, 0.00997743871],
            [0.209073176, 0.0470450767],
            [0.937357162, 111.886764],
        ],
        is_in_air: true,
        source: "Schott, optical glass data sheets, F2",
    },
    Published {
        names: &["sf10"],
        terms: &[
            [1.61625977, 0.0127534559],
            [0.259229334, 0.0581983954],
            [1.07762317, 116.60768],
        ],
        is_in_air: true,
        source: "Schott, optical glass data sheets, SF10",
    },
    Published {
        names: &["sf11"],
        terms: &[
            [1.73848403, 0.0136068604],
            [0.311168974, 0.0615960463],
            [1.17490871, 121.922711],
        ],
        is_in_air: true,
        source: "Schott, optical glass data sheets, SF11; published from 390 nm on",
    },
    Published {
        names: &["fused-silica", "silica"],
        terms: &SILICA,
        is_in_air: true,
        source: "I. H. Malitson, J. Opt. Soc. Am. 55, 1205 (1965), 20 °C",
    },
    Published {
        names: &["water"],
        terms: &[
            [0.5684027565, 0.005101829712],
            [0.1726177391, 0.01821153936],
            [0.02086189578, 0.02620722293],
            [0.1130748688, 10.69792721],
        ],
        is_in_air: false,
        source: "M. Daimon and A. Masumura, Appl. Opt. 46, 3811 (2007), 20.0 °C",
    },
    Published {
        names: &["diamond"],
        terms: &DIAMOND,
        is_in_air: true,
        source: "F. Peter, Z. Phys. 15, 358 (1923)",
    },
];

/// The material of a name, in any case.
pub fn published(name: &str) -> Option<&'static Published> {
    GLASSES.iter().find(|glass| {
        let mut names = glass.names.iter();
        names.any(|known| known.eq_ignore_ascii_case(name))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::IndexFormula;

    fn formula(name: &str) -> IndexFormula {
        IndexFormula::Sellmeier(published(name).unwrap().terms.to_vec())
    }

    /// The index at line d and Abbe's number, and half a unit of the last digit of each, as published: in
    /// Schott's data sheets, and of silica in Malitson's paper.
    const KNOWN: [(&str, f64, f64, f64, f64); 5] = [
        ("bk7", 1.51680, 64.17, 5e-6, 5e-3),
        ("f2", 1.62004, 36.37, 5e-6, 5e-3),
        ("sf10", 1.72825, 28.41, 5e-6, 5e-3),
        ("sf11", 1.78472, 25.76, 5e-6, 5e-3),
        ("silica", 1.45846, 67.8, 5e-6, 5e-2),
    ];

    #[test]
    fn indices_and_abbe_numbers_are_those_published() {
        for (name, n_d, abbe, index_digit, abbe_digit) in KNOWN {
            let (index, number) = (formula(name).n_d(), formula(name).abbe());
            assert!((index - n_d).abs() <= index_digit, "{name}: n_d = {index}");
            assert!(
                (number - abbe).abs() <= abbe_digit,
                "{name}: V_d = {number}"
            );
        }
    }

    /// Tilton and Taylor (*J. Res. Natl. Bur. Stand.* 20, 1938) have 1.33299 for sodium light against air, at
    /// 20 °C. Air has 1.000272 there (Ciddor 1996), which shows that this formula's index is absolute.
    #[test]
    fn waters_index_is_absolute() {
        let sodium = formula("water").ior(589.2938);
        assert!((sodium / 1.000272 - 1.33299).abs() <= 5e-6, "{sodium}");
        assert!(!published("water").unwrap().is_in_air);
    }

    /// Gemmology has 2.417 for sodium light, and calls n(430.8 nm) - n(686.7 nm) = 0.044 diamond's fire.
    #[test]
    fn diamond_has_its_fire() {
        let diamond = formula("diamond");
        assert!((diamond.ior(589.3) - 2.417).abs() <= 5e-4);
        let fire = diamond.ior(430.8) - diamond.ior(686.7);
        assert!((fire - 0.044).abs() <= 5e-4, "{fire}");
    }

    #[test]
    fn names_are_known_in_any_case_and_each_once() {
        assert_eq!(published("BK7"), published("n-bk7"));
        assert_eq!(published("unobtainium"), None);
        let mut names: Vec<&str> = GLASSES
            .iter()
            .flat_map(|it| it.names.iter().copied())
            .collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
    }
}
