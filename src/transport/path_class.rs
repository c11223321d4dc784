//! Classes of light paths, by which methods share the paths among them.
//!
//! A path is written from light to camera as in Heckbert 1990 (*Adaptive Radiosity Textures for Bidirectional
//! Ray Tracing*): L, then a letter a surface, then E. S is a *delta* event: mirror reflection, smooth
//! refraction, a thin pane. D is any other: a matt surface, but also a rough interface, since the difference
//! is whether a direction has a density. Passing a null surface or the open part of a mask adds no letter.
//!
//! Every path is in exactly one class:
//!
//! | class | paths | layer | found by |
//! |---|---|---|---|
//! | [`Emitted`](PathClass::Emitted) | L S* E | `emitted` | paths from the camera alone |
//! | [`Direct`](PathClass::Direct) | L D S* E | `direct` | paths, by sampling emitters |
//! | [`Caustic`](PathClass::Caustic) | L S+ D E | `caustic` | light that is connected to the camera |
//! | [`SeenCaustic`](PathClass::SeenCaustic) | L S+ D S+ E | `caustic-sds` | photons that are looked up |
//! | [`Indirect`](PathClass::Indirect) | L D (S\|D)* D S* E | `indirect` | paths, by sampling emitters |
//! | [`IndirectCaustic`] | L S+ D (S\|D)* D S* E | `caustic-indirect` | light, photons |
//!
//! [`IndirectCaustic`]: PathClass::IndirectCaustic
//!
//! A path from the camera finds light that begins with L S+ D only by running into an emitter of some size by
//! chance. It never does if all emitters are points or directions. So camera paths leave such classes to
//! light paths ([`PathClasses::CAUSTICS`]), and each path counts once.

use std::fmt;

/// The class of a light path; see the [table](self).
///
/// # Example: the names of the layers of `full`
///
/// ```
/// let names = nephroid::PathClass::ALL.map(|class| class.name());
/// assert_eq!(names[2], "caustic");
/// assert_eq!(nephroid::PathClass::SeenCaustic.to_string(), "caustic-sds");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PathClass {
    /// L S* E: an emitter, seen directly or by way of mirrors and glass.
    Emitted,
    /// L D S* E: direct light.
    Direct,
    /// L S+ D E: a caustic, seen directly.
    Caustic,
    /// L S+ D S+ E: a caustic, seen by way of mirrors or glass.
    #[serde(rename = "caustic-sds")]
    SeenCaustic,
    /// L D (S|D)* D S* E: direct light that is scattered on.
    Indirect,
    /// L S+ D (S|D)* D S* E: a caustic's light that is scattered on.
    #[serde(rename = "caustic-indirect")]
    IndirectCaustic,
}

impl PathClass {
    /// All classes, in order.
    pub const ALL: [Self; 6] = [
        Self::Emitted,
        Self::Direct,
        Self::Caustic,
        Self::SeenCaustic,
        Self::Indirect,
        Self::IndirectCaustic,
    ];

    /// Its place in [`PathClass::ALL`].
    #[inline]
    #[doc(hidden)]
    pub fn index(self) -> usize {
        self as usize
    }

    /// The name of its layer.
    pub fn name(self) -> &'static str {
        match self {
            Self::Emitted => "emitted",
            Self::Direct => "direct",
            Self::Caustic => "caustic",
            Self::SeenCaustic => "caustic-sds",
            Self::Indirect => "indirect",
            Self::IndirectCaustic => "caustic-indirect",
        }
    }
}

impl fmt::Display for PathClass {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

/// A set of classes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PathClasses(u8);

impl serde::Serialize for PathClasses {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter())
    }
}

impl PathClasses {
    /// No path.
    pub const NONE: Self = Self(0);
    /// Every path.
    pub const ALL: Self = Self(0b11_1111);
    /// Paths whose light meets mirrors or glass before anything else that scatters it: L S+ D ... E.
    pub const CAUSTICS: Self = Self::NONE
        .with(PathClass::Caustic)
        .with(PathClass::SeenCaustic)
        .with(PathClass::IndirectCaustic);

    /// The set with a class added.
    #[must_use]
    pub const fn with(self, class: PathClass) -> Self {
        Self(self.0 | 1 << class as u8)
    }

    /// The set without another's classes.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// True if the set holds a class.
    #[inline]
    pub const fn contains(self, class: PathClass) -> bool {
        self.0 >> class as u8 & 1 == 1
    }

    /// Its classes, in order.
    pub fn iter(self) -> impl Iterator<Item = PathClass> {
        PathClass::ALL
            .into_iter()
            .filter(move |class| self.contains(*class))
    }
}

