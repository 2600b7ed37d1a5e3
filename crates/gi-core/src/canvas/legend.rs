//! Legends of technique pictures: what the colours mean, with numbers and a unit.

use glam::Vec2;

use super::{Canvas, text_width, viridis};
use crate::math::Rgb;

/// The legend of a picture. It is drawn below the picture; the layers of the EXR do not contain it.
#[derive(Clone, Debug, PartialEq)]
pub struct Legend {
    /// What is shown, with its unit.
    pub title: String,
    /// What the colours mean.
    pub colours: Colours,
}

/// What the colours of a picture mean.
#[derive(Clone, Debug, PartialEq)]
pub enum Colours {
    /// [`viridis`] from the first to the second number.
    Linear(f32, f32),
    /// [`viridis`] from the first to the second number, which are positive, on a logarithmic scale.
    Logarithmic(f32, f32),
    /// Single colours with their names.
    Named(Vec<(Rgb, String)>),
}

/// Width of a space, of a colour with its gap, and of the gap behind a name, in heights of a letter.
const SPACE: f32 = 1.2;
const SWATCH: f32 = 1.7;
const GAP: f32 = 1.5;

/// Colours of the strip: paper and ink.
const PAPER: Rgb = Rgb::WHITE;
const INK: Rgb = Rgb::new(0.01, 0.01, 0.01);

impl Legend {
    /// A legend for numbers from `low` to `high`, on a logarithmic scale.
    pub fn logarithmic(title: &str, low: f32, high: f32) -> Self {
        Legend { title: title.into(), colours: Colours::Logarithmic(low, high) }
    }

    /// A legend for numbers from `low` to `high`.
    pub fn linear(title: &str, low: f32, high: f32) -> Self {
        Legend { title: title.into(), colours: Colours::Linear(low, high) }
    }

