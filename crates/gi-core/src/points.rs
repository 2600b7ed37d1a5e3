//! Points and meshes as files for other programs: PLY, and tables of comma-separated values (CSV).

use crate::bytes::Writer;

/// A binary PLY file. First add all elements, then write their values to `body`, element by element.
#[derive(Clone, Debug, Default)]
pub struct Ply {
    elements: String,
    /// The values.
    pub body: Writer,
}

impl Ply {
    /// Add an element. `properties` are type and name of its values, such as `float x` or `list uchar int vertex_indices`.
    pub fn element(&mut self, name: &str, count: usize, properties: &[&str]) {
        self.elements += &format!("element {name} {count}\n");
        properties.iter().for_each(|p| self.elements += &format!("property {p}\n"));
    }

    /// The file.
    pub fn into_bytes(self) -> Vec<u8> {
        let header = format!("ply\nformat binary_little_endian 1.0\n{}end_header\n", self.elements);
        [header.into_bytes(), self.body.into_bytes()].concat()
    }
}

/// A table: the names of its columns, then one line per row. Values are separated by commas.
pub fn csv(columns: &str, rows: impl IntoIterator<Item = String>) -> Vec<u8> {
    let mut out = format!("{columns}\n");
    for row in rows {
        out += &row;
        out.push('\n');
    }
    out.into_bytes()
}

/// Numbers separated by commas: a row of a table, or a part of one.
pub fn row(numbers: impl IntoIterator<Item = f32>) -> String {
    let numbers: Vec<String> = numbers.into_iter().map(|v| v.to_string()).collect();
    numbers.join(",")
}
