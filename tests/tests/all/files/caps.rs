//! Caps on what a file, an option and an output may be: each is refused in one sentence, in little
//! time, under a limit of memory.

use std::fs;
use std::io::Write;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::{Command, Output};
use std::time::Instant;

use tables::Fate;
use tests::files::{argument, bake_table_with};
use tests::program::{Line, fresh};

/// Runs `bake` or `fit` in `folder` under a limit of memory, KiB, and one of the length of files.
fn limited(folder: &Path, kib: u64, words: &(impl Line + ?Sized)) -> (Output, f64) {
    let words = words.words();
    let start = Instant::now();
    let output = Command::new("sh")
        .args(["-c", "ulimit -v $0 && exec \"$@\"", &kib.to_string()])
        .arg(fresh(&words[0]))
        .args(&words[1..])
        .current_dir(folder)
        .output()
        .expect("sh starts");
    (output, start.elapsed().as_secs_f64())
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Checks that a command is refused with `code` and a sentence that holds `what`.
#[track_caller]
fn refused(folder: &Path, words: &(impl Line + ?Sized), code: i32, what: &str) {
    let (output, seconds) = limited(folder, 2 << 20, words);
    let said = said(&output);
    let line = words.words().join(" ");
    println!("{line}: {seconds:.2} s: {}", said.trim());
    assert_eq!(output.status.code(), Some(code), "{line}\n{said}");
    assert!(said.contains(what), "{line}\n{said}");
    assert!(
        !said.contains("panicked") && seconds < 60.0,
        "{line}\n{said}"
    );
}

/// Writes the mesh of a cube corner to cell.obj.
#[track_caller]
fn design_a_cell(here: &Path) {
    let words = "bake design triangular -o cell.obj";
    refused(here, words, 0, "");
}

/// Computes the CRC-32 of a part of a PNG, bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 & 0_u32.wrapping_sub(crc & 1))
        })
    })
}

fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let body = [kind, data].concat();
    let length = (data.len() as u32).to_be_bytes();
    [&length[..], &body, &crc(&body).to_be_bytes()].concat()
}

/// A PNG of 16 x 16 pixels whose colour profile inflates to 2 GiB: zeros, deflated by python.
fn profile_bomb(folder: &Path) {
    // Two equal parts, between which the compressor forgets: the second may stand for all others.
    let script = "import sys, zlib\n\
        c = zlib.compressobj(9)\n\
        parts = [c.compress(bytes(1 << 20)) + c.flush(zlib.Z_FULL_FLUSH) for _ in range(2)]\n\
        open(sys.argv[1], 'wb').write(parts[0] + 2047 * parts[1] + c.flush())\n";
    let packed = folder.join("zeros");
    let status = Command::new("python3")
        .args(["-c", script])
        .arg(&packed)
        .status();
    assert!(status.expect("python3 starts").success());
    let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
    bytes.extend(chunk(b"IHDR", &[0, 0, 0, 16, 0, 0, 0, 16, 8, 0, 0, 0, 0]));
    let profile = [b"bomb\0\0".to_vec(), fs::read(&packed).unwrap()].concat();
    bytes.extend(chunk(b"iCCP", &profile));
    // 16 rows of a filter byte and 16 pixels, stored without compression.
    let rows = [0_u8; 16 * 17];
    let length = rows.len() as u16;
    let mut stored = vec![0x78, 0x01, 1];
    stored.extend(length.to_le_bytes());
    stored.extend((!length).to_le_bytes());
    stored.extend(rows);
    // Adler-32 of n zeros: the low half is 1, the high half n.
    stored.extend((u32::from(length) << 16 | 1).to_be_bytes());
    bytes.extend(chunk(b"IDAT", &stored));
    bytes.extend(chunk(b"IEND", &[]));
    fs::write(folder.join("bomb.png"), bytes).unwrap();
}

