//! Reads the pictures that a material library names.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gi_core::math::Rgb;
use gi_core::texture::{Bitmap, Lookup, Texture, Wrap};
use glam::{Affine2, Mat2, Vec2};

use super::Reader;
use super::mtl::Map;
use crate::files::{self, Folders, Found};
use crate::statements::{name_before_comment, unquoted};
use crate::texels::BitmapFile;
use crate::value;

/// All pictures that were searched for or read so far.
#[derive(Debug, Default)]
pub(super) struct Pictures {
    /// For each name, the file that was found.
    places: HashMap<String, Option<PathBuf>>,
    read: HashMap<BitmapFile, Option<Arc<Bitmap>>>,
}

/// Options of `map_*` and the number of their arguments; `-o`, `-s` and `-t` have one to three.
const OPTIONS: [(&str, usize); 13] = [
    ("-blendu", 1),
    ("-blendv", 1),
    ("-bm", 1),
    ("-boost", 1),
    ("-cc", 1),
    ("-clamp", 1),
    ("-colorspace", 1),
    ("-imfchan", 1),
    ("-mm", 2),
    ("-o", 3),
    ("-s", 3),
    ("-t", 3),
    ("-texres", 1),
];
/// Options that affect only filtering, or that state what is true anyway.
const WITHOUT_EFFECT: [&str; 5] = ["-blendu", "-blendv", "-boost", "-texres", "-cc"];

/// How a picture is mapped to a surface, and its name.
#[derive(Debug, PartialEq)]
struct Mapping<'a> {
    name: &'a str,
    scale: Vec2,
    offset: Vec2,
    clamp: bool,
    /// Unsupported options that would change the picture.
    ignored: Vec<&'a str>,
}

/// Split a statement's text into options and the picture's name.
fn mapping(text: &str) -> Mapping<'_> {
    let mut out = Mapping {
        name: text,
        scale: Vec2::ONE,
        offset: Vec2::ZERO,
        clamp: false,
        ignored: Vec::new(),
    };
    loop {
        let (option, rest) = first_word(out.name);
        let Some((_, most)) = OPTIONS.iter().find(|(known, _)| *known == option) else {
            return out;
        };
        let (words, rest) = arguments(option, *most, rest);
        let number = |k: usize| words.get(k).and_then(|w| value::number(w).ok());
        match option {
            "-s" => out.scale = Vec2::new(number(0).unwrap_or(1.0), number(1).unwrap_or(1.0)),
            "-o" => out.offset = Vec2::new(number(0).unwrap_or(0.0), number(1).unwrap_or(0.0)),
            "-clamp" => out.clamp = words == ["on"],
            _ if WITHOUT_EFFECT.contains(&option) => {}
            _ => out.ignored.push(option),
        }
        out.name = rest;
    }
}

/// The arguments of an option, and the rest of the text.
fn arguments<'a>(option: &str, most: usize, mut rest: &'a str) -> (Vec<&'a str>, &'a str) {
    let takes_fewer = ["-o", "-s", "-t"].contains(&option);
    let mut words = Vec::new();
    while words.len() < most {
        let (word, after) = first_word(rest);
        let is_next = takes_fewer && !words.is_empty() && value::number(word).is_err();
        if word.is_empty() || is_next {
            break;
        }
        words.push(word);
        rest = after;
    }
    (words, rest)
}

/// Possible interpretations, the most likely first: names may contain blanks, look like options, or have comments after
/// them.
fn readings(text: &str) -> Vec<Mapping<'_>> {
    let options = mapping(text);
    let with_name = |name| Mapping { name, ..mapping(text) };
    let before_comment = name_before_comment(options.name).map(with_name);
    let last_word = text.split_whitespace().last().map(with_name);
    let whole = Mapping { name: text, ..mapping("") };
    [Some(whole), Some(options), before_comment, last_word].into_iter().flatten().collect()
}

