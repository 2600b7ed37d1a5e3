//! Records where the parts of a scene came from, so that an export can refer to the same files.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use gi_core::math::Rgb;
use gi_core::texture::{Bitmap, Texture};
use glam::Affine3A;

use crate::diagnostics::Report;
use crate::shapes::mesh_file::MeshFile;
use crate::sky::model::SunSky;
use crate::texels::{self, BitmapFile, holds_floats};

/// Where the parts of a scene came from: an export writes these references instead of the data.
#[derive(Clone, Debug, Default)]
pub(crate) struct Origins {
    /// Names of the materials.
    pub(crate) materials: Vec<Option<String>>,
    /// Names of the media.
    pub(crate) media: Vec<Option<String>>,
    /// For each shape, how its geometry was given.
    pub(crate) shapes: Vec<ShapeOrigin>,
    /// For each group, the same for its shapes.
    pub(crate) groups: Vec<Vec<ShapeOrigin>>,
    /// For each light, how it was given.
    pub(crate) lights: Vec<LightOrigin>,
    /// Picture files, indexed by the picture's address. The picture is stored too, so that the address stays valid.
    bitmaps: HashMap<usize, (Arc<Bitmap>, BitmapFile)>,
    /// Ranges of the used texels, for pictures with unused ones; indexed like `bitmaps`.
    ranges: HashMap<usize, (Arc<Bitmap>, [f32; 2])>,
    /// Pictures of light without their negative texels, indexed by the address of the original, which is stored too.
    lifted: HashMap<usize, (Arc<Bitmap>, Lifted)>,
    /// Grey copies of pictures, indexed by the address of the original, which is stored too.
    greys: HashMap<usize, (Arc<Bitmap>, Arc<Bitmap>)>,
}

/// A picture of light without negative texels, and the first of those that it had.
pub(crate) type Lifted = (Arc<Bitmap>, Option<(usize, usize)>);

/// How a shape's geometry was given.
#[derive(Clone, Debug)]
pub(crate) enum ShapeOrigin {
    /// By a file that Mitsuba 3 reads like we do.
    File(MeshFile, Affine3A),
    /// As `rectangle` or `cube`.
    Unit(&'static str, Affine3A),
    /// In some other way: export the geometry itself.
    Itself,
}

/// How a light was given.
#[derive(Clone, Debug)]
pub(crate) enum LightOrigin {
    /// As an `envmap`.
    Picture(PathBuf),
    /// As `sun`, `sky` or `sunsky`; the next light may belong to the same plugin.
    SunSky(SunSky),
    /// Belongs to the same plugin as the light before it.
    SameAsBefore,
    /// In some other way: export the light itself.
    Itself,
}

impl Origins {
    /// Record which file a picture came from.
    pub(crate) fn note_bitmap(&mut self, bitmap: &Arc<Bitmap>, file: &BitmapFile) {
        let known = self.bitmaps.entry(Arc::as_ptr(bitmap).addr());
        known.or_insert_with(|| (bitmap.clone(), file.clone()));
    }

    /// Record the smallest and the largest value of a picture, if its texels reach further.
    pub(crate) fn note_range(&mut self, bitmap: &Arc<Bitmap>, range: [f32; 2]) {
        self.ranges.insert(Arc::as_ptr(bitmap).addr(), (bitmap.clone(), range));
    }

    /// A picture of light: negative texels become zero. The copy is made once, however many lights use the picture.
    pub(crate) fn as_light(
        &mut self,
        bitmap: &Arc<Bitmap>,
        file: &BitmapFile,
        report: &Report,
    ) -> Lifted {
        let key = Arc::as_ptr(bitmap).addr();
        if let Some((_, known)) = self.lifted.get(&key) {
            return known.clone();
        }
        let lifted = texels::as_light(bitmap, file, &report.budget).unwrap_or_else(|why| {
            report.error_nowhere(format!("cannot copy `{}`: {why}", file.path.display()));
            (bitmap.clone(), None)
        });
        if lifted.1.is_some() {
            self.note_bitmap(&lifted.0, file);
        }
        self.lifted.insert(key, (bitmap.clone(), lifted.clone()));
        lifted
    }

    /// A picture whose texels are the means of their colours. The copy is made once, however many lights use the picture.
    pub(crate) fn as_grey(&mut self, bitmap: &Arc<Bitmap>, report: &Report) -> Arc<Bitmap> {
        let key = Arc::as_ptr(bitmap).addr();
        if let Some((_, known)) = self.greys.get(&key) {
            return known.clone();
        }
        let bytes = bitmap.width() * bitmap.height() * size_of::<Rgb>();
        let claim = report.budget.claim("grey pictures of lights");
        if let Err(why) = claim.keep(bytes as u64) {
            report.error_nowhere(format!("cannot copy the picture of a light: {why}"));
            return bitmap.clone();
        }
        let grey = Arc::new(bitmap.map(|texel| Rgb::grey(texel.mean())));
        self.greys.insert(key, (bitmap.clone(), grey.clone()));
        grey
    }

    /// The file that a picture came from.
    pub(crate) fn bitmap_file(&self, bitmap: &Arc<Bitmap>) -> Option<&BitmapFile> {
        self.bitmaps.get(&Arc::as_ptr(bitmap).addr()).map(|(_, file)| file)
    }

    /// The smallest and largest value of a texture.
    pub(crate) fn range(&self, texture: &Texture) -> [f32; 2] {
        let join = |a: [f32; 2], b: [f32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        let of =
            |c: Rgb| c.to_array().map(|v| [v, v]).into_iter().reduce(join).expect("three numbers");
        match texture {
            Texture::Constant(c) => of(*c),
            Texture::Checkerboard { color0, color1, .. } => {
                join(self.range(color0), self.range(color1))
            }
            Texture::Grid { squares, lines, .. } => join(self.range(squares), self.range(lines)),
            Texture::Bitmap { bitmap, scale, .. } => {
                let floats = self.bitmap_file(bitmap).is_none_or(|f| holds_floats(&f.path));
                if !floats {
                    return join([0.0, 0.0], of(*scale));
                }
                let known = self.ranges.get(&Arc::as_ptr(bitmap).addr());
                let [least, most] = match known {
                    Some((_, range)) => range.map(Rgb::grey),
                    None => bitmap.range(),
                };
                join(of(least * *scale), of(most * *scale))
            }
        }
    }
}