    /// A legend for single colours.
    pub fn named<'n>(title: &str, colours: impl IntoIterator<Item = (Rgb, &'n str)>) -> Self {
        let colours = colours.into_iter().map(|(c, name)| (c, name.to_string())).collect();
        Legend { title: title.into(), colours: Colours::Named(colours) }
    }

    /// The picture with the legend below it, and its new size.
    pub fn below(&self, [w, h]: [usize; 2], view: &[Rgb]) -> ([usize; 2], Vec<Rgb>) {
        let letter = (w as f32 / 42.0).clamp(5.0, 20.0);
        let lines = self.lines(w as f32, letter);
        let strip = (letter * (1.0 + 2.0 * lines.len() as f32 + self.bar_lines())).ceil() as usize;
        let mut pixels = view.to_vec();
        pixels.resize(w * (h + strip), PAPER);
        let mut canvas = Canvas::over([w, h + strip], pixels);
        let mut y = h as f32 + 1.9 * letter;
        for line in lines {
            let mut x = letter;
            for (colour, name) in line {
                if let Some(colour) = colour {
                    let middle = Vec2::new(x + 0.5 * letter, y - 0.5 * letter);
                    canvas.disc(middle, 0.62 * letter, INK);
                    canvas.disc(middle, 0.5 * letter, colour);
                    x += SWATCH * letter;
                }
                canvas.text(Vec2::new(x, y), letter, INK, &name);
                x += text_width(&name, letter) + GAP * letter;
            }
            y += 2.0 * letter;
        }
        self.bar(&mut canvas, y - 1.2 * letter, letter);
        ([w, h + strip], canvas.into_pixels())
    }

    /// The words of the title and the names of colours, broken into lines that fit `width`. A name is broken only if no line is
    /// long enough for it.
    fn lines(&self, width: f32, letter: f32) -> Vec<Vec<(Option<Rgb>, String)>> {
        let mut lines: Vec<Vec<(Option<Rgb>, String)>> = vec![Vec::new()];
        let mut used = letter;
        let mut add = |word: (Option<Rgb>, String), needs: f32, joins: bool| {
            let full = used + needs > width;
            let last = lines.len() - 1;
            match lines[last].last_mut() {
                Some(_) if full => lines.push(vec![word]),
                // Words that fit are one text.
                Some((_, text)) if joins => *text = format!("{text} {}", word.1),
                _ => lines[last].push(word),
            }
            used = needs + if full { letter } else { used };
        };
        for word in self.title.split(' ').filter(|w| !w.is_empty()) {
            add((None, word.into()), text_width(word, letter) + SPACE * letter, true);
        }
        if let Colours::Named(colours) = &self.colours {
            for (colour, name) in colours {
                let long = letter * (1.0 + SWATCH) + text_width(name, letter) > width;
                let words: Vec<&str> = if long { name.split(' ').collect() } else { vec![name] };
                for (k, word) in words.iter().enumerate() {
                    let first = if k == 0 { SWATCH } else { 0.0 };
                    let after = if k + 1 == words.len() { GAP } else { SPACE };
                    let needs = text_width(word, letter) + letter * (first + after);
                    add(((k == 0).then_some(*colour), (*word).into()), needs, k > 0);
                }
            }
        }
        lines
    }

    /// Height of the bar with its numbers, in letters.
    fn bar_lines(&self) -> f32 {
        if matches!(self.colours, Colours::Named(_)) { 0.2 } else { 3.6 }
    }

    /// The bar of colours, with its top at `top`, and the numbers below it.
    fn bar(&self, canvas: &mut Canvas, top: f32, letter: f32) {
        let (low, high, log) = match self.colours {
            Colours::Linear(low, high) => (low, high, false),
            Colours::Logarithmic(low, high) => (low, high, true),
            Colours::Named(_) => return,
        };
        let [w, _] = canvas.size();
        let (left, right) = (1.5 * letter, w as f32 - 1.5 * letter);
        let bottom = top + 1.2 * letter;
        for x in left as usize..right as usize {
            let t = (x as f32 + 0.5 - left) / (right - left);
            let x = x as f32 + 0.5;
            canvas.line(Vec2::new(x, top), Vec2::new(x, bottom), 1.0, viridis(t));
        }
        let mut free = 0.0;
        for v in ticks(low, high, log) {
            let t = if log { (v / low).ln() / (high / low).ln() } else { (v - low) / (high - low) };
            let x = left + t * (right - left);
            let name = number(v);
            let half = 0.5 * text_width(&name, letter);
            if !t.is_finite() || 2.0 * (half + 1.0) > w as f32 {
                continue;
            }
            let middle = x.clamp(half + 1.0, w as f32 - half - 1.0);
            if middle - half < free {
                continue;
            }
            canvas.line(Vec2::new(x, bottom), Vec2::new(x, bottom + 0.5 * letter), 1.0, INK);
            canvas.text_centred(Vec2::new(middle, bottom + 1.9 * letter), letter, INK, &name);
            free = middle + half + 1.2 * letter;
        }
    }
}

/// Round numbers from `low` to `high` for an axis; if there is none, both ends.
pub fn ticks(low: f32, high: f32, log: bool) -> Vec<f32> {
    let is_range = low.is_finite() && high.is_finite() && high > low;
    if !is_range || log && low <= 0.0 {
        return vec![low];
    }
    let within = |v: &f32| *v >= low * (1.0 - 1e-5) - 1e-12 && *v <= high * (1.0 + 1e-5);
    let found: Vec<f32> = if log {
        let decades = (high / low).log10();
        let digits: &[f32] = match decades {
            d if d > 3.0 => &[1.0],
            d if d > 1.2 => &[1.0, 3.0],
            _ => &[1.0, 2.0, 3.0, 5.0, 7.0],
        };
        let exponents = low.log10().floor() as i32..=high.log10().ceil() as i32;
        exponents
            .flat_map(|e| digits.iter().map(move |d| d * 10f32.powi(e)))
            .filter(within)
            .collect()
    } else {
        let rough = (high - low) / 5.0;
        let power = 10f32.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough);
        let step = step.unwrap_or(rough);
        let first = (low / step).ceil();
        (0..12).map(|k| (first + k as f32) * step).filter(within).collect()
    };
    if found.len() < 2 { vec![low, high] } else { found }
}

