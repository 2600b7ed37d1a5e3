//! What all figures share: their subject, a background and colours.

use gi_core::canvas::Canvas;
use gi_core::film::Film;
use gi_core::math::Rgb;

use crate::cut::{Cut, Limits, Lit};
use crate::light::{At, Lights};
use crate::record::Record;
use crate::view::View;

/// Chooses the cut of a point.
type Choose<'a> = fn(&Lights<'_, 'a>, &At<'_, '_, 'a>, &Limits, &mut Cut, &mut Option<&mut Record>);

/// Chooses the cut of a pixel, and returns its light and size.
pub(crate) type CutOfPixel<'f> = &'f (dyn Fn([usize; 2]) -> Lit + Sync);

/// What figures show: lights and trees, seen by a camera.
pub(crate) struct Subject<'f, 'a> {
    pub(crate) view: View<'f, 'a>,
    pub(crate) lights: &'f Lights<'f, 'a>,
    pub(crate) choose: Choose<'a>,
    /// For `--method multidimensional`, whose cuts belong to pixels.
    pub(crate) cut_of_pixel: Option<CutOfPixel<'f>>,
}

impl<'a> Subject<'_, 'a> {
    /// The cut of a point.
    pub(super) fn cut(&self, at: &At<'_, '_, 'a>) -> Cut {
        let mut cut = Cut::default();
        (self.choose)(self.lights, at, &self.view.params.cut, &mut cut, &mut None);
        cut
    }
}

/// The picture, darkened so that drawings stand out.
pub(super) fn background(film: &Film) -> Canvas {
    let pixels = film.radiance().into_iter().map(|c| c.map(|v| v.clamp(0.0, 1.0)) * 0.35);
    Canvas::over(film.size(), pixels.collect())
}

/// The colour of item `k` in a list; neighbours in the list have different colours.
pub(super) fn colour(k: usize) -> Rgb {
    let hue = (k as f32 * 0.618_034).fract() * 6.0;
    let part = |shift: f32| ((hue + shift) % 6.0 - 3.0).abs().clamp(1.0, 2.0) - 1.0;
    Rgb::new(part(0.0), part(4.0), part(2.0)) * 0.8 + Rgb::grey(0.1)
}
