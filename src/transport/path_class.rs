//! Classes of light paths, by which methods share the paths among them.
//!
//! A path is written from light to camera as in Heckbert 1990 (*Adaptive Radiosity Textures for Bidirectional
//! Ray Tracing*): L, then a letter a surface, then E. S is a *delta* event: mirror reflection, smooth
//! refraction, a thin pane. G is a rough interface, which photons follow, too. D is any other: a matt
//! surface, or a turned normal. Directions from G and D have a density. Passing a null surface or the open
//! part of a mask adds no letter.
//!
//! Every path is in exactly one class. X is D or G, and A is any letter:
//!
//! | class | paths | layer | found by |
//! |---|---|---|---|
//! | [`Emitted`] | L S* E | `emitted` | paths from the camera alone |
//! | [`Direct`] | L X S* E | `direct` | paths, by sampling emitters |
//! | [`Caustic`] | L (S\|G)+ D E, L S+ G E | `caustic` | light that is connected to the camera |
//! | [`SeenCaustic`] | the same before S+ E | `caustic-sds` | photons that are looked up |
//! | [`Indirect`] | all others of L X A* X S* E | `indirect` | paths, by sampling emitters |
//! | [`IndirectCaustic`] | all others of L S+ X A* X S* E | `caustic-indirect` | light, photons |
//!
//! [`Emitted`]: PathClass::Emitted
//! [`Direct`]: PathClass::Direct
//! [`Caustic`]: PathClass::Caustic
//! [`SeenCaustic`]: PathClass::SeenCaustic
//! [`Indirect`]: PathClass::Indirect
//! [`IndirectCaustic`]: PathClass::IndirectCaustic
//!
//! A path from the camera finds light that begins with L S+ X only by running into an emitter of some size by
//! chance. It never does if all emitters are points or directions. So camera paths leave such classes to
//! light paths ([`PathClasses::CAUSTICS`]), and each path counts once. Light of a rough interface on a matt
//! surface goes with them: camera paths find it, but the smoother the interface, the less often. What is seen
//! of it on a rough interface itself is theirs: few photons go from there to the camera.

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
    /// L X S* E: direct light.
    Direct,
    /// L (S|G)+ D E or L S+ G E: a caustic, seen directly.
    Caustic,
    /// The same before S+ E: a caustic, seen by way of mirrors or glass.
    #[serde(rename = "caustic-sds")]
    SeenCaustic,
    /// Other paths that begin with L X: direct light that is scattered on.
    Indirect,
    /// Other paths that begin with L S+ X: a caustic's light that is scattered on.
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
    /// Paths whose light meets mirrors or glass before anything else that scatters it, L S+ X ... E, and
    /// those that rough interfaces bring to matt surfaces.
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

/// The event of a path at a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathEvent {
    /// S: one of finitely many directions.
    Specular,
    /// G: a rough interface.
    Glossy,
    /// D: anything else.
    Scattered,
}

/// The events on one side of one that has a density.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Others {
    any: bool,
    /// True if there is a G or a D among them.
    dense: bool,
    /// True if there is a D among them.
    scattered: bool,
}

impl Others {
    fn with(self, event: PathEvent) -> Self {
        Self {
            any: true,
            dense: self.dense || event != PathEvent::Specular,
            scattered: self.scattered || event == PathEvent::Scattered,
        }
    }
}

/// Events of a path so far, from one of its ends: enough to tell its class at the other end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PathEvents {
    /// True if there was an S before the first D or G.
    first_specular: bool,
    /// True if there was an S since the last D or G, or ever.
    last_specular: bool,
    /// The first event that is no S, and those after it.
    first: Option<(PathEvent, Others)>,
    /// The last event that is no S, and those before it.
    last: Option<(PathEvent, Others)>,
    all: Others,
}