/// A number with at most three digits.
pub fn number(v: f32) -> String {
    let size = v.abs();
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{v:.0e}");
    }
    let digits = (2 - size.max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{v:.digits$}");
    if !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_is_longer_than_the_picture_is_broken_between_words() {
        let legend = Legend::named("Title:", [(INK, "short"), (INK, "a name of several words")]);
        let width = 14.0 * text_width("n", 10.0);
        let lines = legend.lines(width, 10.0);
        let text = |line: &Vec<(Option<Rgb>, String)>| {
            line.iter().map(|(_, text)| text.as_str()).collect::<Vec<_>>().join(" ")
        };
        let texts: Vec<String> = lines.iter().map(text).collect();
        assert_eq!(texts.join(" "), "Title: short a name of several words");
        assert!(lines.iter().flatten().all(|(_, t)| text_width(t, 10.0) < width), "{texts:?}");
        let colours = lines.iter().flatten().filter(|(colour, _)| colour.is_some());
        assert_eq!(colours.count(), 2);
    }

    #[test]
    fn numbers_are_short_and_ticks_are_round() {
        let all = [0.0, 0.25, 12.0, 1234.0, 2e6, 3e-5].map(number);
        assert_eq!(all, ["0", "0.25", "12", "1234", "2e6", "3e-5"]);
        assert_eq!(ticks(0.0, 1.0, false).len(), 6);
        assert_eq!(ticks(1.0, 100.0, true), [1.0, 3.0, 10.0, 30.0, 100.0]);
        assert_eq!(ticks(4.1, 4.4, true), [4.1, 4.4]);
        assert_eq!(ticks(2.0, 2.0, false), [2.0]);
    }

    #[test]
    fn long_titles_are_broken_into_lines_that_fit() {
        let title = "The first 200 photon paths. A segment has the colour of its end:";
        let legend = Legend::named(title, [(Rgb::WHITE, "direct"), (Rgb::BLACK, "scattered")]);
        let lines = legend.lines(300.0, 10.0);
        assert!(lines.len() >= 3, "{lines:?}");
        for line in &lines {
            let of = |(c, t): &(Option<Rgb>, String)| {
                text_width(t, 10.0) + if c.is_some() { 10.0 * SWATCH } else { 0.0 }
            };
            assert!(10.0 + line.iter().map(of).sum::<f32>() <= 300.0, "{line:?}");
        }
        let words: Vec<&str> = lines.iter().flatten().map(|(_, t)| t.as_str()).collect();
        assert_eq!(words.join(" "), format!("{title} direct scattered"));
    }

    #[test]
    fn a_legend_keeps_the_picture_and_adds_a_strip_with_ink_and_colours() {
        let view = vec![Rgb::grey(0.25); 128 * 10];
        let bar = Legend::logarithmic("Radius (scene units)", 0.1, 30.0);
        let names = Legend::named("Photons", [(Rgb::new(1.0, 0.0, 0.0), "caustic")]);
        for legend in [bar, names] {
            let ([w, h], pixels) = legend.below([128, 10], &view);
            assert_eq!((w, pixels.len()), (128, w * h));
            assert_eq!(pixels[..1280], view[..]);
            let strip = &pixels[1280..];
            assert!(strip.iter().any(|p| p.g < 0.1), "no ink");
            assert!(strip.iter().any(|p| (p.r - p.g).abs() > 0.3), "no colours");
        }
    }

    #[test]
    fn pictures_of_any_size_and_numbers_of_any_kind_have_a_legend() {
        for w in [1, 2, 3, 7, 16, 25, 26, 40] {
            for (low, high) in [(0.0, 0.0), (0.0, 5.0), (1e-30, 1e30), (f32::NAN, 1.0), (3.0, 1.0)]
            {
                let titles = ["", "Radius (units of the scene)"];
                for legend in titles
                    .map(|t| [Legend::linear(t, low, high), Legend::logarithmic(t, low, high)])
                    .concat()
                {
                    let (size, pixels) = legend.below([w, 2], &vec![Rgb::BLACK; 2 * w]);
                    assert_eq!((size[0], pixels.len()), (w, size[0] * size[1]));
                }
            }
        }
    }
}
