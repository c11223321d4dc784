//! The parameters `$name` in attributes, from `<default>` and the command line.

use std::collections::{BTreeSet, HashMap};

use super::shortened;

/// Bytes of the longest attribute.
///
/// Defaults may use earlier defaults, so that thirty lines that each double the last would fill any memory.
/// The longest honest attributes, measured spectra, have some kilobytes.
const LONGEST: usize = 1 << 20;

/// Bytes that parameters may add to all attributes together.
///
/// A line of fifty bytes may make an attribute of [`LONGEST`]; many such lines would fill any memory. The
/// limit is 16 bytes for each of a million attributes.
const MOST_IN_ALL: usize = 1 << 24;

/// Bytes of the longest name: each `$` is compared with names of every length.
const LONGEST_NAME: usize = 128;

/// The values that `$name` stands for.
#[derive(Debug, Default)]
pub struct Parameters {
    known: HashMap<String, Parameter>,
    /// The lengths of all names. The longest name that fits is meant, so that `$spp` does not hide
    /// `$spp_final`.
    lengths: BTreeSet<usize>,
    /// Number of bytes that parameters added so far.
    added: usize,
}

#[derive(Debug)]
struct Parameter {
    value: String,
    used: bool,
}

impl Parameters {
    /// The values that the caller gives. They win over any `<default>`; the last of several for a name wins
    /// over the others.
    pub fn new(given: &[(String, String)]) -> Self {
        let mut parameters = Self::default();
        for (name, value) in given {
            let parameter = Parameter {
                value: value.clone(),
                used: false,
            };
            parameters.known.insert(name.clone(), parameter);
            parameters.lengths.insert(name.len());
        }
        parameters
    }

    /// Sets a `<default>`, which counts unless the parameter has a value already.
    ///
    /// # Errors
    ///
    /// If the name is absurdly long.
    pub fn set_default(&mut self, name: &str, value: &str) -> Result<(), String> {
        if name.len() > LONGEST_NAME {
            return Err(format!(
                "the name \"{}\" is longer than {LONGEST_NAME} bytes",
                shortened(name)
            ));
        }
        if !self.known.contains_key(name) {
            let parameter = Parameter {
                value: value.to_owned(),
                used: true,
            };
            self.known.insert(name.to_owned(), parameter);
            self.lengths.insert(name.len());
        }
        Ok(())
    }

    /// The longest name that `text` begins with.
    fn name_at<'t>(&self, text: &'t str) -> Option<&'t str> {
        if text.is_empty() {
            return None; // there is no range from 1 to 0
        }
        let prefixes = self
            .lengths
            .range(1..=text.len())
            .rev()
            .filter_map(|length| text.get(..*length));
        prefixes
            .into_iter()
            .find(|prefix| self.known.contains_key(*prefix))
    }

    /// The text with all parameters replaced and `\$` turned into `$`.
    ///
    /// # Errors
    ///
    /// If a parameter has no value, or the result is absurdly long.
    pub fn substitute(&mut self, text: &str) -> Result<String, String> {
        let mut result = String::with_capacity(text.len());
        let mut rest = text;
        while let Some(dollar) = rest.find('$') {
            let (before, after) = (&rest[..dollar], &rest[dollar + 1..]);
            if let Some(before) = before.strip_suffix('\\') {
                result.push_str(before);
                result.push('$');
                rest = after;
                continue;
            }
            result.push_str(before);
            let Some(name) = self.name_at(after) else {
                return Err(self.undefined(after));
            };
            if let Some(parameter) = self.known.get_mut(name) {
                parameter.used = true;
                result.push_str(&parameter.value);
                self.added += parameter.value.len();
            }
            if self.added > MOST_IN_ALL {
                return Err(format!(
                    "the parameters replaced so far come to more than {MOST_IN_ALL} bytes"
                ));
            }
            if result.len() > LONGEST {
                return Err(format!(
                    "the attribute is longer than {LONGEST} bytes with its parameters replaced"
                ));
            }
            rest = &after[name.len()..];
        }
        result.push_str(rest);
        Ok(result)
    }

    fn undefined(&self, after: &str) -> String {
        let end = after
            .find(|c: char| !c.is_ascii_alphanumeric() && c != '_')
            .unwrap_or(after.len());
        let name = shortened(&after[..end]);
        format!(
            "parameter ${name} has no value: give one with -D {name}=... or <default name=\"{name}\" value=\"...\"/> (known here: {})",
            if self.known.is_empty() {
                "none".to_owned()
            } else {
                self.names()
            }
        )
    }

    fn names(&self) -> String {
        let mut names: Vec<&str> = self.known.keys().map(String::as_str).collect();
        names.sort_unstable();
        names.join(", ")
    }

    /// A parameter that the caller gave and no file uses; the first by name.
    pub fn unused(&self) -> Option<&str> {
        let unused = self.known.iter().filter(|(_, parameter)| !parameter.used);
        unused.map(|(name, _)| name.as_str()).min()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given(pairs: &[(&str, &str)]) -> Parameters {
        let pairs: Vec<_> = pairs
            .iter()
            .map(|(a, b)| ((*a).to_owned(), (*b).to_owned()))
            .collect();
        Parameters::new(&pairs)
    }

    #[test]
    fn the_longest_name_wins_whatever_the_order() {
        let mut parameters = given(&[("n", "1"), ("name", "2"), ("na", "3")]);
        assert_eq!(
            parameters.substitute("$name $na $n $nx").unwrap(),
            "2 3 1 1x"
        );
    }

    #[test]
    fn the_caller_wins_over_a_default_and_the_first_default_over_the_second() {
        let mut parameters = given(&[("a", "caller")]);
        parameters.set_default("a", "file").unwrap();
        parameters.set_default("b", "first").unwrap();
        parameters.set_default("b", "second").unwrap();
        assert_eq!(parameters.substitute("$a/$b").unwrap(), "caller/first");
    }

    #[test]
    fn an_escaped_dollar_stays() {
        assert_eq!(given(&[("a", "1")]).substitute(r"\$a $a").unwrap(), "$a 1");
    }

    #[test]
    fn an_undefined_parameter_is_named_with_those_known() {
        let message = given(&[("a", "1")]).substitute("$radius.x").unwrap_err();
        assert!(
            message.contains("$radius ") && message.contains("known here: a"),
            "{message}"
        );
        assert!(given(&[]).substitute("$").is_err());
    }

    #[test]
    fn doubling_defaults_end_in_an_error() {
        let mut parameters = given(&[("p0", "12345678")]);
        for step in 0..64 {
            let value = match parameters.substitute(&format!("$p{step}$p{step}")) {
                Ok(value) => value,
                Err(message) => return assert!(message.contains("longer than"), "{message}"),
            };
            parameters
                .set_default(&format!("p{}", step + 1), &value)
                .unwrap();
        }
        panic!("64 doublings went through");
    }

    #[test]
    fn what_the_caller_gave_in_vain_is_known() {
        let mut parameters = given(&[("a", "1"), ("b", "2")]);
        parameters.substitute("$b").unwrap();
        assert_eq!(parameters.unused(), Some("a"));
        parameters.substitute("$a").unwrap();
        assert_eq!(parameters.unused(), None);
    }
}
