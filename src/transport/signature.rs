//! Path signatures: the events between emitter and sensor, in letters.

use std::cmp::Ordering;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The largest number of events that a [`Signature`] can hold.
pub const MAX_EVENTS: usize = 127;

/// One event of a chain: specular, or glossy.
///
/// # Example: mirror or glass
///
/// ```
/// use nephroid::{Event, Signature};
///
/// let path: Signature = "LRTD".parse()?;
/// assert_eq!(path.events().next(), Some(Event::Reflection));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Event {
    /// Mirror reflection, total internal reflection included: `R`.
    Reflection,
    /// Refraction, or passage through a thin pane: `T`.
    Transmission,
    /// Reflection or refraction by a rough interface, into one of many directions: `G`.
    Glossy,
}

/// The ordered events of a light path: `LD` (none), `LRD`, `LTTD`, `LGGD`, ...
///
/// Passing a `null` surface or the open part of a mask is no event.
///
/// Signatures are ordered by length, then letter by letter: G, R, T.
///
/// # Example: from text, and in order
///
/// ```
/// use nephroid::Signature;
///
/// let mut paths: Vec<Signature> = vec!["LTTD".parse()?, "LD".parse()?, "LRD".parse()?];
/// paths.sort();
/// assert_eq!(paths[0], Signature::DIRECT);
/// assert_eq!((paths[2].to_string(), paths[2].len()), ("LTTD".to_owned(), 2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Signature {
    /// A leading one, then one bit an event, the first event first: 1 is a transmission. As a number it grows
    /// with length, then with the letters of smooth surfaces.
    code: u128,
    /// One bit an event in the same places: 1 is a glossy event, whose bit of `code` is 0.
    glossy: u128,
}

impl Signature {
    /// Light that came straight from the emitter: `LD`.
    pub const DIRECT: Self = Self { code: 1, glossy: 0 };

    /// This path with one event more.
    ///
    /// # Panics
    ///
    /// Past [`MAX_EVENTS`] events. Settings are checked so that this cannot happen.
    #[inline]
    #[must_use]
    #[doc(hidden)]
    pub fn then(self, event: Event) -> Self {
        assert!(
            self.len() < MAX_EVENTS,
            "a signature holds {MAX_EVENTS} events"
        );
        Self {
            code: self.code << 1 | u128::from(event == Event::Transmission),
            glossy: self.glossy << 1 | u128::from(event == Event::Glossy),
        }
    }

    /// Number of events.
    #[inline]
    pub fn len(self) -> usize {
        self.code.ilog2() as usize
    }

    /// True if there was no event.
    #[inline]
    #[doc(hidden)]
    pub fn is_empty(self) -> bool {
        self == Self::DIRECT
    }

    /// The events from the emitter on.
    ///
    /// # Example: the number of reflections
    ///
    /// ```
    /// use nephroid::{Event, Signature};
    ///
    /// let path: Signature = "LTRTD".parse()?;
    /// let reflections = path.events().filter(|event| *event == Event::Reflection);
    /// assert_eq!(reflections.count(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn events(self) -> impl Iterator<Item = Event> {
        (0..self.len()).rev().map(move |place| {
            if self.code >> place & 1 == 1 {
                Event::Transmission
            } else if self.glossy >> place & 1 == 1 {
                Event::Glossy
            } else {
                Event::Reflection
            }
        })
    }

    /// True if a rough interface had part in it.
    #[inline]
    #[doc(hidden)]
    pub fn is_glossy(self) -> bool {
        self.glossy != 0
    }

    /// A number that no other signature of up to 31 specular events has, and hardly any other one.
    ///
    /// A short code is its own key. The bits of a long one beyond 32, and those of glossy events, are mixed
    /// into the key by multiplications and shifts.
    #[inline]
    #[doc(hidden)]
    pub fn key(self) -> u32 {
        let [low, high] = [32, 96].map(|shift| (self.code >> shift) as u64);
        let key = self.code as u32 ^ mixed(low, high);
        if self.glossy == 0 {
            return key;
        }
        key ^ mixed(!(self.glossy as u64), (self.glossy >> 64) as u64)
    }
}

/// 32 bits in which those of two words are mixed; 0 of two zeros.
#[inline]
fn mixed(low: u64, high: u64) -> u32 {
    let mut mixed =
        low.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ high.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 32)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (mixed ^ (mixed >> 32)) as u32
}

impl Ord for Signature {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_length = self.len().cmp(&other.len());
        // The first letter that differs.
        let differ = (self.code ^ other.code) | (self.glossy ^ other.glossy);
        by_length.then_with(|| {
            let place = differ.checked_ilog2();
            let letter =
                |of: &Self| place.map(|place| (of.glossy >> place & 1 == 0, of.code >> place & 1));
            letter(self).cmp(&letter(other))
        })
    }
}

impl PartialOrd for Signature {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Default for Signature {
    /// Light that came straight from the emitter.
    fn default() -> Self {
        Self::DIRECT
    }
}

impl fmt::Display for Signature {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut letters = String::with_capacity(self.len() + 2);
        letters.push('L');
        letters.extend(self.events().map(|event| match event {
            Event::Reflection => 'R',
            Event::Transmission => 'T',
            Event::Glossy => 'G',
        }));
        letters.push('D');
        formatter.pad(&letters)
    }
}

