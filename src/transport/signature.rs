//! What happened to light between emitter and sensor, in letters.

use std::fmt;
use std::str::FromStr;

/// The longest chain of specular events a [`Signature`] can hold.
pub const MAX_EVENTS: usize = 31;

/// One specular event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Event {
    /// Mirror reflection, total internal reflection included: `R`.
    Reflection,
    /// Refraction, or passage through a thin pane: `T`.
    Transmission,
}

/// The ordered specular events of a light path: `LD` (none), `LRD`, `LTTD`, ...
///
/// Passing a `null` surface or the open part of a mask is no event.
///
/// Signatures are ordered by length, then letter by letter with R before T.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Signature {
    /// A leading one, then a bit an event from the first on: 1 is a transmission. As a number
    /// it grows with length, then with the letters.
    code: u32,
}

impl Signature {
    /// Light that came straight from the emitter: `LD`.
    pub const DIRECT: Self = Self { code: 1 };

    /// This path with one event more.
    ///
    /// # Panics
    ///
    /// Past [`MAX_EVENTS`] events; settings are checked not to allow that.
    #[inline]
    #[must_use]
    pub fn then(self, event: Event) -> Self {
        assert!(
            self.len() < MAX_EVENTS,
            "a signature holds {MAX_EVENTS} events"
        );
        Self {
            code: self.code << 1 | u32::from(event == Event::Transmission),
        }
    }

    /// How many specular events there were.
    #[inline]
    pub fn len(self) -> usize {
        self.code.ilog2() as usize
    }

    /// Whether there was no specular event.
    #[inline]
    pub fn is_empty(self) -> bool {
        self == Self::DIRECT
    }

    /// The events from the emitter on.
    pub fn events(self) -> impl Iterator<Item = Event> {
        (0..self.len()).rev().map(move |place| {
            if self.code >> place & 1 == 1 {
                Event::Transmission
            } else {
                Event::Reflection
            }
        })
    }

    /// A number that no other signature has.
    #[inline]
    pub fn code(self) -> u32 {
        self.code
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
        }));
        letters.push('D');
        formatter.pad(&letters)
    }
}

/// Text that names no path.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is no path signature: L, then up to {MAX_EVENTS} letters R or T, then D")]
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
                _ => Err(error()),
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_and_signature_are_the_same_thing() {
        for text in ["LD", "LRD", "LTTD", "LTRTD", "LTRRRRRRRRRRRRRRTD"] {
            assert_eq!(text.parse::<Signature>().unwrap().to_string(), text);
        }
        for text in ["", "L", "D", "LXD", "LTT", "TTD", "LTTDD"] {
            assert!(text.parse::<Signature>().is_err(), "{text}");
        }
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
