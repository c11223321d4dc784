//! Seconds and rays to a true error, beams beside Sobol' photons: `cargo bench --bench beams`.
//!
//! True errors are root mean square over the lit texels of 256 x 256, relative to their mean, of all specular
//! layers together, to depth 4 (the bumpy ball: 2): against closed forms where there are such, else
//! against a finer beam run. Photons are far from such errors in the time of a bench: their seconds to the
//! error asked for are *extrapolated* from two runs, 16 times apart, with the order that the two show. Set-up and
//! direct light are in everybody's seconds.

#[path = "../tests/support/mod.rs"]
mod support;

use nephroid::numeric::StreamKind;
use support::contest::Contest;

const SIDE: usize = 256;

fn main() {
    println!(
        "| scene, {SIDE} x {SIDE} | asked | s | M rays | true error | MB | photons' order | photons, s (extrapolated) | ratio |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|");
    for contest in [
        || Contest::known(4, "glass-ball", SIDE),
        || Contest::known(4, "coffee-cup", SIDE),
        || Contest::known(4, "sine-water", SIDE),
        || Contest::finer(4, "water", SIDE, 1e-4),
        || Contest::finer(2, "smooth mesh", SIDE, 3e-4),
    ] {
        compare(&contest());
    }
    println!(
        "\nMB: the peak of resident memory over what was there before the run, the film and the result in it."
    );
}

fn compare(contest: &Contest) {
    let few = contest.photons(StreamKind::Sobol, 1 << 16);
    let many = contest.photons(StreamKind::Sobol, 1 << 20);
    let order = (few.rmse / many.rmse).ln() / 16.0_f64.ln();
    for asked in [1e-2, 1e-3] {
        let before = memory::resident();
        memory::forget_peak();
        let beams = contest.beams(asked);
        let peak = match (before, memory::peak()) {
            (Some(before), Some(peak)) => {
                format!("{:.0}", peak.saturating_sub(before) as f64 / 1e3)
            }
            _ => "?".to_owned(),
        };
        let photons = many.seconds * (many.rmse / asked).powf(1.0 / order);
        println!(
            "| {} | {:.1} % | {:.2} | {:.2} | {:.3} % | {peak} | {order:.2} | {photons:.1} | {:.0} |",
            contest.name,
            100.0 * asked,
            beams.seconds,
            beams.rays as f64 / 1e6,
            100.0 * beams.rmse,
            photons / beams.seconds,
        );
    }
}

/// What Linux tells of this process's memory, in kilobytes; elsewhere nothing is known.
mod memory {
    use std::fs;

    pub fn resident() -> Option<u64> {
        field("VmRSS:")
    }

    pub fn peak() -> Option<u64> {
        field("VmHWM:")
    }

    /// Starts a new peak; where it cannot, the old one stands.
    pub fn forget_peak() {
        let _ = fs::write("/proc/self/clear_refs", "5");
    }

    fn field(name: &str) -> Option<u64> {
        let status = fs::read_to_string("/proc/self/status").ok()?;
        let line = status.lines().find(|line| line.starts_with(name))?;
        line.split_whitespace().nth(1)?.parse().ok()
    }
}