/// An EXR of 16 rows whose second offset is its first.
fn doubled(folder: &Path) {
    use exr::prelude::*;
    let path = folder.join("doubled.exr");
    let layer = Layer::new(
        (16, 16),
        LayerAttributes::default(),
        Encoding::UNCOMPRESSED,
        SpecificChannels::build()
            .with_channel("Y")
            .with_pixel_fn(|Vec2(x, y)| (((x + 16 * y) as f32),)),
    );
    Image::from_layer(layer).write().to_file(&path).unwrap();
    let mut bytes = fs::read(&path).unwrap();
    // The table of 16 offsets: ascending numbers of 8 bytes, the first of which is its own end.
    let word = |bytes: &[u8], at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    let table = (0..bytes.len() - 128)
        .find(|&at| word(&bytes, at) == at as u64 + 128)
        .expect("the table of offsets");
    let first = bytes[table..table + 8].to_vec();
    bytes[table + 8..table + 16].copy_from_slice(&first);
    fs::write(path, bytes).unwrap();
}

#[test]
fn photographs_cost_what_their_caps_say() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    profile_bomb(here);
    doubled(here);
    assert!(
        Command::new("mkfifo")
            .arg(here.join("pipe.png"))
            .status()
            .unwrap()
            .success()
    );
    refused(here, "fit mtf bomb.png", 1, "iCCP");
    refused(here, "fit mtf doubled.exr", 1, "there twice");
    refused(here, "fit mtf pipe.png", 1, "not a regular file");
    refused(here, "fit mtf /dev/zero", 1, "not a regular file");
    let estimate = "fit estimate pipe.png --table none.h5";
    refused(here, estimate, 1, "not a regular file");
    // 196 megapixels of four 16-bit channels would take 2.4 GB. The file could hold them.
    let mut header = b"\x89PNG\r\n\x1a\n".to_vec();
    let size = [14_000_u32.to_be_bytes(), 14_000_u32.to_be_bytes()].concat();
    header.extend(chunk(b"IHDR", &[&size[..], &[16, 6, 0, 0, 0]].concat()));
    header.extend(chunk(b"IDAT", &vec![0; 25_000_000]));
    fs::write(here.join("heavy.png"), header).unwrap();
    let line = "fit mtf heavy.png";
    refused(here, line, 1, "bytes in memory, above the limit");
}

/// Meshes at and beyond the caps: 1 GiB of memory is enough to refuse them, whatever they hold.
#[test]
#[ignore = "takes a minute: the largest files; `make test-kills` runs it"]
fn meshes_cost_what_their_caps_say() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let write = |name: &str, line: &mut dyn FnMut(u32) -> String, lines: u32| {
        let mut file = std::io::BufWriter::new(fs::File::create(here.join(name)).unwrap());
        for number in 0..lines {
            file.write_all(line(number).as_bytes()).unwrap();
        }
        file.flush().unwrap();
    };
    // The first mesh has the greatest numbers of vertices and faces that are read, and no cell in
    // them. The second has one face more.
    let most = 1 << 21;
    let mesh = |n: u32| match n {
        n if n < most => format!("v {n} {} 0.5\n", n % 7),
        n => {
            let corner = n - most;
            format!(
                "f {} {} {}\n",
                corner % most + 1,
                (corner + 1) % most + 1,
                (corner + 2) % most + 1
            )
        }
    };
    write("most.obj", &mut { mesh }, 2 * most);
    write("more.obj", &mut { mesh }, 2 * most + 1);
    // One face of ten million corners.
    fs::write(here.join("corners.obj"), {
        let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\nf");
        text.push_str(&" 1 2 3".repeat(3_400_000));
        text
    })
    .unwrap();
    let kib = 1 << 20;
    for (name, what) in [
        ("most.obj", "most.obj: "),
        ("more.obj", "more than the limit"),
        ("corners.obj", "more than the limit"),
    ] {
        let (output, seconds) = limited(here, kib, &format!("bake trace {name} -o x.h5"));
        let said = said(&output);
        println!("{name}: {seconds:.1} s: {}", said.trim());
        assert_eq!(output.status.code(), Some(1), "{name}\n{said}");
        assert!(
            said.contains(what) && !said.contains("memory allocation"),
            "{name}\n{said}"
        );
        assert!(seconds < 60.0, "{name}: {seconds} s");
    }
}