/// Events of a path so far, from one of its ends: enough to tell its class at the other end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PathEvents {
    /// True if there was an S before the first D.
    first_specular: bool,
    /// Number of D; 2 stands for more.
    scattered: u8,
    /// True if there was an S since the last D, or ever.
    last_specular: bool,
}

impl PathEvents {
    /// The events with one more: S if `is_delta`, else D. Passing is no event, and is not to be reported.
    #[inline]
    #[must_use]
    pub fn then(self, is_delta: bool) -> Self {
        if is_delta {
            Self {
                first_specular: self.first_specular || self.scattered == 0,
                last_specular: true,
                ..self
            }
        } else {
            Self {
                scattered: (self.scattered + 1).min(2),
                last_specular: false,
                ..self
            }
        }
    }

    /// The class of a path that started at the camera and now meets an emitter.
    #[inline]
    pub fn class_at_emitter(self) -> PathClass {
        class(self.scattered, self.last_specular, self.first_specular)
    }

    /// The class of a path that started at an emitter and now meets the camera.
    #[inline]
    pub fn class_at_camera(self) -> PathClass {
        class(self.scattered, self.first_specular, self.last_specular)
    }

    /// True if light has met a D, the only surface that can be connected to.
    pub fn is_scattered(self) -> bool {
        self.scattered > 0
    }
}

/// The class, by the number of D and the presence of an S between the light (or the camera) and the D next to
/// it.
#[inline]
fn class(scattered: u8, at_light: bool, at_camera: bool) -> PathClass {
    match (scattered, at_light, at_camera) {
        (0, ..) => PathClass::Emitted,
        (1, false, _) => PathClass::Direct,
        (1, true, false) => PathClass::Caustic,
        (1, true, true) => PathClass::SeenCaustic,
        (_, false, _) => PathClass::Indirect,
        (_, true, _) => PathClass::IndirectCaustic,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All words of S and D up to `length` letters, from light to camera.
    fn words(length: u32) -> impl Iterator<Item = Vec<bool>> {
        (0..=length).flat_map(|length| {
            (0..1u32 << length).map(move |bits| (0..length).map(|i| bits >> i & 1 == 1).collect())
        })
    }

    /// The class by the table's regular expressions, letter by letter.
    fn by_the_table(word: &[bool]) -> PathClass {
        let text: String = word
            .iter()
            .map(|&delta| if delta { 'S' } else { 'D' })
            .collect();
        let Some(first) = text.find('D') else {
            return PathClass::Emitted;
        };
        let caustic = first > 0;
        let after = &text[first + 1..];
        match (caustic, after) {
            (true, "") => PathClass::Caustic,
            (true, rest) if !rest.contains('D') => PathClass::SeenCaustic,
            (true, _) => PathClass::IndirectCaustic,
            (false, rest) if !rest.contains('D') => PathClass::Direct,
            (false, _) => PathClass::Indirect,
        }
    }

    #[test]
    fn a_path_has_the_tables_class_from_either_end() {
        let mut seen = PathClasses::NONE;
        for word in words(8) {
            let expected = by_the_table(&word);
            let from_light = word
                .iter()
                .fold(PathEvents::default(), |events, &delta| events.then(delta));
            let from_camera = word
                .iter()
                .rev()
                .fold(PathEvents::default(), |events, &delta| events.then(delta));
            assert_eq!(from_light.class_at_camera(), expected, "{word:?}");
            assert_eq!(from_camera.class_at_emitter(), expected, "{word:?}");
            seen = seen.with(expected);
        }
        assert_eq!(seen, PathClasses::ALL);
    }

    #[test]
    fn caustics_are_the_paths_whose_light_meets_specular_surfaces_before_a_matt_one() {
        for word in words(6) {
            let first = word.iter().position(|&delta| !delta);
            let is_caustic = first.is_some_and(|first| first > 0);
            assert_eq!(
                PathClasses::CAUSTICS.contains(by_the_table(&word)),
                is_caustic
            );
        }
        let rest = PathClasses::ALL.without(PathClasses::CAUSTICS);
        assert_eq!(
            rest.iter().collect::<Vec<_>>(),
            [PathClass::Emitted, PathClass::Direct, PathClass::Indirect]
        );
    }

    #[test]
    fn names_are_one_to_a_class_in_the_order_of_indices() {
        for (index, class) in PathClass::ALL.into_iter().enumerate() {
            assert_eq!(class.index(), index);
            let same = PathClass::ALL
                .iter()
                .filter(|other| other.name() == class.name());
            assert_eq!(same.count(), 1);
            let written = serde_json::to_value(class).unwrap();
            assert_eq!(written, class.name(), "in files it is called as its layer");
        }
    }
}
