//! The machine on which a run is made.

use serde::{Deserialize, Serialize};

/// The machine on which a run was made: seconds of different machines do not compare.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// The host's name; `unknown` on systems other than Linux.
    pub host: String,
    /// The processor's name; `unknown` if the system does not tell it.
    pub processor: String,
}

impl Machine {
    /// The machine on which this program runs.
    pub fn this() -> Self {
        let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
        Self::from_texts(&read("/proc/sys/kernel/hostname"), &read("/proc/cpuinfo"))
    }

    /// The machine by the texts of Linux's `hostname` and `cpuinfo`, both empty on other systems.
    fn from_texts(hostname: &str, cpuinfo: &str) -> Self {
        let fields = cpuinfo.lines().filter_map(|line| line.split_once(':'));
        let mut names = fields.filter(|(key, _)| key.trim() == "model name");
        let known = |text: &str| match text.trim() {
            "" => "unknown".to_owned(),
            text => text.to_owned(),
        };
        Self {
            host: known(hostname),
            processor: known(names.next().map_or("", |(_, name)| name)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn host_and_processor_are_as_linux_tells_them() {
        let cpuinfo = "processor\t: 0\nmodel\t\t: 85\nmodel name\t: Some CPU @ 2.00GHz: two\nflags\t\t: fpu\n\n\
                       processor\t: 1\nmodel name\t: another\n";
        let machine = Machine::from_texts("lab-7\n", cpuinfo);
        assert_eq!(machine.host, "lab-7");
        assert_eq!(machine.processor, "Some CPU @ 2.00GHz: two");
    }

    #[test]
    fn what_the_system_does_not_tell_is_unknown() {
        let silent = Machine::from_texts("", "processor\t: 0\nmodel name\t:\n");
        assert_eq!([silent.host, silent.processor], ["unknown"; 2]);
    }
}
