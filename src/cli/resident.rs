//! The memory that the program itself takes, as the system counts it.

/// What the program has in memory \[bytes\]; `None` where the system does not say (it does on Linux).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resident {
    /// Of its own: heap and stacks.
    pub own: u64,
    /// Of files: its code, as far as it has run, and that of libraries.
    pub code: u64,
}

impl Resident {
    /// At this moment.
    pub fn now() -> Option<Self> {
        Self::parsed(&std::fs::read_to_string("/proc/self/status").ok()?)
    }

    fn parsed(status: &str) -> Option<Self> {
        let bytes = |key: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(key))?;
            let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
            kilobytes.checked_mul(1024)
        };
        Some(Self {
            own: bytes("RssAnon:")?,
            code: bytes("RssFile:")?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_systems_word_on_resident_memory_is_understood() {
        let text = "VmRSS:\t 99 kB\nRssAnon:\t    1448 kB\nRssFile:\t    9972 kB\n";
        let (own, code) = (1448 * 1024, 9972 * 1024);
        assert_eq!(Resident::parsed(text), Some(Resident { own, code }));
        for text in ["", "RssAnon: 1 kB", "RssAnon: 1 kB\nRssFile: x kB"] {
            assert_eq!(Resident::parsed(text), None, "{text}");
        }
    }
}
