//! Given to sweep: one value, a list of values, or a range.

use super::error::FileError;
use super::study_method::StudyMethod;
use super::table::{TomlNode, TomlTable};
use crate::method::Method;
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

/// The values of `{ from = 1000, to = 64000, times = 4 }` or `{ from = 1, to = 9, step = 2 }`, both ends
/// included.
fn range(node: &TomlNode, mut table: TomlTable) -> Result<Vec<String>, FileError> {
    let mut number = |key| {
        let number = table.take(key).map(|node| node.parsed(finite, "numbers"));
        number.transpose()
    };
    let (from, to) = (number("from")?, number("to")?);
    let (times, step) = (number("times")?, number("step")?);
    table.finish()?;
    let (Some(from), Some(to)) = (from, to) else {
        return Err(node.error(format!(
            "{}: a range needs \"from\" and \"to\", and \"times\" or \"step\"",
            node.key()
        )));
    };
    let value = |i: i32| match (times, step) {
        (Some(times), None) if times > 1.0 && from > 0.0 => Some(from * times.powi(i)),
        (None, Some(step)) if step > 0.0 => Some(from + step * f64::from(i)),
        _ => None,
    };
    let mut values = Vec::new();
    // Half a part in a billion, so that rounding does not lose the last value.
    let end = to + 5e-10 * to.abs();
    for i in 0.. {
        let value = value(i).ok_or_else(|| {
            node.error(format!(
                "{}: a range goes by \"times\" above 1 from a number above 0, or by \"step\" above 0",
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
    }
    if all.is_empty() || all.iter().any(Given::is_empty) {
        return Err(node.error("poses have parameters of the scene: { azimuth = [30, 60] }"));
    }
    if all.len() > MOST {
        return Err(node.error(format!("more than {MOST} poses")));
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