#[test]
fn numbers_beyond_the_field_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let options = "--method rays --rays 4096 --bins 16";
    let table = bake_table_with(here, "triangular", "0,20", "30", options);
    let trace = |option: &str, value: &str| {
        let words = format!("bake trace triangular.obj -o x.h5 {option} {value}");
        refused(here, &words, 2, option);
    };
    trace("--azimuth", "full:1e-9");
    trace("--tolerance", "1e-17");
    trace("--tolerance", "NaN");
    trace("--threads", "1000000");
    trace("--incidence", "0:89:1e-4");
    trace("--range", "1e300");
    let bins = "bake trace triangular.obj -o x.h5 --bins 4096 --incidence";
    let bins = |more: &str| format!("{bins} {more}");
    refused(here, &bins("0:45:1"), 2, "--bins 4096");
    refused(here, &bins("0:45:5 --method rays"), 2, "--bins 4096");
    let render = format!("fit render --source s.png --params r.json --table {table}");
    let place = "--distance 150 --incidence 0 -o x.png";
    for (option, value) in [
        ("--tangential-axis", "NaN"),
        ("--exposure", "1e300"),
        ("--ambient", "1e300"),
        ("--pixel-pitch", "5e-324"),
        ("--azimuth", "inf"),
    ] {
        let line = format!("{render} {place} {option} {value}");
        refused(here, &line, 2, option);
    }
    let predict = format!("fit predict r.json --table {table} --distance 1:1e5:1");
    refused(here, &format!("{predict} --incidence 0"), 2, "10000 values");
    let lines = vec!["550"; 20_000].join(",");
    let by_hand = format!("--c 0.2 --wavelength-nm {lines} --incidence 0");
    let wave = format!("fit predict --table {table} --distance 150 {by_hand}");
    refused(here, &wave, 2, "20000 wavelengths, above the limit");
    let photograph = argument("tests/captures/public_per_angle/source.exr");
    let pitch = format!("fit mtf {photograph} --pixel-pitch 1e300");
    refused(here, &pitch, 2, "--pixel-pitch");
    // A manifest, ranges and parameters of a simulation.
    fs::write(here.join("m.toml"), "[setup]\npixel_pitch_mm = 1e300\n").unwrap();
    let line = format!("fit estimate m.toml --table {table}");
    refused(here, &line, 1, "pixel_pitch_mm");
    let setup = format!("[setup]\npixel_pitch_mm = 0.1\nwavelength_nm = \"{lines}\"\n");
    fs::write(here.join("m.toml"), setup).unwrap();
    let line = format!("fit estimate m.toml --table {table}");
    refused(here, &line, 1, "has 20000 wavelengths");
    fs::write(
        here.join("r.toml"),
        "c_mm = { from = 1e-300, to = 1e300 }\n",
    )
    .unwrap();
    let study = format!("fit study --ranges r.toml --table {table} --campaigns 2");
    refused(here, &study, 1, "r.toml:1");
}

