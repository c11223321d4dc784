//! Curves on logarithmic axes, as SVG.

use std::fmt::Write as _;

/// Error against one kind of cost.
pub struct Chart<'a> {
    /// Above the chart.
    pub title: &'a str,
    /// What the horizontal axis counts.
    pub horizontal: &'a str,
    /// The methods.
    pub curves: Vec<Curve<'a>>,
}

/// One method.
pub struct Curve<'a> {
    /// In the legend.
    pub name: &'a str,
    /// (cost, error), both positive to be seen.
    pub points: Vec<(f64, f64)>,
}

/// Of a chart, axes and all.
const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 340.0;

/// Between a chart's borders and its axes: left, right, top, bottom.
const MARGINS: [f64; 4] = [64.0, 16.0, 34.0, 46.0];

/// Told apart by most eyes (Okabe and Ito).
const COLOURS: [&str; 3] = ["#0072b2", "#d55e00", "#009e73"];

/// A logarithmic axis from one power of ten to another.
struct Axis {
    low: i32,
    high: i32,
    start: f64,
    end: f64,
}

impl Axis {
    fn round(values: impl Iterator<Item = f64>, start: f64, end: f64) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|value| *value > 0.0) {
            low = low.min(value.log10());
            high = high.max(value.log10());
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        let low = low.floor() as i32;
        Self {
            low,
            high: (high.ceil() as i32).max(low + 1),
            start,
            end,
        }
    }

    fn place(&self, value: f64) -> f64 {
        let part = (value.log10() - f64::from(self.low)) / f64::from(self.high - self.low);
        self.start + part * (self.end - self.start)
    }

    fn powers(&self) -> impl Iterator<Item = (i32, f64)> {
        (self.low..=self.high).map(|power| (power, self.place(10.0_f64.powi(power))))
    }
}

/// Charts side by side.
pub fn draw(charts: &[Chart]) -> String {
    let mut svg = String::new();
    let width = WIDTH * charts.len() as f64;
    // Writing to a string cannot fail.
    let _ = writeln!(
        svg,
        r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {HEIGHT}" font-family="sans-serif" font-size="12">
<rect width="{width}" height="{HEIGHT}" fill="#ffffff"/>"##
    );
    for (index, chart) in charts.iter().enumerate() {
        let _ = writeln!(
            svg,
            r#"<g transform="translate({} 0)">"#,
            WIDTH * index as f64
        );
        one(&mut svg, chart);
        svg.push_str("</g>\n");
    }
    svg.push_str("</svg>\n");
    svg
}

fn one(svg: &mut String, chart: &Chart) {
    let points = || chart.curves.iter().flat_map(|curve| &curve.points);
    let [left, right, top, bottom] = MARGINS;
    let (x0, x1, y0, y1) = (left, WIDTH - right, HEIGHT - bottom, top);
    let across = Axis::round(points().map(|point| point.0), x0, x1);
    let up = Axis::round(points().map(|point| point.1), y0, y1);
    let _ = writeln!(
        svg,
        r#"<text x="{x0}" y="20" font-weight="bold">{}: relative RMS error</text>
<text x="{}" y="{}" text-anchor="middle">{}</text>"#,
        chart.title,
        0.5 * (x0 + x1),
        HEIGHT - 10.0,
        chart.horizontal
    );
    for (power, x) in across.powers() {
        let _ = writeln!(
            svg,
            r##"<path d="M{x:.1} {y0}V{y1}" stroke="#dddddd"/><text x="{x:.1}" y="{}" text-anchor="middle">{}</text>"##,
            y0 + 16.0,
            label(power)
        );
    }
    for (power, y) in up.powers() {
        let _ = writeln!(
            svg,
            r##"<path d="M{x0} {y:.1}H{x1}" stroke="#dddddd"/><text x="{}" y="{:.1}" text-anchor="end">{}</text>"##,
            x0 - 6.0,
            y + 4.0,
            label(power)
        );
    }
    for (rank, (curve, colour)) in chart.curves.iter().zip(COLOURS).enumerate() {
        let places: Vec<(f64, f64)> = curve
            .points
            .iter()
            .filter(|(cost, error)| *cost > 0.0 && *error > 0.0)
            .map(|(cost, error)| (across.place(*cost), up.place(*error)))
            .collect();
        let line: Vec<String> = places
            .iter()
            .map(|(x, y)| format!("{x:.1},{y:.1}"))
            .collect();
        let _ = writeln!(
            svg,
            r#"<polyline points="{}" fill="none" stroke="{colour}" stroke-width="2"/>"#,
            line.join(" ")
        );
        for (x, y) in places {
            let _ = writeln!(
                svg,
                r#"<circle cx="{x:.1}" cy="{y:.1}" r="3" fill="{colour}"/>"#
            );
        }
        let _ = writeln!(
            svg,
            r#"<text x="{}" y="{}" text-anchor="end" fill="{colour}">{}</text>"#,
            x1 - 4.0,
            y1 + 16.0 * (rank as f64 + 1.0),
            curve.name
        );
    }
}

/// 10ⁿ, short where it is short.
fn label(power: i32) -> String {
    match power {
        -2..=2 => format!("{}", 10.0_f64.powi(power)),
        _ => format!("1e{power}"),
    }
}
