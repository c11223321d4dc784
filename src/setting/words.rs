//! Enums whose values are words, for settings and reports.

/// A value that is one of a few words.
pub trait Words: Copy + PartialEq + 'static {
    /// Each word, its value, and its meaning in one line.
    const WORDS: &'static [(&'static str, Self, &'static str)];

    /// The word of this value.
    fn word(self) -> &'static str {
        let found = Self::WORDS.iter().find(|(_, value, _)| *value == self);
        found.map_or("", |(word, _, _)| word)
    }

    /// The meaning of this value.
    fn meaning(self) -> &'static str {
        let found = Self::WORDS.iter().find(|(_, value, _)| *value == self);
        found.map_or("", |(_, _, meaning)| meaning.trim())
    }

    /// The value of a word, if there is one.
    fn of_word(word: &str) -> Option<Self> {
        let found = Self::WORDS.iter().find(|(known, _, _)| *known == word);
        found.map(|(_, value, _)| *value)
    }
}

/// The words of a type with their meanings, as [`Kind::Choice`](super::Kind::Choice) takes them.
pub fn words_of<T: Words>() -> Vec<(&'static str, &'static str)> {
    let words = T::WORDS.iter();
    words
        .map(|(word, _, meaning)| (*word, meaning.trim()))
        .collect()
}

/// Makes an enum whose variants have words. The first lines of their docs are their meanings in help texts.
macro_rules! words {
    ($(#[doc = $doc:literal])* $name:ident {
        $(#[doc = $meaning:literal] $(#[doc = $more:literal])* $variant:ident = $word:literal,)+
    }) => {
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
        pub enum $name {
            $(#[doc = $meaning] $(#[doc = $more])* #[serde(rename = $word)] $variant,)+
        }

        impl $crate::setting::Words for $name {
            const WORDS: &'static [(&'static str, Self, &'static str)] =
                &[$(($word, Self::$variant, $meaning),)+];
        }
    };
}

pub(crate) use words;
