use gi_core::math::Rgb;
use glam::Affine3A;

/// Writes indented XML.
#[derive(Debug, Default)]
pub(super) struct Xml {
    text: String,
    open: Vec<String>,
}

impl Xml {
    fn line(&mut self, text: &str) {
        self.text += &"    ".repeat(self.open.len());
        self.text += text;
        self.text.push('\n');
    }

    /// Open an element.
    pub(super) fn open(&mut self, tag: &str, attributes: &[(&str, &str)]) {
        self.line(&format!("<{tag}{}>", attribute_text(attributes)));
        self.open.push(tag.to_owned());
    }

    /// Close the innermost open element; an element without contents is written as an empty one.
    pub(super) fn close(&mut self) {
        let tag = self.open.pop().expect("an open element");
        let last = self.text.trim_end().rfind('\n').map_or(0, |i| i + 1);
        let start = format!("{}<{tag}", "    ".repeat(self.open.len()));
        let is_opening = self.text[last..]
            .strip_prefix(&start)
            .is_some_and(|rest| rest.starts_with([' ', '>']) && !rest.trim_end().ends_with("/>"));
        if is_opening {
            self.text.truncate(self.text.trim_end().len() - 1);
            self.text += "/>\n";
        } else {
            self.line(&format!("</{tag}>"));
        }
    }

    /// Write an element without contents.
    pub(super) fn empty(&mut self, tag: &str, attributes: &[(&str, &str)]) {
        self.line(&format!("<{tag}{}/>", attribute_text(attributes)));
    }

    /// Write a named value.
    pub(super) fn value(&mut self, tag: &str, name: &str, value: &str) {
        self.empty(tag, &[("name", name), ("value", value)]);
    }

    /// Write a colour.
    pub(super) fn color(&mut self, name: &str, c: Rgb) {
        self.value("rgb", name, &numbers(&c.to_array()));
    }

    /// Write a transform, unless it is the identity.
    pub(super) fn transform(&mut self, name: &str, m: &Affine3A) {
        if *m == Affine3A::IDENTITY {
            return;
        }
        let [x, y, z] = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis];
        let row = |k: usize| [x[k], y[k], z[k], m.translation[k]];
        let rows = [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]];
        self.open("transform", &[("name", name)]);
        self.empty("matrix", &[("value", &numbers(rows.as_flattened()))]);
        self.close();
    }

    /// The complete text.
    pub(super) fn finish(self) -> String {
        self.text
    }
}

fn attribute_text(attributes: &[(&str, &str)]) -> String {
    attributes.iter().map(|(name, value)| format!(" {name}=\"{}\"", escape(value))).collect()
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Numbers with just enough digits to be read back exactly.
pub(super) fn numbers(values: &[f32]) -> String {
    values.iter().map(f32::to_string).collect::<Vec<_>>().join(" ")
}

/// An angle in degrees that is read back as exactly this one, if such a number exists.
pub(super) fn degrees(radians: f32) -> String {
    let near = radians.to_degrees();
    let candidates = [near, near.next_up(), near.next_down()];
    let exact = candidates.into_iter().find(|d| d.to_radians() == radians);
    exact.unwrap_or(near).to_string()
}

/// A name that is valid as an id in Mitsuba 3, which refuses dots.
pub(super) fn identifier(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).collect()
}
