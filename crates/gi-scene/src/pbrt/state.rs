//! The graphics state: what the directives before a shape or light have set, and the stack that keeps it.

use std::collections::HashMap;
use std::rc::Rc;

use glam::{DAffine3, DVec3};

use super::lights::AreaLight;
use super::params::Param;
use super::spectra::ColorSpace;
use crate::diagnostics::{Report, Span};
use crate::value::MAX_NUMBER;

/// Deepest nesting of `AttributeBegin`: no real scene comes near it.
const MAX_NESTING: usize = 1024;

/// What `Attribute` directives may set parameters of.
pub(super) const TARGETS: [&str; 5] = ["shape", "light", "material", "medium", "texture"];

/// The state that `AttributeBegin` keeps and `AttributeEnd` restores.
#[derive(Clone, Default)]
pub(super) struct Graphics {
    /// From the current coordinates to those of the world; before `Camera`, from the world to the camera.
    pub(super) ctm: DAffine3,
    pub(super) reverse_orientation: bool,
    /// Key of the current material.
    pub(super) material: Option<Rc<str>>,
    pub(super) area_light: Option<Rc<AreaLight>>,
    /// Names of the media inside and outside; empty for none.
    pub(super) media: [Rc<str>; 2],
    pub(super) color_space: ColorSpace,
    /// Whether transforms change only the scene at the end of the exposure, which is not shown.
    only_end: bool,
    /// Parameters that `Attribute` directives have set, for each of [`TARGETS`].
    pub(super) attributes: [Rc<Vec<Rc<Param>>>; 5],
}

/// What opened a level of the stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Opened {
    Attribute,
    /// pbrt-v3's `TransformBegin`, which keeps only the transform.
    Transform,
    Object,
}

impl Opened {
    fn name(self) -> &'static str {
        match self {
            Opened::Attribute => "AttributeBegin",
            Opened::Transform => "TransformBegin",
            Opened::Object => "ObjectBegin",
        }
    }
}

/// The graphics state with its stack and the named coordinate systems.
#[derive(Default)]
pub(super) struct State {
    pub(super) now: Graphics,
    stack: Vec<(Opened, Span, Graphics)>,
    systems: HashMap<String, DAffine3>,
}

impl State {
    /// Keep the state.
    pub(super) fn push(&mut self, opened: Opened, span: Span, report: &Report) {
        if self.stack.len() >= MAX_NESTING {
            report.error(span, format!("`{}` is nested too deeply", opened.name()), "");
        }
        // Beyond the limit nothing grows. The ends that follow are reported too.
        if self.stack.len() <= MAX_NESTING {
            self.stack.push((opened, span, self.now.clone()));
        }
    }

    /// Restore the state that was kept last. Whether the directive that kept it matches this one; otherwise an error is
    /// reported. In pbrt-v3, `AttributeEnd` and `ObjectEnd` end each other's levels.
    pub(super) fn pop(&mut self, opened: Opened, is_v3: bool, span: Span, report: &Report) -> bool {
        let alike = |other: Opened| {
            let crossed = is_v3 && other != Opened::Transform && opened != Opened::Transform;
            other == opened || crossed
        };
        match self.stack.last() {
            None => {
                let message = format!("there is no open `{}`", opened.name());
                report.error(span, message, "");
                return false;
            }
            Some((other, at, _)) if !alike(*other) => {
                let message = format!("`{}` at {} is open", other.name(), report.place(*at));
                let expected = format!("this ends `{}`", opened.name());
                report.error(span, message, &expected);
                return false;
            }
            Some(_) => {}
        }
        let (_, _, kept) = self.stack.pop().expect("the stack has an element");
        match opened {
            Opened::Transform => (self.now.ctm, self.now.only_end) = (kept.ctm, kept.only_end),
            Opened::Attribute | Opened::Object => self.now = kept,
        }
        true
    }

    /// Number of open levels.
    pub(super) fn depth(&self) -> usize {
        self.stack.len()
    }

    /// Report the levels above `depth` that were not closed in their file, and close them.
    pub(super) fn close(&mut self, depth: usize, report: &Report) {
        while self.stack.len() > depth {
            let (opened, span, kept) = self.stack.pop().expect("the stack has an element");
            report.error(span, format!("`{}` is never closed", opened.name()), "");
            self.now = kept;
        }
    }

    /// Name the current coordinate system.
    pub(super) fn name_system(&mut self, name: &str) {
        self.systems.insert(name.to_owned(), self.now.ctm);
    }

    /// Name a coordinate system.
    pub(super) fn name_this(&mut self, name: &str, m: DAffine3) {
        self.systems.insert(name.to_owned(), m);
    }

    /// The coordinate system of that name.
    pub(super) fn system(&self, name: &str) -> Option<DAffine3> {
        self.systems.get(name).copied()
    }

    /// The names of all coordinate systems.
    pub(super) fn system_names(&self) -> impl Iterator<Item = &str> {
        self.systems.keys().map(String::as_str)
    }

    /// Follow the current transform by another one.
    pub(super) fn concat(&mut self, m: DAffine3, span: Span, report: &Report) {
        self.replace(self.now.ctm * m, span, report);
    }

    /// Replace the current transform.
    pub(super) fn replace(&mut self, m: DAffine3, span: Span, report: &Report) {
        if self.now.only_end {
            return;
        }
        if m.to_cols_array().iter().all(|x| x.abs() <= f64::from(MAX_NUMBER)) {
            self.now.ctm = m;
        } else {
            let expected = "expected numbers up to 1e15";
            report.error(span, "the product of the transforms is too large", expected);
        }
    }

    /// Choose the ends of the exposure that the transforms change.
    pub(super) fn activate(&mut self, which: &str, span: Span, report: &Report) {
        match which {
            "All" | "StartTime" => self.now.only_end = false,
            "EndTime" => {
                report.warn(span, "motion is ignored: the start of the exposure is shown");
                self.now.only_end = true;
            }
            other => {
                let help = report.suggestion(other, ["All", "StartTime", "EndTime"]);
                let message = format!("unknown transform `{other}`");
                report.error_help(span, message, "expected All, StartTime or EndTime", help);
            }
        }
    }
}

/// Whether a matrix has a last row other than 0 0 0 and a number.
pub(super) fn is_projective(m: &[f64; 16]) -> bool {
    [m[3], m[7], m[11]] != [0.0; 3]
}

/// The matrix of `LookAt`, from the world to the camera; `None` if its arguments are degenerate.
pub(super) fn look_at(v: [f64; 9]) -> Result<DAffine3, &'static str> {
    let [eye, look, up] = [0, 3, 6].map(|k| DVec3::new(v[k], v[k + 1], v[k + 2]));
    let z = (look - eye).try_normalize().ok_or("the eye and the point it looks at are the same")?;
    let x = up.cross(z).try_normalize().ok_or("the up direction is parallel to the view")?;
    let from_camera =
        DAffine3 { matrix3: glam::DMat3::from_cols(x, z.cross(x), z), translation: eye };
    Ok(from_camera.inverse())
}

/// A matrix as pbrt writes it: column by column, the translation last. The last number of each column is ignored if it
/// makes the matrix projective.
pub(super) fn matrix(m: [f64; 16]) -> Result<DAffine3, &'static str> {
    if m[15] == 0.0 {
        return Err("the last number of this matrix is zero");
    }
    let column = |k: usize| DVec3::new(m[k], m[k + 1], m[k + 2]) / m[15];
    Ok(DAffine3::from_cols(column(0), column(4), column(8), column(12)))
}
