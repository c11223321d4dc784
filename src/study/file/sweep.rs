//! Given to sweep: one value, a list of values, or a range.

use std::path::Path;

use toml::de::DeTable;

use super::error::FileError;
use super::study_method::StudyMethod;
use super::table::{Text, TomlNode, TomlTable};
use crate::method::Method;
use crate::numeric::math;
use crate::setting::Given;

/// Limit of the values of one range, and of the settings of one method: nobody means more.
const MOST: usize = 1000;

/// The values that a setting takes, as text.
pub fn values(node: &TomlNode) -> Result<Vec<String>, FileError> {
    if let Some(list) = node.list()? {
        return Ok(list);
    }
    match node.table(RANGE) {
        Some(table) => range(node, table),
        None => Ok(vec![node.scalar()?]),
    }
}

const RANGE: &str = "a range";

/// The values of `{ from = 1000, to = 64000, times = 4 }`, `{ from = 1, to = 9, step = 2 }` or
/// `{ from = 0, to = 1, count = 30 }`, both ends included.
fn range(node: &TomlNode, mut table: TomlTable) -> Result<Vec<String>, FileError> {
    let mut number = |key| {
        let number = table.take(key).map(|node| node.parsed(finite, "numbers"));
        number.transpose()
    };
    let (from, to) = (number("from")?, number("to")?);
    let (times, step) = (number("times")?, number("step")?);
    let count = table.take("count");
    let count = count.map(|node| {
        let parse = |text: &str| text.parse().ok().filter(|n| (2..=MOST).contains(n));
        node.parsed(parse, &format!("whole numbers 2..={MOST}"))
    });
    let count: Option<usize> = count.transpose()?;
    table.finish()?;
    let (Some(from), Some(to)) = (from, to) else {
        return Err(node.error(format!(
            "{}: a range needs \"from\" and \"to\", and one of \"times\", \"step\" or \"count\"",
            node.key()
        )));
    };
    if let Some(count) = count {
        if times.is_some() || step.is_some() {
            return Err(node.error(format!(
                "{}: a range has one of \"times\", \"step\" or \"count\"",
                node.key()
            )));
        }
        let last = (count - 1) as f64;
        // Each end is itself, without rounding.
        let value = |i: usize| (from * (last - i as f64) + to * i as f64) / last;
        let inner = (1..count - 1).map(value);
        let all = [from].into_iter().chain(inner).chain([to]);
        return Ok(all.map(|value| value.to_string()).collect());
    }
    let value = |i: i32| match (times, step) {
        (Some(times), None) if times > 1.0 && from > 0.0 => Some(from * math::powi(times, i)),
        (None, Some(step)) if step > 0.0 => Some(from + step * f64::from(i)),
        _ => None,
    };
    let mut values = Vec::new();
    // Half a part in a billion, so that rounding does not lose the last value.
    let end = to + 5e-10 * to.abs();
    for i in 0.. {
        let value = value(i).ok_or_else(|| {
            node.error(format!(
                "{}: a range goes by \"times\" above 1 from a number above 0, by \"step\" above 0, or by \"count\" from \
                 2 on",
                node.key()
            ))
        })?;
        if value > end {
            break;
        }
        if values.len() == MOST {
            return Err(node.error(format!(
                "{}: a range of more than {MOST} values",
                node.key()
            )));
        }
        values.push(value.to_string());
    }
    if values.is_empty() {
        return Err(node.error(format!("{}: an empty range", node.key())));
    }
    Ok(values)
}

fn finite(text: &str) -> Option<f64> {
    text.parse().ok().filter(|value: &f64| value.is_finite())
}

/// One `[[method]]`: the product of all values of its settings, the last key's fastest.
pub fn method(mut table: TomlTable) -> Result<StudyMethod, FileError> {
    let node = table.need("method")?;
    let method = node.scalar()?;
    Method::new(&method, &Given::new()).map_err(|error| node.error(error.to_string()))?;
    let name = table.take("name").map(|node| node.scalar()).transpose()?;
    let sensors = table.take("sensor").map(|node| match node.list()? {
        Some(list) => Ok(list),
        None => Ok(vec![node.scalar()?]),
    });
    let sensors = sensors.transpose()?.unwrap_or_default();
    let settings = products(&table, "runs of one method", |node, value| {
        let alone = Given::from([(node.key().to_owned(), value.to_owned())]);
        let made = Method::new(&method, &alone).map_err(|error| node.error(error.to_string()));
        made.map(drop)
    })?;
    Ok(StudyMethod {
        name: name.unwrap_or_else(|| method.clone()),
        method,
        sensors,
        settings,
    })
}

/// Poses: a table of the scene's parameters, of which all combinations are meant, or a list of such tables.
pub fn poses(node: &TomlNode) -> Result<Vec<Given>, FileError> {
    const NAME: &str = "poses";
    let tables = match node.table(NAME) {
        Some(table) => vec![table],
        None => node.tables(NAME)?,
    };
    let mut all = Vec::new();
    for table in &tables {
        all.extend(products(table, "poses", |_, _| Ok(()))?);
        if all.len() > MOST {
            return Err(node.error(format!("more than {MOST} poses")));
        }
    }
    if all.is_empty() || all.iter().any(Given::is_empty) {
        return Err(node.error("poses have parameters of the scene: { azimuth = [30, 60] }"));
    }
    Ok(all)
}

/// Frames of an animation, one text after the other: each has parameters of the scene as a study's `poses`
/// have them, without the braces.
///
/// # Errors
///
/// If a text is no table of such parameters, with its place.
pub fn frames(texts: &[String]) -> Result<Vec<Given>, FileError> {
    let mut all = Vec::new();
    for contents in texts {
        let path = Path::new("--frames");
        let text = Text { path, contents };
        let document = DeTable::parse(contents).map_err(|error| {
            let at = error.span().unwrap_or(0..0);
            text.error(&at, error.message())
        })?;
        let table = TomlTable::new(text, "--frames", 0..0, document.get_ref());
        all.extend(products(&table, "frames", |_, _| Ok(()))?);
        if all.iter().any(Given::is_empty) || all.len() > MOST {
            return Err(text.error(
                &(0..0),
                format!(
                    "frames have parameters of the scene, \"lift = {{ from = 0, to = 1, count = 30 }}\", and there \
                     are up to {MOST} frames"
                ),
            ));
        }
    }
    Ok(all)
}

/// The product of all values of a table's keys, the last key's fastest. Each value is checked by itself.
fn products(
    table: &TomlTable,
    what: &str,
    check: impl Fn(&TomlNode, &str) -> Result<(), FileError>,
) -> Result<Vec<Given>, FileError> {
    let mut products = vec![Given::new()];
    for node in table.rest() {
        let values = values(&node)?;
        if products.len().saturating_mul(values.len()) > MOST {
            return Err(node.error(format!("more than {MOST} {what}")));
        }
        for value in &values {
            check(&node, value)?;
        }
        products = products
            .iter()
            .flat_map(|settings| {
                values.iter().map(|value| {
                    let mut settings = settings.clone();
                    settings.insert(node.key().to_owned(), value.clone());
                    settings
                })
            })
            .collect();
    }
    Ok(products)
}
