//! The two programs, started as a user starts them: arguments in, exit code and text out.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Instant, SystemTime};

/// Name of the program that opens tables for the two.
const READER: &str = "airr-reader";

/// Seconds after which a test says how long a program ran.
const SLOW_SECONDS: f64 = 5.0;

/// Exit code and output of a program that has ended.
#[derive(Debug)]
pub struct Run {
    /// Command line, for the messages of tests.
    pub line: String,
    /// Exit code; `None` if a signal ended the program.
    pub code: Option<i32>,
    /// Text on standard output.
    pub out: String,
    /// Text on standard error.
    pub err: String,
}

impl Run {
    /// Returns the standard output of a run that succeeded and wrote nothing to standard error.
    ///
    /// # Panics
    /// Panics if the run failed, gave a warning or drew a progress bar into the pipe.
    #[track_caller]
    pub fn done(self) -> String {
        assert_eq!(self.code, Some(0), "{}\n{}", self.line, self.err);
        assert_eq!(self.err, "", "{}", self.line);
        self.out
    }
}

/// A command line behind the name of its program: text, whose words lie between spaces, or a list
/// of words, which may hold spaces.
pub trait Line {
    /// Returns the words.
    fn words(&self) -> Vec<String>;
}

impl Line for str {
    fn words(&self) -> Vec<String> {
        self.split_whitespace().map(str::to_owned).collect()
    }
}

impl Line for String {
    fn words(&self) -> Vec<String> {
        self.as_str().words()
    }
}

impl<S: AsRef<str>> Line for [S] {
    fn words(&self) -> Vec<String> {
        self.iter().map(|word| word.as_ref().to_owned()).collect()
    }
}

impl<S: AsRef<str>, const N: usize> Line for [S; N] {
    fn words(&self) -> Vec<String> {
        self.as_slice().words()
    }
}

impl<S: AsRef<str>> Line for Vec<S> {
    fn words(&self) -> Vec<String> {
        self.as_slice().words()
    }
}

/// Runs `bake` in `folder` until it ends.
pub fn bake(folder: &Path, line: &(impl Line + ?Sized)) -> Run {
    run("bake", folder, line)
}

/// Runs `fit` in `folder` until it ends.
pub fn fit(folder: &Path, line: &(impl Line + ?Sized)) -> Run {
    run("fit", folder, line)
}

/// Runs `bake` or `fit`, by name, in `folder` until it ends.
pub fn run(name: &str, folder: &Path, line: &(impl Line + ?Sized)) -> Run {
    run_by(&[], name, folder, line)
}

/// Runs `bake` or `fit` in `folder` through another program.
///
/// `starter` is that program with its first arguments. It gets the command line of `bake` or `fit`
/// as its last arguments. An empty `starter` means that no other program is used.
pub fn run_by(starter: &[&OsStr], name: &str, folder: &Path, line: &(impl Line + ?Sized)) -> Run {
    let arguments = line.words();
    let program = fresh(name);
    let words: Vec<&OsStr> = starter
        .iter()
        .copied()
        .chain([program.as_os_str()])
        .collect();
    let line = format!("{name} {}", arguments.join(" "));
    let start = Instant::now();
    let output = Command::new(words[0])
        .args(&words[1..])
        .current_dir(folder)
        .args(&arguments)
        .env_remove("RUST_BACKTRACE")
        .output()
        .unwrap_or_else(|error| panic!("{name} does not start: {error}"));
    let seconds = start.elapsed().as_secs_f64();
    if seconds > SLOW_SECONDS {
        println!("{seconds:.1} s: {line}");
    }
    Run {
        line,
        code: output.status.code(),
        out: String::from_utf8_lossy(&output.stdout).into_owned(),
        err: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// Runs `bake` or `fit` in `folder` on a terminal, which shows standard error too.
pub fn on_terminal(name: &str, folder: &Path, line: &(impl Line + ?Sized)) -> Run {
    const TERMINAL: &str = "import pty, sys; sys.exit(pty.spawn(sys.argv[1:]) >> 8)";
    let terminal = [python(), "-c".into(), TERMINAL.into()];
    let terminal: Vec<&OsStr> = terminal.iter().map(AsRef::as_ref).collect();
    run_by(&terminal, name, folder, line)
}

/// Returns the path of a program in the build folder of this test, and checks that it and the
/// reader are newer than the sources.
///
/// `cargo test --workspace` builds the programs, but `cargo test -p tests` does not. Without the
/// check, a test could run an old program.
///
/// # Panics
/// Panics if the program is missing or old.
pub fn fresh(name: &str) -> PathBuf {
    let test = std::env::current_exe().expect("a test is a file");
    let program = test
        .ancestors()
        .nth(2)
        .expect("target/PROFILE/deps")
        .join(name);
    // Both programs start the reader.
    if name != READER {
        fresh(READER);
    }
    let modified = |path: &Path| path.metadata().and_then(|data| data.modified());
    let built = modified(&program).unwrap_or(SystemTime::UNIX_EPOCH);
    // Cargo does not rebuild a program if its own packages did not change. So only the sources of
    // these packages count.
    let packages: &[&str] = match name {
        "bake" => &["meshes", "tables", "tables/charts", "bake"],
        READER => &["tables", "reader"],
        _ => &["tables", "tables/charts", "fit"],
    };
    let project = crate::files::project();
    let newest = packages
        .iter()
        .flat_map(|package| sources(&project.join(package).join("src")))
        // No program holds the tests of its package.
        .filter(|file| {
            let own = file.strip_prefix(&project).unwrap_or(file);
            !own.iter().any(|part| part == "tests" || part == "tests.rs")
        })
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

/// Returns all `.rs` files in a folder and its subfolders, sorted.
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

/// Returns the Python interpreter that `make test` sets up; AIRR_PYTHON names it.
///
/// # Panics
/// Panics if AIRR_PYTHON is not set.
pub fn python() -> std::ffi::OsString {
    std::env::var_os("AIRR_PYTHON").expect(
        "AIRR_PYTHON is not set: run `make test`, which sets up a Python with h5py, xarray and \
        h5netcdf",
    )
}
