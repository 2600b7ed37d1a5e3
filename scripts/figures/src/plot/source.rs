//! Reads the points of curves from tables.

use std::path::PathBuf;
use std::str::FromStr;

use anyhow::bail;

use crate::table::Table;

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

/// Read two columns of a table; `A/B` is the quotient of two columns. Rows that an axis cannot show (an empty field, or a
/// number that is not positive on a logarithmic axis) are skipped.
pub(super) fn curve(source: &Source, log: [bool; 2]) -> anyhow::Result<Curve> {
    let [x, y] = &source.columns;
    let mut points = Table::read(&source.table)?.points([x, y])?;
    points.retain(|(x, y)| (!log[0] || *x > 0.0) && (!log[1] || *y > 0.0));
    if points.is_empty() {
        bail!("{}: nothing to draw in {x} and {y}", source.table.display());
    }
    Ok(Curve { name: source.name.clone(), points })
}