/// Tables at the caps: every verb that reads one ends under the limits that the reader has for
/// files of this length, and the same ones for its own work.
#[test]
#[ignore = "takes a minute: the largest files; `make test-kills` runs it"]
fn tables_at_the_caps_cost_what_their_caps_say() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let name = bake_table_with(here, "triangular-pair", "0,20", "30", "--bins 8");
    let honest = tables::read(&here.join(name)).unwrap();
    let mut numbers = 1_u64;
    let mut unit = move || {
        numbers = numbers
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (numbers >> 11) as f64 / (1_u64 << 53) as f64
    };
    // Triangles of one point reflection, all over the entrance, a few of which cover it.
    let mut triangles = |count: usize| {
        let path = &honest.exact.as_ref().unwrap().paths[0][0];
        let one = |_| {
            let [x, y, size] = [unit() - 0.5, unit() - 0.5, 1.0 / count as f64 * unit()];
            tables::Path {
                polygon: vec![[x, y], [x + size, y], [x, y + size]],
                matrix: [[-2.0, 0.0], [0.0, -2.0]],
                offset: [0.0; 2],
                ..path.clone()
            }
        };
        (0..count).map(one).collect::<Vec<_>>()
    };
    let mut of_paths = |mut table: tables::Table, count: usize| {
        let azimuths = table.axes.azimuth_deg.len();
        let exact = table.exact.as_mut().unwrap();
        exact.entrance_area = 1.0;
        for (direction, paths) in exact.paths.iter_mut().enumerate() {
            *paths = triangles(count);
            let eta: f64 = paths.iter().map(tables::Path::area).sum();
            let at = [direction / azimuths, direction % azimuths];
            table.retroreflected[at] = eta;
            let mut fate = table.fate.slice_mut(ndarray::s![at[0], at[1], ..]);
            fate.fill(0.0);
            fate[Fate::Retroreflected as usize] = eta;
            fate[Fate::Missed as usize] = 1.0 - eta;
        }
        table
    };
    let paths = of_paths(honest.clone(), 1 << 15);
    let pieces = of_paths(honest.clone(), 340);
    let mut directions = of_paths(honest.part(&[0; 1000], &[0; 100]), 1);
    directions.axes.incidence_deg = (0..1000).map(|k| f64::from(k) * 0.08).collect();
    directions.axes.azimuth_deg = (0..100).map(|k| f64::from(k) * 3.6).collect();
    let hand = "--c 0.2 --half-mirror 0.25 --mu 0.5";
    let predict = "fit predict --distance 150 --incidence 10 --azimuth 30";
    let render = "fit render --source s.png -o x.exr";
    image::GrayImage::from_fn(64, 64, |x, _| image::Luma([if x < 30 { 0 } else { 255 }]))
        .save(here.join("s.png"))
        .unwrap();
    let (mut runs, mut slowest) = (0, 0.0_f64);
    for (name, table) in [
        ("paths", paths),
        ("pieces", pieces),
        ("directions", directions),
    ] {
        let file = format!("{name}.h5");
        tables::write(&table, &here.join(&file)).unwrap();
        let own = |words: &str, more: &str| format!("{words} --table {file} {hand} {more}");
        let wave = "--wavelength-nm 550";
        let at = "--distance 150 --incidence 20 --azimuth 30";
        let commands = [
            format!("bake inspect {file}"),
            format!("bake verify {file}"),
            format!("bake compare {file} {file}"),
            own(predict, "--a 4.5"),
            own(predict, wave),
            own(render, &format!("{at} --a 4.5 --pixel-pitch 0.2")),
            own("fit explore -o x.html", "--a 4.5"),
            own("fit explore -o x.html", wave),
        ];
        // Images and pages of 32,768 paths cost a hundred times those of a sheet.
        let most = if name == "paths" { 5 } else { commands.len() };
        for line in commands.into_iter().take(most) {
            let (output, seconds) = limited(here, 2 << 20, &line);
            let told = said(&output);
            println!(
                "{line}: {:?}, {seconds:.2} s: {}",
                output.status.code(),
                told.trim()
            );
            assert!(
                matches!(output.status.code(), Some(0 | 1)),
                "{line}: {told}"
            );
            assert!(
                !told.contains("panicked") && seconds < 60.0,
                "{line}: {told}"
            );
            slowest = slowest.max(seconds);
            runs += 1;
        }
    }
    println!("{runs} runs, the slowest took {slowest:.1} s");
}

/// Numbers of a result that no sheet has.
#[test]
fn hostile_results_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let corpus = argument("fuzz/corpus/result/honest");
    let mut honest: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(corpus).unwrap()).unwrap();
    let table = bake_table_with(here, "triangular-pair", "0,20", "30", "--bins 16");
    // The result of this very table.
    let hash = tests::program::bake(here, &format!("verify {table} --json")).done();
    let hash: serde_json::Value = serde_json::from_str(&hash).unwrap();
    honest["table"]["content_hash"] = hash["content_hash"].clone();
    let predict = format!("fit predict r.json --table {table} --distance 150 --incidence 0");
    let write = |value: &serde_json::Value| {
        fs::write(here.join("r.json"), value.to_string()).unwrap();
    };
    write(&honest);
    refused(here, &predict, 0, "");
    let cases = [
        ("c_mm", serde_json::json!(-0.3)),
        ("c_mm", serde_json::json!(1e-308)),
        ("a_per_mm", serde_json::json!(0)),
        ("mu", serde_json::json!(1e300)),
        ("mu", serde_json::json!(-1)),
    ];
    for (key, value) in &cases {
        let mut hostile = honest.clone();
        hostile[*key]["value"] = value.clone();
        write(&hostile);
        refused(here, &predict, 1, &format!("r.json: `{key}` is"));
    }
    println!("{} results", cases.len());
}

