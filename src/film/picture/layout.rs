//! Layout of the parts of a picture.

use super::canvas::{GLYPH, PictureCanvas};
use super::content::{Content, PictureSpec};
use super::range::{BarRange, Scale};
use super::ticks::{Tick, ticks};

/// Maps smaller than this are enlarged.
const SMALLEST_MAP: usize = 256;
/// The shortest bar in font pixels.
const SHORTEST_BAR: usize = 96;
/// The least width of the title, and so of the bar's distance, in font pixels.
const NARROWEST_HEADER: usize = 16 * GLYPH;
const BACKGROUND: [u8; 3] = [255; 3];
const INK: [u8; 3] = [38, 38, 43];
const LINE: [u8; 3] = [110, 110, 118];

/// The positions of all parts in pixels; the origin is the upper left corner.
pub(super) struct PictureLayout {
    /// Number of pixels in a pixel of the font.
    font: usize,
    /// Number of pixels in a texel.
    zoom: usize,
    title: Vec<String>,
    ticks: Vec<Tick>,
    /// True if values go on below and above the bar.
    beyond: [bool; 2],
    map: [usize; 2],
    map_size: [usize; 2],
    bar: [usize; 2],
    bar_size: [usize; 2],
    canvas: [usize; 2],
}

impl PictureLayout {
    pub(super) fn new(spec: &PictureSpec, range: &BarRange, numbers: &[f64]) -> Self {
        let (width, height) = spec.content.size();
        let zoom = SMALLEST_MAP.div_ceil(width.max(height));
        let map_size = [width * zoom, height * zoom];
        // The shorter side decides, so that text does not dwarf a strip.
        let font = match map_size[0].min(map_size[1]) {
            0..480 => 1,
            480..1440 => 2,
            1440..2880 => 3,
            _ => 4,
        };
        let header_width = map_size[0].max(NARROWEST_HEADER * font);
        let margin = 12 * font;
        let line = (GLYPH + 3) * font;
        let beyond = [
            numbers
                .iter()
                .any(|&value| value < range.low && !is_black(&spec.content, value)),
            numbers.iter().any(|&value| value > range.high),
        ];
        let has_nan = numbers.iter().any(|value| value.is_nan());
        let title = if has_nan {
            format!("{} (magenta: not a number)", spec.title)
        } else {
            spec.title.to_owned()
        };
        let title = wrapped(title.trim(), header_width / (GLYPH * font));
        // The unit is on the title's last line.
        let header = title.len().max(1) * line + 3 * font;
        let triangle = 10 * font;
        let overhang = beyond.map(|beyond| if beyond { triangle } else { 0 });
        let map = [margin, margin + header];
        let full_bar = map_size[1].max(SHORTEST_BAR * font);
        let bar_size = [12 * font, full_bar - overhang[0] - overhang[1]];
        let bar = [map[0] + header_width + 12 * font, map[1] + overhang[1]];
        // Labels need their height and as much space again.
        let ticks = ticks(
            range,
            spec.content.scale(),
            (bar_size[1] / (3 * GLYPH * font)).min(10),
        );
        let label_width =
            |tick: &Tick| tick.label.as_ref().map_or(0, |label| label.chars().count());
        let labels = ticks.iter().map(label_width).max().unwrap_or(0) * GLYPH * font;
        let beside_bar = bar_size[0] + 8 * font + labels;
        let right = bar[0] + beside_bar.max(spec.unit.chars().count() * GLYPH * font);
        Self {
            font,
            zoom,
            title,
            ticks,
            beyond,
            map,
            map_size,
            bar,
            bar_size,
            canvas: [right + margin, map[1] + full_bar + margin],
        }
    }

    pub(super) fn draw(&self, spec: &PictureSpec, range: &BarRange) -> PictureCanvas {
        let mut canvas = PictureCanvas::new(self.canvas[0], self.canvas[1], BACKGROUND);
        self.draw_header(&mut canvas, spec.unit);
        self.draw_map(&mut canvas, &spec.content, range);
        self.draw_bar(&mut canvas, &spec.content, range);
        self.draw_ticks(&mut canvas);
        canvas
    }

