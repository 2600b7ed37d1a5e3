//! Text on a canvas, in a small font of straight strokes that is readable at any size.

use glam::Vec2;

use super::Canvas;
use crate::math::Rgb;

/// Height of capital letters in the grid of [`STROKES`], and the height of the baseline.
const CAPITALS: f32 = 6.0;
const BASELINE: f32 = 2.0;
/// Gap between letters, and width of a space, in units of the grid.
const GAP: f32 = 2.0;
const SPACE: f32 = 3.0;
/// Thickness of the strokes, in units of the grid.
const STROKE: f32 = 1.05;

/// Each letter with its strokes, separated by spaces. Two digits are a point: x from the left, y from below. Capital letters reach
/// from 2 to 8.
const STROKES: [(char, &str); 83] = [
    ('0', "120307183847433212"),
    ('1', "172822 1232"),
    ('2', "07183847460242"),
    ('3', "0718384746354443321203 2535"),
    ('4', "32380444"),
    ('5', "480805354443321203"),
    ('6', "38180703123243443505"),
    ('7', "084812"),
    ('8', "15060718384746351504031232434435"),
    ('9', "12324347381807061545"),
    ('A', "022842 1434"),
    ('B', "02083847463505 3544433202"),
    ('C', "4738180703123243"),
    ('D', "02082846442202"),
    ('E', "48080242 0535"),
    ('F', "480802 0535"),
    ('G', "47381807031232434525"),
    ('H', "0208 4248 0545"),
    ('I', "0222 1218 0828"),
    ('J', "3833221203"),
    ('K', "0208 4804 1542"),
    ('L', "080242"),
    ('M', "0208254842"),
    ('N', "02084248"),
    ('O', "120307183847433212"),
    ('P', "02083847463505"),
    ('Q', "120307183847433212 2442"),
    ('R', "02083847463505 2542"),
    ('S', "473818070615354443321203"),
    ('T', "0848 2822"),
    ('U', "080312324348"),
    ('V', "082248"),
    ('W', "0812253248"),
    ('X', "0248 0842"),
    ('Y', "082548 2522"),
    ('Z', "08480242"),
    ('a', "4642 4536160503123243"),
    ('b', "0802 0516364543321203"),
    ('c', "4536160503123243"),
    ('d', "4842 4536160503123243"),
    ('e', "04444536160503123243"),
    ('f', "38281712 0626"),
    ('g', "46413010 4536160503123243"),
    ('h', "0802 0516364542"),
    ('i', "0206 0808"),
    ('j', "161100 1818"),
    ('k', "0802 3604 1532"),
    ('l', "080312"),
    ('m', "0206 0516263532 3546566562"),
    ('n', "0206 0516364542"),
    ('o', "160503123243453616"),
    ('p', "0600 0516364543321203"),
    ('q', "4640 4536160503123243"),
    ('r', "0206 051626"),
    ('s', "3616051424332202"),
    ('t', "18132232 0626"),
    ('u', "0603123243 4642"),
    ('v', "062246"),
    ('w', "0612243246"),
    ('x', "0246 0642"),
    ('y', "0622 4610"),
    ('z', "06460242"),
    ('.', "0202"),
    (',', "1201"),
    (':', "0202 0505"),
    (';', "1201 1515"),
    ('-', "0434"),
    ('+', "0545 2723"),
    ('*', "2723 0446 0644"),
    ('/', "0138"),
    ('=', "0444 0646"),
    ('<', "370533"),
    ('>', "073503"),
    ('(', "18070312"),
    (')', "08171302"),
    ('[', "18080212"),
    (']', "08181202"),
    ('^', "061826"),
    ('|', "0208"),
    ('_', "0141"),
    ('\'', "0907"),
    ('?', "07183847462524 2222"),
    ('%', "0248 0818170708 3343423233"),
];

/// The strokes of a letter, or of a question mark if the font lacks the letter.
fn strokes(letter: char) -> &'static str {
    let of = |c| STROKES.iter().find(|(l, _)| *l == c).map(|(_, s)| *s);
    of(letter).or_else(|| of('?')).unwrap_or_default()
}

/// The points of a stroke.
fn points(stroke: &str) -> impl Iterator<Item = Vec2> {
    let (pairs, _) = stroke.as_bytes().as_chunks::<2>();
    pairs.iter().map(|&[x, y]| Vec2::new(f32::from(x - b'0'), f32::from(y - b'0')))
}

/// Width of a letter in the grid, without the gap behind it.
fn width(letter: char) -> f32 {
    match letter {
        ' ' => SPACE,
        _ => strokes(letter).split(' ').flat_map(points).map(|p| p.x).fold(0.0, f32::max),
    }
}

/// Width of a text in pixels, if capital letters are `height` pixels high.
pub fn text_width(text: &str, height: f32) -> f32 {
    let units: f32 = text.chars().map(|c| width(c) + GAP).sum();
    (units - GAP).max(0.0) * height / CAPITALS
}

impl Canvas {
    /// Write `text` from its left end on the baseline, `at`. Capital letters are `height` pixels high.
    pub fn text(&mut self, at: Vec2, height: f32, colour: Rgb, text: &str) {
        let unit = height / CAPITALS;
        let mut left = at.x;
        for letter in text.chars() {
            let place = |p: Vec2| Vec2::new(left + p.x * unit, at.y - (p.y - BASELINE) * unit);
            for stroke in strokes(letter).split(' ').filter(|_| letter != ' ') {
                let mut previous = None;
                for p in points(stroke).map(place) {
                    self.line(previous.unwrap_or(p), p, STROKE * unit, colour);
                    previous = Some(p);
                }
            }
            left += (width(letter) + GAP) * unit;
        }
    }

    /// Write `text` with its middle at `at.x`, and its baseline at `at.y`.
    pub fn text_centred(&mut self, at: Vec2, height: f32, colour: Rgb, text: &str) {
        let left = Vec2::new(at.x - 0.5 * text_width(text, height), at.y);
        self.text(left, height, colour, text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_differ_and_stay_in_their_box() {
        let drawn = |letter: char| {
            let mut canvas = Canvas::over([20, 24], vec![Rgb::BLACK; 480]);
            canvas.text(Vec2::new(3.0, 17.0), 12.0, Rgb::WHITE, &letter.to_string());
            canvas.into_pixels()
        };
        for (k, (letter, _)) in STROKES.iter().enumerate() {
            let pixels = drawn(*letter);
            assert!(pixels.iter().any(|p| p.g > 0.5), "{letter} is empty");
            let rim = (0..20).any(|x| pixels[x].g > 0.0 || pixels[460 + x].g > 0.0);
            assert!(!rim, "{letter} leaves its line");
            // Only O and zero look the same.
            for (other, _) in STROKES[..k].iter().filter(|(o, _)| !(*o == '0' && *letter == 'O')) {
                assert_ne!(drawn(*other), pixels, "{letter} looks like {other}");
            }
        }
    }

    #[test]
    fn the_width_of_a_text_is_where_its_last_letter_ends() {
        // Four units, a gap of two, four units; six units are ten pixels.
        assert!((text_width("HH", 6.0) - 10.0).abs() < 1e-5);
        assert_eq!(text_width("", 6.0), 0.0);
    }
}