#[test]
fn outputs_are_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let long = format!("{}.obj", "x".repeat(300));
    symlink(here.join("nowhere"), here.join("dead.obj")).unwrap();
    let design = |output: &str, what: &str| {
        let line = format!("bake design triangular -o {output}");
        refused(here, &line, 1, what);
    };
    design(
        "none/x.obj",
        "error: none/x.obj: there is no folder none; make it",
    );
    design(&long, "its folder takes no file");
    design("dead.obj", "is a link that leads nowhere");
    design_a_cell(here);
    let trace = "bake trace cell.obj -o";
    refused(here, &format!("{trace} -"), 1, "is no name of a file here");
    refused(
        here,
        &format!("{trace} cell.obj/x.h5"),
        1,
        "not a directory)",
    );
    fs::create_dir(here.join("closed.obj")).unwrap();
    refused(
        here,
        "bake trace closed.obj -o x.h5",
        1,
        "is a folder; name a mesh in it",
    );
    refused(
        here,
        "bake trace . -o x.h5",
        1,
        "is a folder; name a mesh in it",
    );
    fs::remove_dir(here.join("closed.obj")).unwrap();
    for name in ["x.obj", "x.h6", "x.h5.txt"] {
        refused(
            here,
            &format!("{trace} {name}"),
            1,
            "is no name of a table; let it end in .h5",
        );
    }
    let merge = "bake merge a.h5 b.h5 -o x.glb";
    refused(here, merge, 1, "is no name of a table");
    // Every writer of both programs reserves its outputs in one way.
    let place = "--sheet prism-0.1 --distance 300 --incidence 0";
    for line in [
        "bake trace cell.obj -o none/x.h5".into(),
        "bake datasheet cell.obj -o none/x.html".into(),
        format!("fit predict {place} --plot none/x.svg"),
        format!("fit compare {place} -o none/x.csv"),
        "fit explore --sheet prism-0.1 -o none/x.html".into(),
    ] {
        let said = ": there is no folder none; make it, or choose another output";
        refused(here, &line, 1, said);
    }
    let left: Vec<String> = fs::read_dir(here)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|name| name != "cell.obj" && name != "dead.obj")
        .collect();
    assert!(left.is_empty(), "{left:?}");

    // The rights of a file that is replaced stay, whatever the umask.
    for mode in [0o600, 0o666, 0o640] {
        fs::set_permissions(here.join("cell.obj"), fs::Permissions::from_mode(mode)).unwrap();
        design_a_cell(here);
        let found = fs::metadata(here.join("cell.obj"))
            .unwrap()
            .permissions()
            .mode();
        assert_eq!(found & 0o777, mode);
    }
    // A limit of the shell on the length of files: blocks of 512 bytes or 1 KiB.
    let run = Command::new("sh")
        .args(["-c", "ulimit -f 1 && exec \"$@\"", "sh"])
        .arg(fresh("bake"))
        .args(["trace", "cell.obj", "-o", "cell.h5"])
        .current_dir(here)
        .output()
        .unwrap();
    assert_eq!(run.status.code(), Some(1), "{}", said(&run));
    assert!(said(&run).contains("`ulimit -f` allows"), "{}", said(&run));
}

