//! The reader of tables as a user meets it: no code is loaded, and a missing reader is named.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tests::files::{argument, bake_table_with};
use tests::program::fresh;

/// Bakes a small table in `folder` and returns the path of a copy without its second half.
fn half_a_table(folder: &Path) -> PathBuf {
    let options = "--method rays --rays 4096 --bins 16";
    let table = bake_table_with(folder, "triangular", "0", "30", options);
    let bytes = fs::read(folder.join(table)).unwrap();
    let half = folder.join("half.h5");
    fs::write(&half, &bytes[..bytes.len() / 2]).unwrap();
    half
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A plug-in of the HDF5 library that leaves a file when it is loaded, in the folder in which the
/// environment makes the library look. It looks there for a table that is cut short.
#[test]
fn no_plug_in_is_loaded() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let trace = here.join("loaded");
    let source = here.join("plugin.c");
    let code = format!(
        "#include <stdio.h>\n__attribute__((constructor)) static void loaded(void) \
         {{ FILE *file = fopen(\"{}\", \"w\"); if (file) fclose(file); }}\n",
        trace.display()
    );
    fs::write(&source, code).unwrap();
    let library = here.join("libplugin.so");
    let compiled = Command::new("cc")
        .args(["-shared", "-fPIC", "-o"])
        .args([&library, &source])
        .status()
        .expect("a C compiler, which the build needs too");
    assert!(compiled.success());
    // The plug-in does what it should when it is loaded.
    let loaded = Command::new("true")
        .env("LD_PRELOAD", &library)
        .status()
        .unwrap();
    assert!(loaded.success() && trace.exists(), "the plug-in is wrong");
    fs::remove_file(&trace).unwrap();

    let half = half_a_table(here);
    let mut tried = 0;
    for program in ["bake", "fit", "airr-reader"] {
        let bytes = fs::read(fresh(program)).unwrap();
        let named = |text: &[u8]| bytes.windows(text.len()).any(|part| part == text);
        assert!(named(b"HDF5_PLUGIN_PATH"), "{program} holds the library");
        assert!(
            !named(b"/lib/plugin"),
            "{program} names a folder of plug-ins; built long ago? cargo clean -p hdf5-metno-src"
        );
    }
    let verbs: [(&str, &str); 5] = [
        ("bake", "inspect half.h5"),
        ("bake", "verify half.h5"),
        ("bake", "merge half.h5 half.h5 -o merged.h5"),
        ("bake", "trace triangular.obj -o again.h5"),
        ("fit", "predict none.json --table half.h5 --distance 150"),
    ];
    for (program, arguments) in verbs {
        let output = Command::new(fresh(program))
            .args(arguments.split(' '))
            .current_dir(here)
            .env("HDF5_PLUGIN_PATH", here)
            .env("HDF5_VOL_CONNECTOR", "airr_plugin")
            .env("HDF5_DRIVER", "airr_plugin")
            .output()
            .unwrap();
        assert!(!trace.exists(), "{program} {arguments} loaded the plug-in");
        assert!(!said(&output).contains("panicked"), "{}", said(&output));
        tried += 1;
    }
    assert!(half.exists());
    println!("{tried} verbs, 3 programs");
}

/// Copies `bake` to a folder of its own, with a script of this text as its reader.
fn with_reader(here: &Path, script: Option<&str>) -> PathBuf {
    let bin = here.join("bin");
    fs::create_dir_all(&bin).unwrap();
    fs::copy(fresh("bake"), bin.join("bake")).unwrap();
    let reader = bin.join("airr-reader");
    let _ = fs::remove_file(&reader);
    if let Some(script) = script {
        fs::write(&reader, script).unwrap();
        fs::set_permissions(&reader, fs::Permissions::from_mode(0o755)).unwrap();
    }
    bin.join("bake")
}

/// The three programs copied to a folder, as an installation puts them, find one another: by their
/// path, by a link from elsewhere, with an empty environment, and from another folder.
#[test]
fn installed_programs_find_the_reader() {
    let folder = tempfile::tempdir().unwrap();
    let (bin, links) = (folder.path().join("bin"), folder.path().join("links"));
    let table = bake_table_with(folder.path(), "triangular-pair", "20", "30", "");
    for made in [&bin, &links] {
        fs::create_dir(made).unwrap();
    }
    for program in ["bake", "fit", "airr-reader"] {
        fs::copy(fresh(program), bin.join(program)).unwrap();
    }
    for program in ["bake", "fit"] {
        std::os::unix::fs::symlink(bin.join(program), links.join(program)).unwrap();
    }
    let fitted = argument("fuzz/corpus/result/honest");
    let places = "--distance 150 --incidence 20";
    let predict = format!("predict {fitted} --table {table} {places}");
    let cases: [(&str, &str); 2] = [("bake", &format!("verify {table}")), ("fit", &predict)];
    let mut tried = 0;
    for started in [&bin, &links] {
        for (program, words) in cases {
            let output = unbusy(|| {
                Command::new(started.join(program))
                    .args(words.split(' '))
                    .env_clear()
                    .current_dir(folder.path())
                    .output()
            });
            assert_eq!(
                output.status.code(),
                Some(0),
                "{program}: {}",
                said(&output)
            );
            tried += 1;
        }
    }
    println!("{tried} runs");
}

/// Everything that installs the programs installs the reader too.
#[test]
fn the_reader_is_packed_with_the_programs() {
    let read = |file: &str| fs::read_to_string(argument(file)).unwrap();
    let wheel = read("python/build_backend.py");
    assert!(wheel.contains("PROGRAMS = (\"bake\", \"fit\", \"airr-reader\")\n"));
    let make = read("Makefile");
    assert!(make.contains("-p bake -p fit -p reader\n"));
    assert!(make.contains("for program in bake fit airr-reader; do"));
}

/// Runs a program that was written a moment ago, again if it is busy.
///
/// Another test may start a process while the file is still open for writing here. Then it is open
/// in that process too, until it becomes another program.
fn unbusy(run: impl Fn() -> std::io::Result<Output>) -> Output {
    for _ in 0..100 {
        match run() {
            Err(error) if error.kind() == std::io::ErrorKind::ExecutableFileBusy => {}
            Ok(output) if said(&output).contains("Text file busy") => {}
            output => return output.expect("the program starts"),
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    panic!("the program is busy for 2 seconds");
}

#[test]
fn a_reader_that_is_missing_or_wrong_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    half_a_table(here);
    let remedy = "put it beside this program, with `make install`";
    let cases = [
        (None, "cannot be started (No such file", remedy),
        (
            Some("#!/bin/sh\nprintf 'V\\0009.9.9'\n"),
            "is of version \"9.9.9\", this program of",
            remedy,
        ),
        (
            Some("#!/bin/sh\nkill -SEGV $$\n"),
            "was ended by signal 11",
            "copy it again",
        ),
        (
            Some("#!/bin/sh\nprintf 'T\\0format'\n"),
            "sent an answer that is no table",
            "copy it again",
        ),
        // The environment is empty, and the table is open already.
        (
            Some("#!/bin/sh\nprintf 'R\\000told: %s; %s' \"$HOME$HDF5_X\" \"$1\"\n"),
            concat!("told: ; ", env!("CARGO_PKG_VERSION")),
            "",
        ),
    ];
    for (script, what, remedy) in cases {
        let bake = with_reader(here, script);
        let output = unbusy(|| {
            Command::new(&bake)
                .args(["inspect", "half.h5"])
                .current_dir(here)
                .output()
        });
        let said = said(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains(what) && said.contains(remedy), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
    println!("5 readers");
}
