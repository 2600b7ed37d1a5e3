//! Reads tables: columns by their names, as numbers.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

/// A table with named columns.
pub(crate) struct Table {
    path: PathBuf,
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    pub(crate) fn read(path: &Path) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
        Table::parse(&text, path)
    }

    fn parse(text: &str, path: &Path) -> anyhow::Result<Self> {
        let mut lines = text.lines().filter(|l| !l.starts_with('#') && !l.is_empty());
        let split = |line: &str| line.split(',').map(|f| f.trim().to_string()).collect::<Vec<_>>();
        let names = split(lines.next().context("an empty table")?);
        let rows: Vec<Vec<String>> = lines.map(split).collect();
        if let Some(row) = rows.iter().find(|r| r.len() != names.len()) {
            let (path, found, columns) = (path.display(), row.len(), names.len());
            bail!("{path}: {found} fields for {columns} columns: {}", row.join(","));
        }
        Ok(Table { path: path.to_path_buf(), names, rows })
    }

    /// The rows with the fields of some columns, by name.
    pub(crate) fn fields<const N: usize>(
        &self,
        columns: [&str; N],
    ) -> anyhow::Result<Vec<[&str; N]>> {
        let mut places = [0; N];
        for (place, column) in places.iter_mut().zip(columns) {
            *place = self.place(column)?;
        }
        Ok(self.rows.iter().map(|r| places.map(|k| r[k].as_str())).collect())
    }

    fn place(&self, column: &str) -> anyhow::Result<usize> {
        self.names.iter().position(|n| n == column).with_context(|| {
            let all = self.names.join(", ");
            format!("{}: no column {column}; there are {all}", self.path.display())
        })
    }

    /// Two columns as numbers. `A/B` is the quotient of two columns. Rows with fields that are not finite numbers are skipped; it is
    /// an error if no row is left.
    pub(crate) fn points(&self, columns: [&str; 2]) -> anyhow::Result<Vec<(f64, f64)>> {
        let [x, y] = columns.map(|c| self.column(c));
        let points = x?.into_iter().zip(y?).filter(|(x, y)| x.is_finite() && y.is_finite());
        let points: Vec<(f64, f64)> = points.collect();
        if points.is_empty() {
            bail!("{}: no numbers in {}", self.path.display(), columns.join(" and "));
        }
        Ok(points)
    }

    fn column(&self, name: &str) -> anyhow::Result<Vec<f64>> {
        if let Some((a, b)) = name.split_once('/') {
            let (a, b) = (self.column(a)?, self.column(b)?);
            return Ok(a.iter().zip(b).map(|(a, b)| a / b).collect());
        }
        let k = self.place(name)?;
        Ok(self.rows.iter().map(|r| r[k].parse().unwrap_or(f64::NAN)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_that_does_not_fit_its_head_is_refused() {
        let error = Table::parse("a,b\n1,2\n3\n", Path::new("t.csv")).err().expect("a short line");
        assert!(error.to_string().contains("1 fields for 2 columns: 3"), "{error}");
    }

    #[test]
    fn quotients_of_columns_are_columns_and_gaps_are_skipped() {
        let table = Table::parse("a,b\n6,3\n,2\n8,2\n", Path::new("t.csv")).expect("a table");
        assert_eq!(table.points(["b", "a/b"]).expect("points"), [(3.0, 2.0), (2.0, 4.0)]);
        assert!(table.points(["b", "c"]).is_err());
    }
}
