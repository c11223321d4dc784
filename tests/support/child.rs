//! A program that answers each line with a line.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdout, Command, Stdio};

/// The program, under way.
pub struct Answering {
    process: Child,
    answers: BufReader<ChildStdout>,
}

impl Answering {
    /// Starts it; returns the reason if that is not possible.
    pub fn start(command: &mut Command) -> Result<Self, String> {
        let program = command.get_program().to_string_lossy().into_owned();
        let mut process = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| format!("{program}: {error}"))?;
        let answers = process.stdout.take().ok_or("no pipe")?;
        Ok(Self {
            process,
            answers: BufReader::new(answers),
        })
    }

    /// Sends a line.
    pub fn send(&mut self, line: &str) {
        let input = self.process.stdin.as_mut().expect("a pipe");
        writeln!(input, "{line}").expect("it listens");
    }

    /// The next line that it answers; `None` if it has ended.
    pub fn answer(&mut self) -> Option<String> {
        let mut line = String::new();
        let length = self.answers.read_line(&mut line).ok()?;
        (length > 0).then_some(line)
    }
}

impl Drop for Answering {
    fn drop(&mut self) {
        // It ends with its input. Nothing is lost if it does not.
        drop(self.process.stdin.take());
        let _ = self.process.wait();
    }
}
