//! A headless Chromium, if the machine has one.

use std::ffi::OsString;
use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// Names of Chromium's program in Linux distributions.
const NAMES: [&str; 4] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "chrome-headless-shell",
];

/// A headless Chromium of this machine, with a profile of its own.
pub struct Browser {
    program: PathBuf,
    // Folder of the browser's profile. It is removed when the test ends.
    profile: tempfile::TempDir,
}

impl Browser {
    /// Finds a Chromium: the program that AIRR_CHROMIUM names, or else one on PATH.
    ///
    /// Returns `None` if there is none, and says so straight on standard error, because the test
    /// harness hides what a passing test prints. `make test` says it again at its end: it collects
    /// one line for each skipped test in the file that AIRR_SKIPPED names.
    ///
    /// # Panics
    /// Panics if AIRR_CHROMIUM names no file.
    pub fn find() -> Option<Browser> {
        let program = match std::env::var_os("AIRR_CHROMIUM") {
            Some(named) => {
                let named = PathBuf::from(named);
                assert!(
                    named.is_file(),
                    "AIRR_CHROMIUM: {} is no file",
                    named.display()
                );
                Some(named)
            }
            None => on_path(),
        };
        if program.is_none() {
            const REASON: &str = "no Chromium on PATH, so a page was not looked at in a browser \
                (Debian: apt install chromium, or set AIRR_CHROMIUM)";
            let _ = writeln!(std::io::stderr(), "SKIPPED: {REASON}");
            let notes = std::env::var_os("AIRR_SKIPPED").map(|file| {
                let mut file = OpenOptions::new().create(true).append(true).open(file)?;
                writeln!(file, "{REASON}")
            });
            notes.transpose().expect("AIRR_SKIPPED takes a line");
        }
        Some(Browser {
            program: program?,
            profile: tempfile::tempdir().expect("a temporary folder"),
        })
    }

    /// Opens a page in a frame and returns the JSON that the page posts to its parent.
    ///
    /// The frame is `width` CSS pixels wide. Chromium opens no window narrower than 500 pixels,
    /// but a frame can be. If `dark` is true, the user prefers dark colours.
    ///
    /// # Panics
    /// Panics if the browser fails, or if the page posts no JSON.
    pub fn probe(&self, page: &Path, width: u32, dark: bool) -> Value {
        let scheme = if dark { 0 } else { 1 };
        let frame = self.profile.path().join("frame.html");
        let markup = format!(
            "<!DOCTYPE html><html style=\"color-scheme: light dark\"><title></title>\
             <script>addEventListener('message', (event) => {{ document.title = event.data; \
             }});</script>\
             <iframe src=\"{}\" style=\"width: {width}px; height: 900px; border: \
             0\"></iframe></html>",
            address(page).display()
        );
        std::fs::write(&frame, markup).expect("a temporary folder takes a file");
        // Virtual time runs on while other threads of the browser unpack data or decode a picture.
        // On a busy machine it can be over before they are, so the page is then opened again.
        let mut errors = String::new();
        for _ in 0..5 {
            let output = self.run(&[
                "--window-size=1400,900".into(),
                format!("--blink-settings=preferredColorScheme={scheme}").into(),
                // Virtual time runs as fast as the page works. The page is dumped when it is idle.
                "--virtual-time-budget=60000".into(),
                "--dump-dom".into(),
                address(&frame),
            ]);
            let dumped = String::from_utf8_lossy(&output.stdout);
            let title = dumped
                .split_once("<title>")
                .and_then(|(_, rest)| rest.split_once("</title>"))
                .map(|(title, _)| title.replace("&amp;", "&"));
            if let Some(posted) = title.and_then(|title| serde_json::from_str(&title).ok()) {
                return posted;
            }
            errors = String::from_utf8_lossy(&output.stderr).into_owned();
        }
        panic!("the page posted no JSON\n{errors}");
    }

    /// Prints a page to a PDF and returns its bytes.
    ///
    /// # Panics
    /// Panics if the browser fails or writes no file.
    pub fn print(&self, page: &Path, pdf: &Path) -> Vec<u8> {
        let mut to = OsString::from("--print-to-pdf=");
        to.push(pdf);
        let output = self.run(&[to, "--no-pdf-header-footer".into(), address(page)]);
        std::fs::read(pdf)
            .unwrap_or_else(|error| panic!("{error}\n{}", String::from_utf8_lossy(&output.stderr)))
    }

    fn run(&self, arguments: &[OsString]) -> Output {
        let mut profile = OsString::from("--user-data-dir=");
        profile.push(self.profile.path());
        let output = Command::new(&self.program)
            .args(["--headless", "--disable-gpu", "--hide-scrollbars"])
            // The sandbox needs rights that a container lacks. Only pages of the tests are opened.
            .args(["--no-sandbox", "--disable-dev-shm-usage", "--no-first-run"])
            .arg(profile)
            .args(arguments)
            .output()
            .unwrap_or_else(|error| panic!("{}: {error}", self.program.display()));
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        output
    }
}

fn on_path() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    NAMES
        .iter()
        .flat_map(|name| folders.iter().map(move |folder| folder.join(name)))
        .find(|program| program.is_file())
}

fn address(page: &Path) -> OsString {
    let mut address = OsString::from("file://");
    address.push(page);
    address
}
