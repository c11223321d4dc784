//! Time of the processor.

use std::fs;

/// User and system time of all threads \[s\], in steps of 10 ms, if the system tells it (Linux); else no number.
/// It is the cost of work, however busy the machine is.
pub fn seconds() -> f64 {
    let ticks = || {
        let stat = fs::read_to_string("/proc/self/stat").ok()?;
        // Fields are counted after the name, which may hold anything: `utime` and `stime` are fields 14 and 15
        // of the line.
        let (_, fields) = stat.rsplit_once(')')?;
        let mut times = fields.split_whitespace().skip(11).map(str::parse::<f64>);
        Some(times.next()?.ok()? + times.next()?.ok()?)
    };
    ticks().map_or(f64::NAN, |ticks| ticks / 100.0)
}

/// CPU milliseconds \[ms\] of something, by as many times as take some CPU seconds: the clock has steps of 10 ms.
pub fn milliseconds(long: f64, mut run: impl FnMut()) -> f64 {
    run();
    let start = seconds();
    let mut runs = 0.0;
    loop {
        run();
        runs += 1.0;
        let spent = seconds() - start;
        // Also where nobody tells the time.
        if spent.is_nan() || spent >= long {
            return 1000.0 * spent / runs;
        }
    }
}