/// What has the name of a save and is none is refused before the work, and stays.
#[test]
fn saves_are_files() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    design_a_cell(here);
    let (precious, save) = (here.join("precious"), here.join("cell.h5.resume"));
    fs::write(&precious, "mine").unwrap();
    let trace = "bake trace cell.obj -o cell.h5";
    let makers: [&dyn Fn() -> bool; 4] = [
        &|| symlink(&precious, &save).is_ok(),
        &|| symlink(here.join("nowhere"), &save).is_ok(),
        &|| {
            Command::new("mkfifo")
                .arg(&save)
                .status()
                .unwrap()
                .success()
        },
        &|| fs::create_dir(&save).is_ok(),
    ];
    let mut runs = 0;
    for make in makers {
        assert!(make());
        let kind = fs::symlink_metadata(&save).unwrap().file_type();
        for more in ["", "--resume"] {
            let what = "cell.h5.resume: is not a regular file";
            refused(here, &format!("{trace} {more}"), 1, what);
            assert_eq!(fs::symlink_metadata(&save).unwrap().file_type(), kind);
            assert!(!here.join("cell.h5").exists());
            runs += 1;
        }
        if kind.is_dir() {
            fs::remove_dir(&save).unwrap();
        } else {
            fs::remove_file(&save).unwrap();
        }
    }
    assert_eq!(fs::read_to_string(&precious).unwrap(), "mine");
    println!("{runs} runs");
}

/// Names in strangers' files do not steer the terminal, and no line of them looks like one of the
/// program's.
#[test]
fn control_characters_reach_no_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    design_a_cell(here);
    let text = fs::read_to_string(here.join("cell.obj")).unwrap();
    let named = "\u{1b}]0;owned\u{7}\u{202e}name";
    // A forged line of its own, in the ways in which one can begin.
    let lines = [
        "x\nerror: forged",
        "x\rerror: forged",
        "x\u{2028}error: forged",
    ];
    let mut tried = 0;
    let mut runs = |line: &str, file: &str, code: Option<i32>| {
        let named = |word| if word == "FILE" { file } else { word };
        let words: Vec<&str> = line.split(' ').map(named).collect();
        let (output, _) = limited(here, 2 << 20, &words);
        let all = [output.stdout, output.stderr].concat();
        let all = String::from_utf8_lossy(&all).into_owned();
        let ended = output.status.code();
        assert!(code.is_none_or(|code| ended == Some(code)), "{line}: {all}");
        let steers = ['\u{1b}', '\u{7}', '\u{202e}', '\r', '\u{2028}'];
        assert!(!all.contains(steers), "{line}: {all:?}");
        assert!(
            !all.lines().any(|line| line.starts_with("error: forged")),
            "{line}: {all}"
        );
        tried += 1;
        all
    };
    for (file, text) in [
        ("bad\u{1b}[2J.obj".to_owned(), "f 1 2 3\n".to_owned()),
        ("line.obj".to_owned(), format!("{text}f {named} 2 3\n")),
        (format!("{}.obj", lines[0]), "f 1 2 3\n".to_owned()),
    ] {
        fs::write(here.join(&file), text).unwrap();
        runs("bake trace FILE -o x.h5", &file, Some(1));
    }
    // A design, of a mesh with a hostile name; a folder of photographs; keys and texts of TOML.
    runs("bake trace cell.obj --incidence 0 -o named.h5", "", Some(0));
    let table = tables::read(&here.join("named.h5")).unwrap();
    fs::create_dir(here.join("photographs")).unwrap();
    for (k, line) in lines.into_iter().chain([named]).enumerate() {
        let mut table = table.clone();
        let from = &mut table.provenance;
        (from.design, from.generator) = (line.to_string(), line.to_string());
        (from.mesh_hash, from.edge_length_unit) = (line.to_string(), line.to_string());
        from.options = line.into();
        let file = format!("named{k}.h5");
        tables::write(&table, &here.join(&file)).unwrap();
        // Options of a name that no bake knows are refused.
        for (verb, code) in [("inspect", 0), ("verify", 1)] {
            runs(&format!("bake {verb} FILE"), &file, Some(code));
        }
        runs("bake verify FILE --mesh cell.obj", &file, None);
        fs::write(here.join("photographs").join(format!("{line}.png")), "none").unwrap();
        let key = format!("[setup]\n{} = 1\n", serde_json::json!(line));
        fs::write(here.join("m.toml"), key).unwrap();
        runs("fit estimate m.toml --table x.h5", "", Some(1));
    }
    let rows = runs("fit mtf photographs", "", Some(1));
    assert!(rows.contains("x\\nerror: forged"), "{rows}");
    println!("{tried} runs");
}
