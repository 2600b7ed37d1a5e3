//! Participating media.

use gi_core::math::Rgb;
use gi_core::medium::MediumId;
use gi_core::medium::{Medium, Phase};

use crate::builder::Builder;
use crate::document::{Class, Meaning, Node};

mod heterogeneous;
mod measured;

pub(crate) use heterogeneous::InlineGrid;

impl Builder<'_> {
    /// The medium of an object, built when first used; `None` if an error was reported.
    pub(crate) fn medium(&mut self, node: Node<'_>) -> Option<MediumId> {
        if let Some(&known) = self.medium_of.get(&node.id) {
            return Some(known);
        }
        let medium = match node.plugin() {
            "homogeneous" => homogeneous(node)?,
            "heterogeneous" => self.heterogeneous(node)?,
            _ => {
                node.unknown_plugin(&["homogeneous", "heterogeneous"]);
                return None;
            }
        };
        self.parts.media.push(medium);
        self.origins.media.push(node.object().id.clone());
        let id = MediumId::new(self.parts.media.len() - 1);
        self.medium_of.insert(node.id, id);
        Some(id)
    }
}

/// A homogeneous medium, given as (sigma_t, albedo) or (sigma_s, sigma_a), times `scale`.
fn homogeneous(node: Node<'_>) -> Option<Medium> {
    node.ignore(&["has_spectral_extinction", "sample_emitters", "strategy", "method"]);
    let scale = node.float("scale", 1.0);
    let (sigma_s, sigma_a) = (color(node, "sigma_s"), color(node, "sigma_a"));
    let (sigma_t, albedo) = if sigma_s.is_some() || sigma_a.is_some() {
        let s = sigma_s.unwrap_or(Rgb::BLACK);
        let t = s + sigma_a.unwrap_or(Rgb::BLACK);
        (t, albedo_of(s, t))
    } else {
        let named = node.text("material").map(|name| measured_medium(node, name));
        let given = node.has("sigma_t") || node.has("albedo") || node.child("sigma_t").is_some();
        // In Mitsuba 0.6, a medium without any parameter is skin.
        let (t, albedo) = match named {
            Some(medium) => medium?,
            None if node.doc.version == 0 && !given => measured_medium(node, "Skin1")?,
            None => (Rgb::WHITE, Rgb::grey(0.75)),
        };
        (color(node, "sigma_t").unwrap_or(t), color(node, "albedo").unwrap_or(albedo))
    };
    let sigma_t = sigma_t * scale;
    if sigma_t.to_array().into_iter().chain(albedo.to_array()).any(|v| v < 0.0)
        || albedo.max() > 1.0
    {
        node.error("a medium that amplifies light", "expected sigma >= 0 and albedo in [0, 1]");
        return None;
    }
    Some(Medium::homogeneous(sigma_t, albedo, phase(node)))
}

/// Extinction and albedo of a medium that Mitsuba 0.6 knows by name.
fn measured_medium(node: Node<'_>, name: &str) -> Option<(Rgb, Rgb)> {
    let Some((s, a)) = measured::coefficients(name) else {
        let help = node.report.suggestion(name, measured::names());
        let message = format!("unknown medium `{name}`");
        let expected = "expected a measured medium, such as `skin1`, or sigma_t and albedo";
        node.report.error_help(node.span_of("material"), message, expected, help);
        return None;
    };
    let t = s + a;
    Some((t, albedo_of(s, t)))
}

/// Scattering over extinction.
fn albedo_of(s: Rgb, t: Rgb) -> Rgb {
    s.zip(t, |s, t| if t > 0.0 { s / t } else { 0.0 })
}

/// The colour of a homogeneous medium, or of a `constvolume`.
fn color(node: Node<'_>, name: &'static str) -> Option<Rgb> {
    match node.child_if(name, |n| n.class() == Class::Volume) {
        Some(volume) if volume.plugin() == "constvolume" => volume.color("value", Meaning::Factor),
        Some(volume) => {
            let message = "a homogeneous medium is the same everywhere";
            volume.error(message, "expected a colour: make the medium `heterogeneous`");
            None
        }
        None => node.color(name, Meaning::Factor),
    }
}

fn phase(node: Node<'_>) -> Phase {
    let children = node.children(Class::Phase);
    let Some(phase) = children.first() else { return Phase::Isotropic };
    match phase.plugin() {
        "isotropic" => Phase::Isotropic,
        "rayleigh" => Phase::Rayleigh,
        "hg" => {
            let g = phase.float("g", 0.8);
            if g.abs() >= 1.0 {
                phase.report.error(phase.span_of("g"), format!("g = {g}"), "expected -1 < g < 1");
            }
            Phase::HenyeyGreenstein { g }
        }
        _ => {
            phase.unknown_plugin(&["isotropic", "hg", "rayleigh"]);
            Phase::Isotropic
        }
    }
}
