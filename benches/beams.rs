//! Seconds and rays to a true error, beams beside Sobol' photons: `cargo bench --bench beams`; with `--
//! --all`, some minutes, on all scenes.
//!
//! True errors are root mean square over the lit texels, relative to their mean, of all specular layers
//! together, to depth 4 (the bumpy ball: 2). They are against closed forms if there are such, else against a
//! finer beam run. Photons are far from such errors in the time of a bench. Their seconds to the true error
//! of beams are *extrapolated* from two runs, 16 times apart, with the order that the two show. Set-up and
//! direct light are in everybody's seconds; the share of direct light in the beams' seconds is shown beside
//! it.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a bench, no results"
)]

#[path = "../tests/support/mod.rs"]
mod support;

use nephroid::internals::numeric::StreamKind;
use support::contest::Contest;
use support::cpu;

fn main() {
    println!(
        "| scene, texels a side | asked | s | CPU s | direct, CPU s | M rays | said | true error | MB | photons' order | photons, s (extrapolated) | ratio |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    let contests: [fn() -> Contest; 7] = [
        || Contest::known(4, "glass-ball", 128),
        || Contest::known(4, "glass-ball", 256),
        || Contest::known(4, "sine-water", 256),
        || Contest::known(4, "glass-ball", 512),
        || Contest::known(4, "coffee-cup", 256),
        || Contest::finer(4, "water", 256, 1e-5),
        || Contest::finer(2, "smooth mesh", 256, 3e-4),
    ];
    let is_all = std::env::args().any(|argument| argument == "--all");
    let count = if is_all { contests.len() } else { 1 };
    for contest in &contests[..count] {
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
    let side = contest.truth.len().isqrt();
    let before = cpu::seconds();
    contest.direct();
    let direct = cpu::seconds() - before;
    for asked in [1e-2, 3e-3, 1e-3] {
        let resident = process::resident();
        process::forget_peak();
        let before = cpu::seconds();
        let beams = contest.beams(asked);
        let cpu = cpu::seconds() - before;
        let peak = match (resident, process::peak()) {
            (Some(before), Some(peak)) => {
                format!("{:.0}", peak.saturating_sub(before) as f64 / 1e3)
            }
            _ => "?".to_owned(),
        };
        let photons = many.seconds * (many.rmse / beams.rmse).powf(1.0 / order);
        println!(
            "| {}, {side} | {:.1} % | {:.2} | {cpu:.2} | {direct:.2} | {:.2} | {:.3} % | {:.3} % | {peak} | {order:.2} | {photons:.1} | {:.0} |",
            contest.name,
            100.0 * asked,
            beams.seconds,
            beams.rays as f64 / 1e6,
            100.0 * beams.said.unwrap_or(f64::NAN),
            100.0 * beams.rmse,
            photons / beams.seconds,
        );
    }
}

/// Linux' figures of this process: memory in kilobytes; unknown on other systems.
mod process {
    use std::fs;

    pub fn resident() -> Option<u64> {
        field("VmRSS:")
    }

    pub fn peak() -> Option<u64> {
        field("VmHWM:")
    }

    /// Starts a new peak; if that is not possible, the old one stands.
    pub fn forget_peak() {
        let _ = fs::write("/proc/self/clear_refs", "5");
    }

    fn field(name: &str) -> Option<u64> {
        let status = fs::read_to_string("/proc/self/status").ok()?;
        let line = status.lines().find(|line| line.starts_with(name))?;
        line.split_whitespace().nth(1)?.parse().ok()
    }
}
