//! The program.

fn main() -> std::process::ExitCode {
    powergs_sim::cli::main()
}
