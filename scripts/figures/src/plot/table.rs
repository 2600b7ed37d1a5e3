//! Reads the points of curves from tables.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Context, bail};

/// The table and columns of a curve.
#[derive(Clone, Debug)]
pub(super) struct Source {
    name: String,
    table: PathBuf,
    columns: [String; 2],
}

impl FromStr for Source {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = "expected NAME=TABLE.csv:X:Y";
        let (name, rest) = text.rsplit_once('=').ok_or(wrong)?;
        let mut parts = rest.split(':');
        let mut next = || parts.next().map(str::to_string).ok_or(wrong);
        let (table, x, y) = (next()?, next()?, next()?);
        Ok(Source { name: name.into(), table: table.into(), columns: [x, y] })
    }
}

/// A curve with its points.
pub(super) struct Curve {
    pub(super) name: String,
    pub(super) points: Vec<(f64, f64)>,
}

/// Read two columns of a table. Rows that an axis cannot show (an empty field, or a number that is not positive on a
/// logarithmic axis) are skipped.
pub(super) fn curve(source: &Source, log: [bool; 2]) -> anyhow::Result<Curve> {
    let text = std::fs::read_to_string(&source.table)
        .with_context(|| source.table.display().to_string())?;
    let columns = columns(&text, &source.table)?;
    let column = |name: &String| {
        columns.get(name.as_str()).with_context(|| {
            let all: Vec<&str> = columns.keys().copied().collect();
            format!("{}: no column {name}; there are {}", source.table.display(), all.join(", "))
        })
    };
    let (xs, ys) = (column(&source.columns[0])?, column(&source.columns[1])?);
    let shown = |v: f64, log: bool| v.is_finite() && (!log || v > 0.0);
    let points: Vec<(f64, f64)> = xs
        .iter()
        .zip(ys)
        .filter_map(|(x, y)| Some((x.parse().ok()?, y.parse().ok()?)))
        .filter(|(x, y)| shown(*x, log[0]) && shown(*y, log[1]))
        .collect();
    if points.is_empty() {
        bail!("{}: nothing to draw in {}", source.table.display(), source.columns.join(" and "));
    }
    Ok(Curve { name: source.name.clone(), points })
}

/// The fields of every column, by column name.
fn columns<'t>(text: &'t str, path: &Path) -> anyhow::Result<HashMap<&'t str, Vec<&'t str>>> {
    let mut lines = text.lines().filter(|l| !l.starts_with('#') && !l.is_empty());
    let names: Vec<&str> = lines.next().context("an empty table")?.split(',').collect();
    let mut columns: Vec<Vec<&str>> = vec![Vec::new(); names.len()];
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        if fields.len() != names.len() {
            bail!(
                "{}: {} fields for {} columns: {line}",
                path.display(),
                fields.len(),
                names.len()
            );
        }
        columns.iter_mut().zip(fields).for_each(|(column, field)| column.push(field.trim()));
    }
    Ok(names.into_iter().map(str::trim).zip(columns).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_that_does_not_fit_its_head_is_refused() {
        let error = columns("a,b\n1,2\n3\n", Path::new("t.csv")).expect_err("a short line");
        assert!(error.to_string().contains("1 fields for 2 columns: 3"), "{error}");
    }
}
