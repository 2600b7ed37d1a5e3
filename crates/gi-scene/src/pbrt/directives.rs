//! Directives: the statements of a pbrt file.

use std::rc::Rc;

use glam::{DAffine3, DVec3};

use super::Translator;
use super::lexer::{Kind, Token};
use super::params::Params;
use super::reader::{MAX_PARAMETERS, Reader};
use super::spectra::ColorSpace;
use super::state::{self, Opened, TARGETS};
use super::types::Text;
use crate::diagnostics::Span;

/// All directives. `WorldEnd` is pbrt-v3's.
const DIRECTIVES: [&str; 38] = [
    "Accelerator",
    "ActiveTransform",
    "AreaLightSource",
    "Attribute",
    "AttributeBegin",
    "AttributeEnd",
    "Camera",
    "ColorSpace",
    "ConcatTransform",
    "CoordSysTransform",
    "CoordinateSystem",
    "Film",
    "Identity",
    "Import",
    "Include",
    "Integrator",
    "LightSource",
    "LookAt",
    "MakeNamedMaterial",
    "MakeNamedMedium",
    "Material",
    "MediumInterface",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "Option",
    "PixelFilter",
    "ReverseOrientation",
    "Rotate",
    "Sampler",
    "Scale",
    "Shape",
    "Texture",
    "Transform",
    "TransformBegin",
    "TransformEnd",
    "Translate",
];

/// Directives that are missing in the list above because they belong together.
const WORLD: [&str; 3] = ["WorldBegin", "WorldEnd", "TransformTimes"];

/// Directives of pbrt-v2 that later versions do not have.
const VERSION_2: [&str; 4] = ["SurfaceIntegrator", "VolumeIntegrator", "Renderer", "Volume"];

/// Whether a word is a directive.
pub(super) fn is_directive(word: &str) -> bool {
    DIRECTIVES.contains(&word) || WORLD.contains(&word)
}