fn first_word(text: &str) -> (&str, &str) {
    let text = text.trim_start();
    text.split_once(char::is_whitespace)
        .map_or((text, ""), |(word, rest)| (word, rest.trim_start()))
}

impl Mapping<'_> {
    /// From the surface's texture coordinates (v already flipped) to those of the picture.
    fn to_uv(&self) -> Affine2 {
        let turned = Vec2::new(self.offset.x, 1.0 - self.scale.y - self.offset.y);
        Affine2::from_mat2_translation(Mat2::from_diagonal(self.scale), turned)
    }
}

impl Reader<'_> {
    /// A picture times a colour, or only the colour.
    pub(super) fn picture(
        &mut self,
        map: Option<&Map>,
        factor: Option<Rgb>,
        default: Rgb,
    ) -> Texture {
        let constant = Texture::Constant(factor.unwrap_or(default));
        let Some(map) = map else { return constant };
        let found = readings(&map.text).into_iter().find_map(|m| Some((self.place_of(m.name)?, m)));
        let Some((path, mapping)) = found else {
            let message = format!("cannot find the picture `{}`", map.text);
            self.report.error(map.span, message, "");
            return constant;
        };
        for option in &mapping.ignored {
            self.report.warn(map.span, format!("the option `{option}` is ignored"));
        }
        let wrap = if mapping.clamp { Wrap::Clamp } else { Wrap::Repeat };
        let file = BitmapFile { path, raw: false, wrap, lookup: Lookup::Bilinear };
        // Exporters write a black factor beside a picture to mean "the picture alone".
        let scale = factor.filter(|f| !f.is_black()).unwrap_or(Rgb::WHITE);
        match self.read_picture(file, map) {
            Some(bitmap) => Texture::Bitmap { bitmap, to_uv: mapping.to_uv(), scale },
            None => constant,
        }
    }

    fn place_of(&mut self, name: &str) -> Option<PathBuf> {
        if let Some(known) = self.pictures.places.get(name) {
            return known.clone();
        }
        let place = if name.is_empty() { None } else { find(&self.folders, name, &self.folder) };
        self.pictures.places.insert(name.to_owned(), place.clone());
        place
    }

    fn read_picture(&mut self, file: BitmapFile, map: &Map) -> Option<Arc<Bitmap>> {
        if let Some(known) = self.pictures.read.get(&file) {
            return known.clone();
        }
        self.report.reads(&file.path);
        self.hash.word(files::hash_file(&file.path).unwrap_or(0));
        let read = file.read(&self.report.budget).map(Arc::new);
        if let Err(why) = &read {
            let message = format!("cannot read `{}`: {why}", file.path.display());
            self.report.error(map.span, message, "");
        }
        let bitmap = read.ok();
        if let Some(bitmap) = &bitmap {
            self.origins.note_bitmap(bitmap, &file);
        }
        self.pictures.read.insert(file, bitmap.clone());
        bitmap
    }
}

/// Find a file that a library or an OBJ file names.
pub(super) fn find(folders: &Folders, name: &str, folder: &Path) -> Option<PathBuf> {
    match folders.find(unquoted(name), folder, &[]) {
        Found::Exact(path) | Found::OtherCase(path) => Some(path),
        Found::No => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_stand_before_a_name_with_blanks() {
        let m = mapping("-blendu on -s 2 3 -o 0.5 -clamp on -mm 0 1 a picture.png");
        assert_eq!((m.name, m.scale, m.clamp), ("a picture.png", Vec2::new(2.0, 3.0), true));
        assert_eq!((m.offset, m.ignored), (Vec2::new(0.5, 0.0), vec!["-mm"]));
        assert_eq!(mapping("-b.png").name, "-b.png");
        assert_eq!(mapping("-s 1").name, "");
        // With scale 2 in v, the bottom edge of the picture stays at v = 0.
        let uv = mapping("-s 1 2 x").to_uv().transform_point2(Vec2::new(0.25, 1.0));
        assert_eq!(uv, Vec2::new(0.25, 1.0));
    }
}
