//! The types and the values of parameters.

use crate::diagnostics::Span;

/// The type of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    Integer,
    Float,
    /// Points and vectors in two dimensions.
    Pair,
    /// Points, vectors and normals.
    Triple,
    Spectrum,
    Rgb,
    Xyz,
    Blackbody,
    Bool,
    String,
    Texture,
}

/// The names of the types; the shorter ones are those of pbrt-v3.
const TYPES: [(&str, Type); 18] = [
    ("integer", Type::Integer),
    ("float", Type::Float),
    ("point2", Type::Pair),
    ("vector2", Type::Pair),
    ("point3", Type::Triple),
    ("point", Type::Triple),
    ("vector3", Type::Triple),
    ("vector", Type::Triple),
    ("normal3", Type::Triple),
    ("normal", Type::Triple),
    ("spectrum", Type::Spectrum),
    ("rgb", Type::Rgb),
    ("color", Type::Rgb),
    ("xyz", Type::Xyz),
    ("blackbody", Type::Blackbody),
    ("bool", Type::Bool),
    ("string", Type::String),
    ("texture", Type::Texture),
];

impl Type {
    /// The type with this name.
    pub(super) fn of(name: &str) -> Option<Type> {
        TYPES.iter().find(|(known, _)| *known == name).map(|(_, kind)| *kind)
    }

    /// All names.
    pub(super) fn names() -> impl Iterator<Item = &'static str> {
        TYPES.iter().map(|(name, _)| *name)
    }

    /// What its values are, for messages.
    pub(super) fn expected(self) -> &'static str {
        match self {
            Type::Bool => "`true` or `false`",
            Type::String | Type::Texture => "a string in quotes",
            Type::Spectrum => "numbers or a name in quotes",
            _ => "numbers",
        }
    }

    /// Whether a parameter of this type may have these values.
    pub(super) fn accepts(self, values: &Values) -> bool {
        match values {
            Values::Numbers(_) => !matches!(self, Type::Bool | Type::String | Type::Texture),
            // A quoted boolean is pbrt-v3's.
            Values::Texts(_) => {
                matches!(self, Type::String | Type::Texture | Type::Spectrum | Type::Bool)
            }
            Values::Bools(_) => self == Type::Bool,
        }
    }
}

/// A quoted string.
#[derive(Clone, Debug)]
pub(super) struct Text {
    pub(super) text: String,
    pub(super) span: Span,
}

/// The values of a parameter.
#[derive(Debug)]
pub(super) enum Values {
    Numbers(Vec<f64>),
    Texts(Vec<Text>),
    Bools(Vec<bool>),
}

impl Values {
    pub(super) fn is_empty(&self) -> bool {
        match self {
            Values::Numbers(all) => all.is_empty(),
            Values::Texts(all) => all.is_empty(),
            Values::Bools(all) => all.is_empty(),
        }
    }

    /// What the values are, for messages.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Values::Numbers(all) if all.is_empty() => "empty",
            Values::Numbers(_) => "a number",
            Values::Texts(_) => "a string",
            Values::Bools(_) => "a boolean",
        }
    }
}