impl PathEvents {
    /// The events with one more. Passing is no event, and is not to be reported.
    #[inline]
    #[must_use]
    pub fn then(self, event: PathEvent) -> Self {
        let is_specular = event == PathEvent::Specular;
        Self {
            first_specular: self.first_specular || is_specular && self.first.is_none(),
            last_specular: is_specular,
            first: match self.first {
                Some((first, after)) => Some((first, after.with(event))),
                None => (!is_specular).then(|| (event, Others::default())),
            },
            last: if is_specular {
                self.last
            } else {
                Some((event, self.all))
            },
            all: self.all.with(event),
        }
    }

    /// The class of a path that started at the camera and now meets an emitter.
    #[inline]
    pub fn class_at_emitter(self) -> PathClass {
        class(self.first, self.last_specular, self.first_specular)
    }

    /// The class of a path that started at an emitter and now meets the camera.
    #[inline]
    pub fn class_at_camera(self) -> PathClass {
        class(self.last, self.first_specular, self.last_specular)
    }
}

/// The class, by the D or G next to the camera with the events between it and the light, and by the presence
/// of an S at either end.
#[inline]
fn class(seen: Option<(PathEvent, Others)>, at_light: bool, at_camera: bool) -> PathClass {
    let Some((seen, before)) = seen else {
        return PathClass::Emitted;
    };
    let is_chain = if seen == PathEvent::Glossy {
        !before.dense
    } else {
        !before.scattered
    };
    match (before.any, is_chain) {
        (false, _) => PathClass::Direct,
        (true, true) if at_camera => PathClass::SeenCaustic,
        (true, true) => PathClass::Caustic,
        (true, false) if at_light => PathClass::IndirectCaustic,
        (true, false) => PathClass::Indirect,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LETTERS: [(char, PathEvent); 3] = [
        ('S', PathEvent::Specular),
        ('G', PathEvent::Glossy),
        ('D', PathEvent::Scattered),
    ];

    /// All words of S, G and D up to `length` letters, from light to camera.
    fn words(length: u32) -> impl Iterator<Item = String> {
        (0..=length).flat_map(|length| {
            let letter = move |word: usize, i: u32| LETTERS[word / 3_usize.pow(i) % 3].0;
            (0..3_usize.pow(length)).map(move |word| (0..length).map(|i| letter(word, i)).collect())
        })
    }

    fn event(letter: char) -> PathEvent {
        let found = LETTERS.iter().find(|(own, _)| *own == letter);
        found.unwrap().1
    }

    /// The class by the table's expressions, letter by letter.
    fn by_the_table(word: &str) -> PathClass {
        let seen = word.trim_end_matches('S');
        let is_seen_by_specular = seen.len() < word.len();
        let Some(on) = seen.chars().last() else {
            return PathClass::Emitted;
        };
        let before = &seen[..seen.len() - 1];
        let chain: &[char] = if on == 'G' { &['S'] } else { &['S', 'G'] };
        let is_chain = before.chars().all(|letter| chain.contains(&letter));
        match (before, is_chain, is_seen_by_specular) {
            ("", ..) => PathClass::Direct,
            (_, true, false) => PathClass::Caustic,
            (_, true, true) => PathClass::SeenCaustic,
            _ if word.starts_with('S') => PathClass::IndirectCaustic,
            _ => PathClass::Indirect,
        }
    }

    #[test]
    fn a_path_has_the_tables_class_from_either_end() {
        let mut seen = PathClasses::NONE;
        let from = |letters: &mut dyn Iterator<Item = char>| {
            letters.fold(PathEvents::default(), |events, letter| {
                events.then(event(letter))
            })
        };
        for word in words(7) {
            let expected = by_the_table(&word);
            assert_eq!(
                from(&mut word.chars()).class_at_camera(),
                expected,
                "{word}"
            );
            assert_eq!(
                from(&mut word.chars().rev()).class_at_emitter(),
                expected,
                "{word}"
            );
            seen = seen.with(expected);
        }
        assert_eq!(seen, PathClasses::ALL);
    }

    #[test]
    fn without_rough_interfaces_caustics_meet_specular_surfaces_before_a_matt_one() {
        for word in words(6).filter(|word| !word.contains('G')) {
            let is_caustic = word.starts_with('S') && word.contains('D');
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
