//! The header of a PLY file: its format, and the types of its elements.

/// Largest header, bytes.
const MAX_HEADER: usize = 1 << 16;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn parse(name: &str) -> Result<Kind, String> {
        Ok(match name {
            "char" | "int8" => Kind::I8,
            "uchar" | "uint8" => Kind::U8,
            "short" | "int16" => Kind::I16,
            "ushort" | "uint16" => Kind::U16,
            "int" | "int32" => Kind::I32,
            "uint" | "uint32" => Kind::U32,
            "float" | "float32" => Kind::F32,
            "double" | "float64" => Kind::F64,
            other => return Err(format!("unknown type `{other}`")),
        })
    }
}

#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// The type of the list's length, if this is a list.
    pub(super) list: Option<Kind>,
}

#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Ascii,
    Little,
    Big,
}

#[derive(Debug)]
pub(super) struct Header {
    pub(super) format: Format,
    pub(super) elements: Vec<Element>,
}

impl Header {
    pub(super) fn parse(bytes: &[u8]) -> Result<(Header, &[u8]), String> {
        let mut rest = bytes;
        let mut line = || -> Result<Vec<String>, String> {
            let window = &rest[..rest.len().min(MAX_HEADER)];
            let end =
                window.iter().position(|&b| b == b'\n').ok_or("the header is not terminated")?;
            let text = String::from_utf8_lossy(&rest[..end]).into_owned();
            rest = &rest[end + 1..];
            Ok(text.split_whitespace().map(str::to_owned).collect())
        };
        if line()? != ["ply"] {
            return Err("it does not start with `ply`".into());
        }
        let mut format = None;
        let mut elements: Vec<Element> = Vec::new();
        loop {
            let words = line()?;
            match words.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
                ["format", "ascii", _] => format = Some(Format::Ascii),
                ["format", "binary_little_endian", _] => format = Some(Format::Little),
                ["format", "binary_big_endian", _] => format = Some(Format::Big),
                ["element", name, count] => {
                    let count = count.parse().map_err(|_| format!("`{count}` is not a count"))?;
                    elements.push(Element {
                        name: (*name).to_owned(),
                        count,
                        properties: Vec::new(),
                    });
                }
                ["property", "list", count, kind, name] => {
                    let list = Some(Kind::parse(count)?);
                    let element = elements.last_mut().ok_or("a property before any element")?;
                    let (name, kind) = ((*name).to_owned(), Kind::parse(kind)?);
                    element.properties.push(Property { name, kind, list });
                }
                ["property", kind, name] => {
                    let element = elements.last_mut().ok_or("a property before any element")?;
                    let (name, kind) = ((*name).to_owned(), Kind::parse(kind)?);
                    element.properties.push(Property { name, kind, list: None });
                }
                ["end_header"] => break,
                ["comment" | "obj_info", ..] | [] => {}
                other => return Err(format!("the header says `{}`", other.join(" "))),
            }
        }
        Ok((Header { format: format.ok_or("the header names no format")?, elements }, rest))
    }
}