impl Translator<'_> {
    /// Read all directives of a text.
    pub(super) fn directives(&mut self, reader: &mut Reader<'_>) {
        while let Some(token) = reader.next() {
            let word = reader.word(&token);
            let span = reader.span(&token);
            if token.kind != Kind::Word || !is_directive(word) {
                self.unknown_directive(word, span);
                skip(reader);
                continue;
            }
            if self.directive(word, span, reader).is_none() {
                skip(reader);
            }
        }
    }

    fn unknown_directive(&self, word: &str, span: Span) {
        if VERSION_2.contains(&word) {
            let message = format!("`{word}` is a directive of pbrt-v2, which is not supported");
            let help = "without this directive, the file is read as pbrt-v3";
            self.report.error_help(span, message, "", Some(help.into()));
            return;
        }
        let shown: String = word.chars().take(40).collect();
        let help = self.report.suggestion(&shown, DIRECTIVES.into_iter().chain(WORLD));
        self.report.error_help(
            span,
            format!("unknown directive `{shown}`"),
            "expected a directive",
            help,
        );
    }

    /// Read one directive. `None` after an error in its arguments: what follows is skipped.
    fn directive(&mut self, word: &str, span: Span, reader: &mut Reader<'_>) -> Option<()> {
        match word {
            "Identity" => self.state.replace(DAffine3::IDENTITY, span, self.report),
            "Translate" | "Scale" | "Rotate" | "LookAt" | "ConcatTransform" | "Transform" => {
                return self.transform(word, span, reader);
            }
            "CoordinateSystem" => self.state.name_system(&reader.name("a name")?.text),
            "CoordSysTransform" => self.use_system(&reader.name("a name")?),
            "ActiveTransform" => {
                let (which, at) = reader.bare_word("All, StartTime or EndTime")?;
                self.state.activate(which, at, self.report);
            }
            "TransformTimes" => drop(reader.numbers::<2>()?),
            "AttributeBegin" => self.state.push(Opened::Attribute, span, self.report),
            "AttributeEnd" => self.end(Opened::Attribute, span),
            "TransformBegin" => self.state.push(self.transform_level(), span, self.report),
            "TransformEnd" => self.end(self.transform_level(), span),
            "ReverseOrientation" => {
                self.state.now.reverse_orientation = !self.state.now.reverse_orientation;
            }
            "Attribute" => return self.attribute(reader),
            "ColorSpace" => self.color_space(&reader.name("a colour space")?),
            "Option" => {
                reader.name("the name of an option")?;
                reader.next();
            }
            "WorldBegin" => self.world_begin(span),
            "WorldEnd" => {}
            "Include" | "Import" => {
                let name = reader.name("the name of a file")?;
                self.include(&name);
            }
            _ => return self.object(word, span, reader),
        }
        Some(())
    }

    /// Read a directive that makes something.
    fn object(&mut self, word: &str, span: Span, reader: &mut Reader<'_>) -> Option<()> {
        match word {
            "ObjectBegin" => self.object_begin(&reader.name("a name")?, span),
            "ObjectEnd" => self.object_end(span),
            "ObjectInstance" => self.object_instance(&reader.name("a name")?),
            "NamedMaterial" => self.use_material(&reader.name("the name of a material")?),
            "MediumInterface" => {
                let inside = reader.name("the name of a medium")?;
                let outside = reader.another_name().unwrap_or_else(|| inside.clone());
                self.medium_interface(&inside, &outside);
            }
            "Texture" => {
                let name = reader.name("the name of the texture")?;
                let kind = reader.name("`float` or `spectrum`")?;
                let params = self.params("texture", reader)?;
                self.define_texture(&name, &kind, &params);
            }
            "Material" => {
                let params = self.params("material", reader)?;
                self.current_material(&params);
            }
            "MakeNamedMaterial" => {
                let params = self.params("material", reader)?;
                self.named_material(&params);
            }
            "MakeNamedMedium" => {
                let params = self.params("medium", reader)?;
                self.named_medium(&params);
            }
            "Shape" => {
                let params = self.params("shape", reader)?;
                self.needs_world(word, span);
                self.shape(&params);
            }
            "LightSource" => {
                let params = self.params("light", reader)?;
                self.needs_world(word, span);
                self.light(&params);
            }
            "AreaLightSource" => {
                let params = self.params("area light", reader)?;
                self.area_light(&params);
            }
            "Camera" => {
                let params = self.params("camera", reader)?;
                self.camera(params);
            }
            "Film" => self.film = Some(self.params("film", reader)?),
            "PixelFilter" => self.filter = Some(self.params("filter", reader)?),
            "Integrator" => self.integrator = Some(self.params("integrator", reader)?),
            // How pbrt samples and searches; our programs decide for themselves.
            "Sampler" | "Accelerator" => drop(self.params("sampler", reader)?),
            _ => unreachable!("a directive of the list"),
        }
        Some(())
    }

    /// The name and the parameters of a directive. An error if it has too many.
    fn params(&self, what: &'static str, reader: &mut Reader<'_>) -> Option<Params> {
        let name = reader.name("the name of a type")?;
        let own = reader.parameters();
        let target = match what {
            "area light" => "light",
            other => other,
        };
        let inherited = TARGETS.iter().position(|t| *t == target);
        let inherited = inherited.map(|k| self.state.now.attributes[k].clone());
        Some(Params::new(what, name, own, inherited.unwrap_or_default()))
    }

    fn transform(&mut self, word: &str, span: Span, reader: &mut Reader<'_>) -> Option<()> {
        let m = match word {
            "Translate" => Ok(DAffine3::from_translation(DVec3::from(reader.numbers::<3>()?))),
            "Scale" => Ok(DAffine3::from_scale(DVec3::from(reader.numbers::<3>()?))),
            "Rotate" => {
                let [degrees, x, y, z] = reader.numbers::<4>()?;
                let axis = DVec3::new(x, y, z).try_normalize().ok_or("this rotation has no axis");
                axis.map(|axis| DAffine3::from_axis_angle(axis, degrees.to_radians()))
            }
            "LookAt" => state::look_at(reader.numbers::<9>()?),
            _ => {
                let m = reader.numbers::<16>()?;
                if state::is_projective(&m) {
                    let message = "this matrix is projective: its last row is read as 0 0 0 1";
                    self.report.warn(span, message);
                }
                state::matrix(m)
            }
        };
        match m {
            Ok(m) if word == "Transform" => self.state.replace(m, span, self.report),
            Ok(m) => self.state.concat(m, span, self.report),
            Err(why) => self.report.error(span, why, ""),
        }
        Some(())
    }

    fn use_system(&mut self, name: &Text) {
        match self.state.system(&name.text) {
            Some(m) => self.state.replace(m, name.span, self.report),
            None => {
                let help = self.report.suggestion(&name.text, self.state.system_names());
                let message = format!("no coordinate system is named `{}`", name.text);
                self.report.error_help(name.span, message, "", help);
            }
        }
    }

    /// What `TransformBegin` keeps: in pbrt-v4 everything, in pbrt-v3 only the transform.
    fn transform_level(&self) -> Opened {
        if self.is_v3 { Opened::Transform } else { Opened::Attribute }
    }

    fn end(&mut self, opened: Opened, span: Span) {
        self.state.pop(opened, self.is_v3, span, self.report);
    }

    fn attribute(&mut self, reader: &mut Reader<'_>) -> Option<()> {
        let target = reader.name("shape, light, material, medium or texture")?;
        let added = reader.parameters();
        let Some(k) = TARGETS.iter().position(|t| *t == target.text) else {
            let help = self.report.suggestion(&target.text, TARGETS);
            let message = format!("unknown target `{}`", target.text);
            let expected = "expected shape, light, material, medium or texture";
            self.report.error_help(target.span, message, expected, help);
            return Some(());
        };
        let all = Rc::make_mut(&mut self.state.now.attributes[k]);
        all.extend(added);
        if all.len() > MAX_PARAMETERS {
            all.truncate(MAX_PARAMETERS);
            let message = format!("more than {MAX_PARAMETERS} parameters of `Attribute`");
            self.report.error(target.span, message, "");
        }
        Some(())
    }

    fn color_space(&mut self, name: &Text) {
        match ColorSpace::named(&name.text) {
            Some(space) => self.state.now.color_space = space,
            None => {
                let help = self.report.suggestion(&name.text, ColorSpace::NAMES);
                let message = format!("unknown colour space `{}`", name.text);
                self.report.error_help(name.span, message, "expected a colour space", help);
            }
        }
    }

    fn world_begin(&mut self, span: Span) {
        if std::mem::replace(&mut self.in_world, true) {
            self.report.error(span, "a second `WorldBegin`", "");
        }
        self.state.now.ctm = DAffine3::IDENTITY;
        self.state.activate("All", span, self.report);
        self.state.name_this("world", DAffine3::IDENTITY);
    }

    /// Report something that belongs after `WorldBegin`, once.
    fn needs_world(&mut self, word: &str, span: Span) {
        if !self.in_world {
            self.in_world = true;
            self.report.error(span, format!("`{word}` before `WorldBegin`"), "");
        }
    }
}

/// Skip to the next directive.
fn skip(reader: &mut Reader<'_>) {
    let stops =
        |t: &Token, reader: &Reader<'_>| t.kind == Kind::Word && is_directive(reader.word(t));
    while reader.peek().is_some_and(|t| !stops(&t, reader)) {
        reader.next();
    }
}
