//! The two programs as a user starts them: arguments in, exit code and text out.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

/// What a program left behind when it ended.
#[derive(Debug)]
pub struct Run {
    /// The command line, for messages.
    pub line: String,
    /// Exit code; `None` after a signal.
    pub code: Option<i32>,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Run {
    /// Standard output of a run that succeeded without a word on standard error.
    ///
    /// # Panics
    /// When it failed, warned or drew a progress bar into the pipe.
    #[track_caller]
    pub fn done(self) -> String {
        assert_eq!(self.code, Some(0), "{}\n{}", self.line, self.err);
        assert_eq!(self.err, "", "{}", self.line);
        self.out
    }
}

/// Starts `bake` in `folder`.
pub fn bake<S: AsRef<str>>(folder: &Path, arguments: &[S]) -> Run {
    run("bake", folder, arguments)
}

/// Starts `fit` in `folder`.
pub fn fit<S: AsRef<str>>(folder: &Path, arguments: &[S]) -> Run {
    run("fit", folder, arguments)
}

/// Starts a program of this project in `folder`.
pub fn run<S: AsRef<str>>(name: &str, folder: &Path, arguments: &[S]) -> Run {
    run_by(&[], name, folder, arguments)
}

/// Likewise, by another program that takes the command line as its last arguments.
pub fn run_by<S: AsRef<str>>(
    starter: &[&OsStr],
    name: &str,
    folder: &Path,
    arguments: &[S],
) -> Run {
    let arguments: Vec<&str> = arguments.iter().map(AsRef::as_ref).collect();
    let program = fresh(name);
    let words: Vec<&OsStr> = starter
        .iter()
        .copied()
        .chain([program.as_os_str()])
        .collect();
    let output = Command::new(words[0])
        .args(&words[1..])
        .current_dir(folder)
        .args(&arguments)
        .env_remove("RUST_BACKTRACE")
        .output()
        .unwrap_or_else(|error| panic!("{name} does not start: {error}"));
    Run {
        line: format!("{name} {}", arguments.join(" ")),
        code: output.status.code(),
        out: String::from_utf8_lossy(&output.stdout).into_owned(),
        err: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// The program beside this test's own folder. Cargo builds it in `cargo test --workspace`, and not
/// in `cargo test -p tests`: a stale one would test yesterday's code.
fn fresh(name: &str) -> PathBuf {
    let test = std::env::current_exe().expect("a test is a file");
    let program = test
        .ancestors()
        .nth(2)
        .expect("target/PROFILE/deps")
        .join(name);
    let modified = |path: &Path| path.metadata().and_then(|data| data.modified());
    let built = modified(&program).unwrap_or(SystemTime::UNIX_EPOCH);
    // Cargo leaves a program alone whose own packages did not change.
    let packages: &[&str] = match name {
        "bake" => &["meshes", "tables", "bake"],
        _ => &["tables", "fit"],
    };
    let newest = packages
        .iter()
        .flat_map(|package| sources(&crate::files::project().join(package).join("src")))
        .filter_map(|file| modified(&file).ok())
        .max()
        .expect("the project has sources");
    assert!(
        built >= newest,
        "{} is missing or older than the sources: `cargo build --workspace`, or test with `make \
        test`",
        program.display()
    );
    program
}

/// All `.rs` files under a folder.
pub fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// The Python that `make test` sets up.
///
/// # Panics
/// Without it.
pub fn python() -> std::ffi::OsString {
    std::env::var_os("AIRR_PYTHON").expect(
        "AIRR_PYTHON is not set: run `make test`, which sets up a Python with h5py, xarray and \
        h5netcdf",
    )
}