/// As its text.
impl Serialize for Signature {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Signature {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        String::deserialize(from)?
            .parse()
            .map_err(serde::de::Error::custom)
    }
}

/// Text that names no path.
///
/// # Example: a letter that is no event
///
/// ```
/// let error = "LXD".parse::<nephroid::Signature>().unwrap_err();
/// assert!(error.to_string().contains("letters R, T or G"));
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is no path signature: L, then up to {MAX_EVENTS} letters R, T or G, then D")]
pub struct SignatureError(String);

impl FromStr for Signature {
    type Err = SignatureError;

    fn from_str(text: &str) -> Result<Self, SignatureError> {
        let error = || SignatureError(text.to_owned());
        let letters = text
            .strip_prefix('L')
            .and_then(|rest| rest.strip_suffix('D'))
            .filter(|letters| letters.len() <= MAX_EVENTS)
            .ok_or_else(error)?;
        letters
            .chars()
            .try_fold(Self::DIRECT, |path, letter| match letter {
                'R' => Ok(path.then(Event::Reflection)),
                'T' => Ok(path.then(Event::Transmission)),
                'G' => Ok(path.then(Event::Glossy)),
                _ => Err(error()),
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signature_in_json_is_its_text() {
        let path: Signature = "LRGTD".parse().unwrap();
        let json = serde_json::to_string(&path).unwrap();
        assert_eq!(json, "\"LRGTD\"");
        assert_eq!(serde_json::from_str::<Signature>(&json).unwrap(), path);
        let error = serde_json::from_str::<Signature>("\"LXD\"").unwrap_err();
        assert!(error.to_string().contains("no path signature"), "{error}");
    }

    #[test]
    fn text_and_signature_are_the_same_thing() {
        for text in [
            "LD",
            "LRD",
            "LTTD",
            "LTRTD",
            "LGGD",
            "LTGRD",
            "LTRRRRRRRRRRRRRRTD",
        ] {
            assert_eq!(text.parse::<Signature>().unwrap().to_string(), text);
        }
        for text in ["", "L", "D", "LXD", "LTT", "TTD", "LTTDD"] {
            assert!(text.parse::<Signature>().is_err(), "{text}");
        }
    }

    #[test]
    fn the_longest_path_is_held_and_a_longer_one_refused() {
        let of = |events: usize| format!("L{}D", "RTG".repeat(64)[..events].to_owned());
        for events in [31, 32, 63, 64, MAX_EVENTS] {
            let text = of(events);
            let path: Signature = text.parse().unwrap();
            assert_eq!((path.len(), path.to_string()), (events, text));
        }
        assert!(of(MAX_EVENTS + 1).parse::<Signature>().is_err());
    }

    #[test]
    fn a_short_paths_key_is_its_own() {
        // All 2¹² − 1 signatures of up to 11 events, and long ones that differ in one letter.
        let mut paths = vec![Signature::DIRECT];
        for i in 0..(1 << 11) - 1 {
            paths
                .extend([Event::Reflection, Event::Transmission].map(|event| paths[i].then(event)));
        }
        let long = "R".repeat(MAX_EVENTS);
        paths.extend((0..MAX_EVENTS).map(|at| {
            let mut letters = long.clone();
            letters.replace_range(at..=at, "T");
            format!("L{letters}D").parse::<Signature>().unwrap()
        }));
        let mut keys: Vec<u32> = paths.iter().map(|path| path.key()).collect();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), paths.len());
    }

    #[test]
    fn glossy_paths_keys_differ_and_their_smooth_ones_are_as_before() {
        // All 3⁸ paths of 8 events, and shorter ones.
        let events = [Event::Reflection, Event::Transmission, Event::Glossy];
        let mut paths = vec![Signature::DIRECT];
        for i in 0..(3_usize.pow(8) - 1) / 2 {
            paths.extend(events.map(|event| paths[i].then(event)));
        }
        let smooth = paths.iter().filter(|path| !path.is_glossy());
        assert!(
            smooth
                .clone()
                .all(|path| u128::from(path.key()) == path.code)
        );
        assert_eq!(smooth.count(), (1 << 9) - 1);
        let mut keys: Vec<u32> = paths.iter().map(|path| path.key()).collect();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), paths.len());
        paths.sort_unstable();
        assert!(paths.windows(2).all(|pair| {
            let [a, b] = [pair[0], pair[1]].map(|path| path.to_string());
            (a.len(), a) < (b.len(), b)
        }));
    }

    #[test]
    fn signatures_sort_by_length_then_letters() {
        let mut sorted: Vec<Signature> = ["LTTD", "LD", "LTRTD", "LRTD", "LTD", "LRD"]
            .iter()
            .map(|text| text.parse().unwrap())
            .collect();
        sorted.sort();
        let texts: Vec<String> = sorted.iter().map(ToString::to_string).collect();
        assert_eq!(texts, ["LD", "LRD", "LTD", "LRTD", "LTTD", "LTRTD"]);
    }
}
