//! `nephroid`: ground truth for caustics.

fn main() -> std::process::ExitCode {
    nephroid::cli::main()
}
