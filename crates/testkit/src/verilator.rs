//! Builds and runs test benches of `rtl/` with Verilator, where it is installed.

use std::env;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A compiled test bench.
pub struct Bench(PathBuf);

/// The program: what `POWERGS_VERILATOR` says, or one on the path.
pub fn program() -> Option<PathBuf> {
    if let Some(program) = env::var_os("POWERGS_VERILATOR") {
        return Some(program.into());
    }
    let path = env::var_os("PATH")?;
    let places = env::split_paths(&path)
        .flat_map(|folder| ["verilator", "verilator-cli"].map(|name| folder.join(name)));
    places.into_iter().find(|place| place.is_file())
}

/// Whether there is one; says so, with the name of what is skipped, where there is none.
pub fn is_there(name: &str) -> bool {
    let is_there = program().is_some();
    if !is_there {
        eprintln!("{name}: skipped, no Verilator (set POWERGS_VERILATOR or install it)");
    }
    is_there
}

impl Bench {
    /// Lints and compiles `rtl/tb/NAME.sv` or `rtl/NAME.sv` with `rtl/tb/NAME.cpp` in a folder of
    /// its own in `place`, where it finds what it built before; `None`, with a line that says so,
    /// without Verilator.
    ///
    /// # Panics
    /// When it does not compile.
    pub fn build(place: &str, name: &str, parameters: &[(&str, u32)]) -> Option<Bench> {
        let verilator = program().filter(|_| is_there(name))?;
        let rtl = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../rtl");
        let rtl = rtl.canonicalize().expect("the folder rtl");
        let values: String =
            parameters.iter().map(|(key, value)| format!("-{key}{value}")).collect();
        // What was built with another Verilator names files of that one.
        let mut hasher = DefaultHasher::new();
        verilator.hash(&mut hasher);
        let folder = format!("{name}{values}-{:016x}", hasher.finish());
        let folder = Path::new(place).join(folder);
        fs::create_dir_all(&folder).expect("a folder for the test bench");
        let tops = [format!("tb/{name}.sv"), format!("{name}.sv")].map(|file| rtl.join(file));
        let top = tops.into_iter().find(|top| top.exists()).expect("the top module");
        let mut build = Command::new(verilator);
        build.args(["--cc", "--exe", "--build", "-Wall", "-O3", "--x-initial", "fast", "-Mdir"]);
        build
            .arg(&folder)
            .arg("-y")
            .arg(&rtl)
            .arg("-y")
            .arg(rtl.join("tb"))
            .args(["--top-module", name]);
        build.args(parameters.iter().map(|(key, value)| format!("-G{key}={value}")));
        build.args(["-MAKEFLAGS", "VK_PCH_I_FAST= VK_PCH_I_SLOW=", "-CFLAGS"]);
        let defines = parameters.iter().map(|(key, value)| format!(" -D{key}={value}"));
        build.arg(format!("-std=c++17 -O1{}", defines.collect::<String>()));
        build.arg(rtl.join("fp_pkg.sv"));
        if name.starts_with("ccu") {
            build.args(["fp_special_pkg.sv", "ccu_program_pkg.sv"].map(|file| rtl.join(file)));
        }
        build.arg(top).arg(rtl.join(format!("tb/{name}.cpp")));
        let built = build.output().expect("Verilator runs");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        assert!(built.status.success(), "{}{}", text(&built.stdout), text(&built.stderr));
        Some(Bench(folder.join(format!("V{name}"))))
    }

    /// What it writes when it reads these words.
    ///
    /// # Panics
    /// When it fails: it found no end.
    pub fn run(&self, words: &[u16]) -> Vec<u16> {
        let input: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let mut command = Command::new(&self.0);
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().expect("the test bench runs");
        let mut stdin = child.stdin.take().expect("a pipe");
        let writer = std::thread::spawn(move || stdin.write_all(&input));
        let output = child.wait_with_output().expect("the test bench ends");
        writer.join().expect("a writer").expect("the test bench reads everything");
        assert!(output.status.success(), "{} failed", self.0.display());
        let pairs = output.stdout.chunks_exact(2);
        pairs.map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect()
    }
}
