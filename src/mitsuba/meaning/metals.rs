//! Complex refractive indices of metals and other absorbers, by name.

use crate::radiometry::Rgb;

/// Complex index of one material.
pub struct MetalIndex {
    /// Its name in `material`.
    pub name: &'static str,
    /// Real part.
    pub eta: Rgb,
    /// Imaginary part.
    pub k: Rgb,
}

/// Mitsuba's measured materials in its `rgb` variants.
///
/// Mitsuba integrates the spectra in its `data/ior` against the CIE 1931 curves and converts them to linear
/// sRGB. The numbers, six digits each, were read back from Mitsuba 3.9.1 (`scalar_rgb`) with
/// `mi.traverse(mi.load_dict({"type": "conductor", "material": name}))`. Zeros are Mitsuba's: a negative
/// channel, a colour outside sRGB, is clamped to zero there.
#[rustfmt::skip]
const METALS: [MetalIndex; 38] = [
    MetalIndex { name: "a-C", eta: Rgb([2.94405, 2.22714, 1.96816]), k: Rgb([0.887465, 0.799299, 0.81529]) },
    MetalIndex { name: "Ag", eta: Rgb([0.155276, 0.116728, 0.138388]), k: Rgb([4.82835, 3.12222, 2.1469]) },
    MetalIndex { name: "Al", eta: Rgb([1.6575, 0.880405, 0.521244]), k: Rgb([9.22381, 6.2695, 4.837]) },
    MetalIndex { name: "AlAs", eta: Rgb([3.6053, 3.23294, 2.21632]), k: Rgb([0.000679437, 0.0, 0.00751271]) },
    MetalIndex { name: "AlSb", eta: Rgb([0.0, 4.13937, 4.66925]), k: Rgb([0.0, 0.0940091, 1.30057]) },
    MetalIndex { name: "Au", eta: Rgb([0.143036, 0.375307, 1.44205]), k: Rgb([3.983, 2.38556, 1.60336]) },
    MetalIndex { name: "Be", eta: Rgb([4.18501, 3.18503, 2.78406]), k: Rgb([3.83547, 3.01012, 2.86899]) },
    MetalIndex { name: "Cr", eta: Rgb([4.36967, 2.91651, 1.6549]), k: Rgb([5.20655, 4.23131, 3.7547]) },
    MetalIndex { name: "CsI", eta: Rgb([2.1449, 1.70232, 1.66243]), k: Rgb([0.0, 0.0, 0.0]) },
    MetalIndex { name: "Cu", eta: Rgb([0.201005, 0.92375, 1.10222]), k: Rgb([3.91326, 2.45305, 2.14209]) },
    MetalIndex { name: "Cu_palik", eta: Rgb([0.213229, 0.919715, 1.10241]), k: Rgb([3.92187, 2.45733, 2.13658]) },
    MetalIndex { name: "Cu2O", eta: Rgb([3.55177, 2.94987, 2.75188]), k: Rgb([0.114207, 0.193897, 0.606134]) },
    MetalIndex { name: "CuO", eta: Rgb([3.24754, 2.44781, 2.21022]), k: Rgb([0.52109, 0.570031, 0.722179]) },
    MetalIndex { name: "d-C", eta: Rgb([2.70872, 2.31883, 2.2289]), k: Rgb([0.0, 0.0, 0.0]) },
    MetalIndex { name: "Hg", eta: Rgb([2.39894, 1.44003, 0.90957]), k: Rgb([6.32759, 4.37192, 3.42176]) },
    MetalIndex { name: "HgTe", eta: Rgb([4.77904, 3.2312, 2.6599]), k: Rgb([1.63161, 1.58081, 1.72929]) },
    MetalIndex { name: "Ir", eta: Rgb([3.0863, 2.08219, 1.61791]), k: Rgb([5.59215, 4.06709, 3.26731]) },
    MetalIndex { name: "K", eta: Rgb([0.0640432, 0.0464098, 0.0381849]), k: Rgb([2.1042, 1.34894, 0.913126]) },
    MetalIndex { name: "Li", eta: Rgb([0.265791, 0.195618, 0.220949]), k: Rgb([3.54015, 2.31112, 1.66861]) },
    MetalIndex { name: "MgO", eta: Rgb([2.08958, 1.65072, 1.59488]), k: Rgb([4.3327e-12, 0.0, 2.49865e-11]) },
    MetalIndex { name: "Mo", eta: Rgb([4.48397, 3.52513, 2.77631]), k: Rgb([4.11144, 3.42083, 3.15061]) },
    MetalIndex { name: "Na_palik", eta: Rgb([0.0602694, 0.0561409, 0.0619884]), k: Rgb([3.17927, 2.11249, 1.57904]) },
    MetalIndex { name: "Nb", eta: Rgb([3.42007, 2.79009, 2.39563]), k: Rgb([3.44139, 2.73767, 2.57975]) },
    MetalIndex { name: "Ni_palik", eta: Rgb([2.3673, 1.66337, 1.46708]), k: Rgb([4.49881, 3.05015, 2.34544]) },
    MetalIndex { name: "Rh", eta: Rgb([2.58579, 1.86022, 1.55426]), k: Rgb([6.78226, 4.70299, 3.97607]) },
    MetalIndex { name: "Se", eta: Rgb([4.05831, 2.84294, 2.82085]), k: Rgb([0.75405, 0.638444, 0.521808]) },
    MetalIndex { name: "SiC", eta: Rgb([3.17234, 2.52597, 2.47937]), k: Rgb([7.53766e-07, 0.0, 1.01925e-05]) },
    MetalIndex { name: "SnTe", eta: Rgb([4.52425, 1.98164, 1.28159]), k: Rgb([0.0, 0.0, 0.0]) },
    MetalIndex { name: "Ta", eta: Rgb([2.06272, 2.39294, 2.62793]), k: Rgb([2.40836, 1.74149, 1.94703]) },
    MetalIndex { name: "Te", eta: Rgb([7.39023, 4.4821, 2.63711]), k: Rgb([3.25602, 3.52706, 3.29205]) },
    MetalIndex { name: "ThF4", eta: Rgb([1.83071, 1.44223, 1.38765]), k: Rgb([0.0, 0.0, 0.0]) },
    MetalIndex { name: "TiC", eta: Rgb([3.70053, 2.83742, 2.58229]), k: Rgb([3.26564, 2.35159, 2.17279]) },
    MetalIndex { name: "TiN", eta: Rgb([1.64845, 1.15052, 1.37982]), k: Rgb([3.36833, 1.9435, 1.10207]) },
    MetalIndex { name: "TiO2", eta: Rgb([3.45661, 2.80174, 2.90517]), k: Rgb([0.000105265, 0.0, 0.000652887]) },
    MetalIndex { name: "VC", eta: Rgb([3.65757, 2.75274, 2.53267]), k: Rgb([3.0683, 2.19869, 1.96319]) },
    MetalIndex { name: "V_palik", eta: Rgb([4.27758, 3.51295, 2.76107]), k: Rgb([3.4913, 2.88945, 3.11152]) },
    MetalIndex { name: "VN", eta: Rgb([2.8656, 2.11919, 1.94009]), k: Rgb([3.03224, 2.05612, 1.61631]) },
    MetalIndex { name: "W", eta: Rgb([4.37082, 3.30025, 2.99841]), k: Rgb([3.50064, 2.60487, 2.27323]) },
];

/// The material with this name, spelled as Mitsuba does.
///
/// `none`, the perfect mirror, is not in the table. If Mitsuba's data do not differ, the table has only the
/// name without `_palik`, and both names mean the same.
pub fn named(name: &str) -> Option<&'static MetalIndex> {
    let of = |name: &str| METALS.iter().find(|metal| metal.name == name);
    of(name).or_else(|| of(name.strip_suffix("_palik")?))
}

/// All names that [`named`] knows, in the table's order.
pub fn names() -> impl Iterator<Item = &'static str> {
    METALS.iter().map(|metal| metal.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gold_is_mitsubas_gold() {
        let gold = named("Au").unwrap();
        assert_eq!(gold.eta, Rgb([0.143036, 0.375307, 1.44205]));
        assert_eq!(gold.k, Rgb([3.983, 2.38556, 1.60336]));
    }

    #[test]
    fn names_are_exact_but_for_the_suffix() {
        assert!(named("au").is_none());
        assert_eq!(named("Li_palik").unwrap().name, "Li");
        assert_eq!(named("Cu_palik").unwrap().name, "Cu_palik");
    }
}
