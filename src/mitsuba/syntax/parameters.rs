//! `$name` in attributes, from `<default>` and the command line.

/// How long an attribute may become.
///
/// Defaults may use earlier defaults, so that thirty lines that each double the last would fill
/// any memory. The longest honest attributes, measured spectra, have some kilobytes.
const LONGEST: usize = 1 << 20;

/// The values that `$name` stands for.
#[derive(Debug)]
pub struct Parameters {
    /// Longest name first, so that `$spp` does not hide `$spp_final`.
    known: Vec<Parameter>,
}

#[derive(Debug)]
struct Parameter {
    name: String,
    value: String,
    used: bool,
}

impl Parameters {
    /// What the caller gives; it wins over any `<default>`.
    pub fn new(given: &[(String, String)]) -> Self {
        let mut parameters = Self { known: Vec::new() };
        for (name, value) in given {
            // The last of several settings counts, as with any command line.
            parameters.known.retain(|parameter| parameter.name != *name);
            parameters.insert(name, value, false);
        }
        parameters
    }

    /// A `<default>`: counts unless the parameter has a value already.
    pub fn set_default(&mut self, name: &str, value: &str) {
        if !self.known.iter().any(|parameter| parameter.name == name) {
            self.insert(name, value, true);
        }
    }

    fn insert(&mut self, name: &str, value: &str, used: bool) {
        let place = self
            .known
            .partition_point(|parameter| parameter.name.len() >= name.len());
        let parameter = Parameter {
            name: name.to_owned(),
            value: value.to_owned(),
            used,
        };
        self.known.insert(place, parameter);
    }

    /// The text with all parameters replaced and `\$` turned into `$`.
    ///
    /// # Errors
    ///
    /// Where a parameter has no value, or the result is absurdly long.
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
            let named = (self.known.iter_mut())
                .find(|parameter| !parameter.name.is_empty() && after.starts_with(&parameter.name));
            let Some(parameter) = named else {
                return Err(self.undefined(after));
            };
            parameter.used = true;
            result.push_str(&parameter.value);
            if result.len() > LONGEST {
                return Err(format!(
                    "the attribute is longer than {LONGEST} bytes with its parameters replaced"
                ));
            }
            rest = &after[parameter.name.len()..];
        }
        result.push_str(rest);
        Ok(result)
    }

    fn undefined(&self, after: &str) -> String {
        let end = after
            .find(|c: char| !c.is_ascii_alphanumeric() && c != '_')
            .unwrap_or(after.len());
        let name = &after[..end];
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
        let mut names: Vec<&str> = self
            .known
            .iter()
            .map(|parameter| parameter.name.as_str())
            .collect();
        names.sort_unstable();
        names.join(", ")
    }

    /// A parameter that the caller gave and no file uses.
    pub fn unused(&self) -> Option<&str> {
        self.known
            .iter()
            .find(|parameter| !parameter.used)
            .map(|parameter| parameter.name.as_str())
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
        parameters.set_default("a", "file");
        parameters.set_default("b", "first");
        parameters.set_default("b", "second");
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
            parameters.set_default(&format!("p{}", step + 1), &value);
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
