//! Reads the pictures to compare, from this project's programs or from others.

use std::path::{Path, PathBuf};

use gi_core::image_io::{Encoding, Layers, read_bitmap, read_exr};
use gi_core::texture::{Lookup, Wrap};

use crate::{Failure, show};

/// A picture of linear radiance.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Its file.
    pub path: PathBuf,
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Interleaved RGB, row by row from the top.
    pub rgb: Vec<f32>,
    /// Variance of `rgb`, computed as for independent samples, if the file contains it.
    pub variance: Option<Vec<f32>>,
    /// The file's metadata.
    pub metadata: Vec<(String, String)>,
    /// A choice that reading it required, to be reported.
    pub note: Option<String>,
}

/// Whether a file name is that of a picture, by its extension.
pub fn is_picture(name: &str) -> bool {
    let extension = Path::new(parts(name).0).extension().and_then(|e| e.to_str());
    extension.is_some_and(|e| ["exr", "pfm", "hdr"].contains(&e.to_ascii_lowercase().as_str()))
}

/// File and layer of `FILE#LAYER`; if a file exists whose own name contains `#`, the whole name is the file.
fn parts(name: &str) -> (&str, Option<&str>) {
    match name.rsplit_once('#') {
        Some((file, layer)) if !Path::new(name).exists() => (file, Some(layer)),
        _ => (name, None),
    }
}

/// The file of `FILE` or `FILE#LAYER`.
pub(crate) fn file(name: &str) -> PathBuf {
    parts(name).0.into()
}

impl Picture {
    /// Read `FILE` or `FILE#LAYER`. `layer` is used if the name selects none; without either, the radiance is read.
    ///
    /// # Errors
    /// The file cannot be read, or has no such layer.
    pub fn read(name: &str, layer: Option<&str>) -> Result<Self, Failure> {
        let (file, own) = parts(name);
        let path = Path::new(file);
        let refuse = |cause: String| Failure::Input(format!("error: cannot use {file}: {cause}"));
        if !is_picture(file) {
            return Err(refuse("expected a picture of linear radiance: .exr, .pfm or .hdr".into()));
        }
        let layer = own.or(layer);
        if !file.to_ascii_lowercase().ends_with(".exr") {
            return match layer {
                Some(layer) => Err(refuse(format!("it has no layers, so it has no layer {layer}"))),
                None => Self::without_layers(path).map_err(refuse),
            };
        }
        let layers = read_exr(path).map_err(refuse)?;
        let (names, note) = choose(&layers, layer).map_err(refuse)?;
        let interleaved =
            |names: &[String; 3]| layers.interleaved(names.each_ref().map(String::as_str));
        let rgb = interleaved(&names).unwrap_or_default();
        if rgb.is_empty() {
            return Err(refuse("the picture has no pixels".into()));
        }
        let plain = names[0] == "R";
        let variance =
            plain.then(|| interleaved(&["R", "G", "B"].map(|c| format!("Variance.{c}"))));
        Ok(Picture {
            path: path.to_path_buf(),
            size: [layers.width, layers.height],
            rgb,
            variance: variance.flatten(),
            metadata: layers.metadata,
            note,
        })
    }

    fn without_layers(path: &Path) -> Result<Self, String> {
        let bitmap = read_bitmap(path, Encoding::Raw, Wrap::Clamp, Lookup::Nearest)?;
        let size = [bitmap.width(), bitmap.height()];
        let texel = |i: usize| bitmap.texel(i % size[0], i / size[0]).to_array();
        Ok(Picture {
            path: path.to_path_buf(),
            size,
            rgb: (0..size[0] * size[1]).flat_map(texel).collect(),
            variance: None,
            metadata: Vec::new(),
            note: None,
        })
    }

    /// The metadata with this key.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.metadata.iter().find(|(n, _)| n == name).map(|(_, text)| text.as_str())
    }

    /// Check that it has the same size as the reference.
    ///
    /// # Errors
    /// The sizes differ.
    pub fn check_size(&self, reference: &Picture) -> Result<(), Failure> {
        if self.size == reference.size {
            return Ok(());
        }
        let ([w, h], [rw, rh]) = (self.size, reference.size);
        Err(Failure::Input(format!(
            "error: {} has {w} x {h} pixels and the reference {} has {rw} x {rh}: only pictures of the same size can be \
             compared; render one of them anew with --size",
            show(&self.path),
            show(&reference.path)
        )))
    }
}

/// The names of a layer's red, green and blue channels, and a remark if they had to be guessed.
fn choose(layers: &Layers, layer: Option<&str>) -> Result<([String; 3], Option<String>), String> {
    let has = |names: &[String; 3]| names.iter().all(|n| layers.channel(n).is_some());
    let of = |layer: &str| ["R", "G", "B"].map(|c| format!("{layer}.{c}"));
    let mut named: Vec<&str> = layers
        .channels
        .iter()
        .filter_map(|(n, _)| n.strip_suffix(".R"))
        .filter(|l| has(&of(l)))
        .collect();
    named.sort_unstable();
    let channels = || {
        let names: Vec<&str> = layers.channels.iter().map(|(n, _)| n.as_str()).collect();
        format!("its channels are {}", names.join(", "))
    };
    let plain = ["R", "G", "B"].map(String::from);
    match (layer, &named[..]) {
        (Some(layer), _) if named.contains(&layer) => Ok((of(layer), None)),
        (Some(layer), []) => Err(format!("it has no layer {layer}; {}", channels())),
        (Some(layer), some) => {
            Err(format!("it has no layer {layer}; its layers are {}", some.join(", ")))
        }
        (None, _) if has(&plain) => Ok((plain, None)),
        (None, _) if layers.channel("Y").is_some() => Ok((
            ["Y"; 3].map(String::from),
            Some("grey: its only channel Y is used for red, green and blue".into()),
        )),
        (None, [one]) => {
            Ok((of(one), Some(format!("it has no channels R, G, B; its only layer {one} is used"))))
        }
        (None, []) => Err(format!("it has no channels R, G, B; {}", channels())),
        (None, some) => Err(format!(
            "it has no channels R, G, B; choose a layer with FILE#LAYER or --layer: {}",
            some.join(", ")
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_channels(names: &[&str]) -> Layers {
        let channels = names.iter().map(|n| (n.to_string(), vec![0.0])).collect();
        Layers { width: 1, height: 1, channels, ..Layers::default() }
    }

    #[test]
    fn the_layer_is_the_one_asked_for_or_the_only_one_or_there_is_an_error_that_lists_them() {
        let ours = with_channels(&["R", "G", "B", "Direct.R", "Direct.G", "Direct.B", "Z"]);
        assert_eq!(choose(&ours, None).expect("radiance").0[2], "B");
        assert_eq!(choose(&ours, Some("Direct")).expect("it is there").0[0], "Direct.R");
        assert!(choose(&ours, Some("Caustic")).unwrap_err().contains("its layers are Direct"));
        let other = with_channels(&["View.Combined.R", "View.Combined.G", "View.Combined.B"]);
        let (names, note) = choose(&other, None).expect("the only one");
        assert_eq!(names[1], "View.Combined.G");
        assert!(note.expect("said").contains("View.Combined"));
        let two = with_channels(&["a.R", "a.G", "a.B", "b.R", "b.G", "b.B"]);
        assert!(choose(&two, None).unwrap_err().contains("a, b"));
        assert!(choose(&with_channels(&["Y"]), None).expect("grey").1.is_some());
        assert!(choose(&with_channels(&["Z"]), None).unwrap_err().contains("channels are Z"));
    }
}