    fn draw_header(&self, canvas: &mut PictureCanvas, unit: &str) {
        let line = (GLYPH + 3) * self.font;
        let last = self.map[1] - line - 3 * self.font;
        for (i, text) in self.title.iter().rev().enumerate() {
            canvas.text(self.map[0], last - i * line, self.font, text, INK);
        }
        canvas.text(self.bar[0], last, self.font, unit, INK);
    }

    fn draw_map(&self, canvas: &mut PictureCanvas, content: &Content, range: &BarRange) {
        let (width, height) = content.size();
        for y in 0..height {
            for x in 0..width {
                let colour = content.colour(x, y, range);
                let left = self.map[0] + x * self.zoom;
                canvas.fill(
                    left,
                    self.map[1] + y * self.zoom,
                    self.zoom,
                    self.zoom,
                    colour,
                );
            }
        }
        canvas.frame(self.map, self.map_size, self.font, LINE);
    }

    fn draw_bar(&self, canvas: &mut PictureCanvas, content: &Content, range: &BarRange) {
        let [left, top] = self.bar;
        let [width, height] = self.bar_size;
        let colour_at = |position: f64| {
            let value = range.value(position, content.scale());
            content.colour_of(value, range).unwrap_or(BACKGROUND)
        };
        for row in 0..height {
            let position = 1.0 - (row as f64 + 0.5) / height as f64;
            canvas.fill(left, top + row, width, 1, colour_at(position));
        }
        canvas.frame(self.bar, self.bar_size, self.font, LINE);
        let [below, above] = self.beyond;
        if above {
            self.draw_triangle(canvas, colour_at(1.0), |row| top - self.font - 1 - row);
        }
        if below {
            self.draw_triangle(canvas, colour_at(0.0), |row| top + height + self.font + row);
        }
    }

    /// Draws a triangle on one end of the bar, framed; `line(row)` is the picture's line of its row, counted
    /// from its base.
    fn draw_triangle(
        &self,
        canvas: &mut PictureCanvas,
        colour: [u8; 3],
        line: impl Fn(usize) -> usize,
    ) {
        let width = self.bar_size[0];
        let height = 7 * self.font;
        for row in 0..height {
            let indent = row * width / (2 * height);
            let [left, inside] = [self.bar[0] + indent, width - 2 * indent];
            canvas.fill(left - self.font, line(row), inside + 2 * self.font, 1, LINE);
            if row + self.font < height {
                canvas.fill(left, line(row), inside, 1, colour);
            }
        }
    }

    fn draw_ticks(&self, canvas: &mut PictureCanvas) {
        let left = self.bar[0] + self.bar_size[0] + self.font;
        for tick in &self.ticks {
            let from_top = (1.0 - tick.position) * (self.bar_size[1] - 1) as f64;
            let y = self.bar[1] + from_top.round() as usize;
            let length = if tick.label.is_some() { 4 } else { 2 };
            canvas.fill(left, y - self.font / 2, length * self.font, self.font, LINE);
            if let Some(label) = &tick.label {
                // Digits are seven font pixels high: their middle is three and a half down.
                let upper = y - 7 * self.font / 2;
                canvas.text(left + 7 * self.font, upper, self.font, label, INK);
            }
        }
    }
}

/// True if a value just means "no light": it is below a logarithmic bar, and needs no mark.
fn is_black(content: &Content, value: f64) -> bool {
    matches!(content.scale(), Scale::Logarithmic) && value == 0.0
}

/// Words in lines of at most `width` characters; longer words are cut.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let width = width.max(1);
    let mut lines: Vec<String> = Vec::new();
    let mut room = 0;
    for word in text.split_whitespace() {
        let characters: Vec<char> = word.chars().collect();
        if !lines.is_empty() && characters.len() < room {
            if let Some(line) = lines.last_mut() {
                line.push(' ');
                line.push_str(word);
            }
            room -= characters.len() + 1;
            continue;
        }
        for piece in characters.chunks(width) {
            lines.push(piece.iter().collect());
            room = width - piece.len();
        }
    }
    lines
}
