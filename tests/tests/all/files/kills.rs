//! Programs that are killed while they work: every output is the old one or the new one, whole, and
//! nothing is left behind after the next run.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Instant;

use tests::files::argument;
use tests::program::{fresh, run};

/// Command line that writes files, and what it writes.
pub(crate) struct Case {
    /// Name of the folder in which it runs.
    pub(crate) name: &'static str,
    /// Program, verb and arguments. The inputs lie in the folder above.
    pub(crate) words: Vec<String>,
    /// Files or folders that the command writes.
    outputs: Vec<&'static str>,
    /// Rule for an output that is neither as it was nor as an undisturbed run makes it.
    between: Between,
}

/// State of an output that is neither the old one nor the undisturbed one.
#[derive(Clone, Copy)]
enum Between {
    /// The state does not occur.
    Never,
    /// The file holds times, and differs from run to run. It ends as its format does.
    Timed,
    /// The folder has no manifest.
    NoManifest,
}

/// Campaign of two small photographs. The edge of a captured one is tilted by `tilt` degrees.
fn parameters(tilt: u32) -> String {
    let capture = |distance: u32| {
        format!(
            "[[capture]]\nfloating_distance_mm = {distance}\nincidence_deg = 20\n\
            azimuth_deg = 30\nedge_normal_deg = {tilt}\n"
        )
    };
    format!(
        "seed = 7\n[camera]\nwidth = 128\nheight = 96\n[truth]\nkernel = \"eq1\"\n\
        lobe = \"radial\"\nrefractive_index = 1.49\npair = true\na = 4\nc = 0.24\nmu = 0.5\n\
        {}{}",
        capture(150),
        capture(300)
    )
}

/// Commands that write files: the name of a case, the rule for its outputs, these, and the command.
const COMMANDS: &str = "
design | never | a.obj | bake design triangular-pair -o a.obj
design-glb | never | a.glb | bake design triangular-pair -o a.glb
trace | never | t.h5 | bake trace ../pair.obj -o t.h5 EXACT
trace-rays | never | t.h5 | bake trace ../pair.obj -o t.h5 RAYS --save-every 0
merge | never | m.h5 | bake merge ../one.h5 ../two.h5 -o m.h5
inspect | never | s.svg | bake inspect ../pair.h5 --plot s.svg
bake-study | timed | s.csv s.svg | bake study ../pair.obj --incidence 0 --rays 4096 --repeats 1 --csv s.csv --plot s.svg
bake-manual | no manifest | man | bake manual man
fit-manual | no manifest | man | fit manual man
mtf | never | c.csv c.svg | fit mtf EDGE --pixel-pitch 0.05 -o c.csv --plot c.svg
estimate | timed | r.json m.svg r.html | fit estimate ../campaign/captures.toml --table ../pair.h5 TERMS -o r.json --plot m.svg --report r.html
predict | never | p.csv p.svg | fit predict FITTED --distance 150 --incidence 20 -o p.csv --plot p.svg
render | never | a.exr | fit render --source EDGE --params ../result.json --table ../pair.h5 --distance 300 --incidence 20 -o a.exr
export | never | m.gltf | fit export FITTED --to gltf --distance 300 -o m.gltf
simulate | never | new | fit simulate ../params.toml -o new
simulate-over | no manifest | old | fit simulate ../params.toml -o old --force
fit-study | timed | t.csv t.svg | fit study --ranges ../ranges.toml --table ../pair.h5 --campaigns 1 --csv t.csv --plot t.svg
";

/// Makes the inputs of all cases in a folder, and returns the cases.
pub(crate) fn cases(here: &Path) -> Vec<Case> {
    fs::write(here.join("params.toml"), parameters(5)).unwrap();
    fs::write(here.join("other.toml"), parameters(8)).unwrap();
    fs::write(
        here.join("ranges.toml"),
        "photographs = { from = 2, to = 3 }\n",
    )
    .unwrap();
    let edge = argument("tests/edges/camera_5deg.exr");
    let exact = "--refractive-index 1.49 --incidence 0:45:5 --azimuth 30";
    let rays = "--refractive-index 1.49 --method rays --rays 65536 --bins 32";
    let terms = "--kernel eq1 --lobe radial --shared a,c,mu --loss mtf";
    for line in [
        "bake design triangular-pair -o pair.obj".to_owned(),
        format!("bake trace pair.obj -o pair.h5 {exact}"),
        format!("bake trace pair.obj -o one.h5 {rays} --shard 1/2"),
        format!("bake trace pair.obj -o two.h5 {rays} --shard 2/2"),
        "fit simulate params.toml -o campaign".to_owned(),
        format!("fit estimate campaign/captures.toml --table pair.h5 {terms} -o result.json"),
    ] {
        let run = of_line(here, &line);
        assert_eq!(run.code, Some(0), "{line}\n{}", run.err);
    }
    let case = |line: &'static str| {
        let parts: Vec<&str> = line.split(" | ").collect();
        let mut command = parts[3].replace("FITTED", "../result.json --table ../pair.h5");
        for (name, options) in [
            ("EXACT", exact),
            ("RAYS", rays),
            ("TERMS", terms),
            ("EDGE", &edge),
        ] {
            command = command.replace(name, options);
        }
        Case {
            name: parts[0],
            words: command.split_whitespace().map(str::to_owned).collect(),
            outputs: parts[2].split(' ').collect(),
            between: match parts[1] {
                "never" => Between::Never,
                "timed" => Between::Timed,
                _ => Between::NoManifest,
            },
        }
    };
    COMMANDS.trim().lines().map(case).collect()
}

fn of_line(here: &Path, line: &str) -> tests::program::Run {
    let words: Vec<&str> = line.split_whitespace().collect();
    run(words[0], here, &words[1..])
}

/// Content of a file, or of all files of a folder; empty if there is nothing.
type Content = BTreeMap<String, Vec<u8>>;

fn content(path: &Path) -> Content {
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    if path.is_dir() {
        let entries = fs::read_dir(path)
            .unwrap()
            .map(|entry| entry.unwrap().path());
        return entries
            .map(|file| (name(&file), fs::read(&file).unwrap()))
            .collect();
    }
    let file = fs::read(path).ok().map(|bytes| (name(path), bytes));
    file.into_iter().collect()
}

/// Makes a file or a folder hold this content.
fn restore(path: &Path, content: &Content) {
    if path.is_dir() {
        fs::remove_dir_all(path).unwrap();
    }
    if path.extension().is_some() {
        fs::write(path, &content.values().next().unwrap()[..]).unwrap();
    } else if !content.is_empty() {
        fs::create_dir(path).unwrap();
        for (name, bytes) in content {
            fs::write(path.join(name), bytes).unwrap();
        }
    }
}

/// Returns whether a file ends as whole files of its format do.
fn ends_well(path: &Path, found: &Content) -> bool {
    let Some(bytes) = found.values().next() else {
        return false;
    };
    let text = String::from_utf8_lossy(bytes);
    match path.extension().and_then(|end| end.to_str()) {
        Some("json") => serde_json::from_str::<serde_json::Value>(&text).is_ok(),
        Some("svg") => text.trim_end().ends_with("</svg>"),
        Some("html") => text.trim_end().ends_with("</html>"),
        Some("csv") => {
            let commas = |line: &str| line.matches(',').count();
            let head = text.lines().next().map_or(0, commas);
            text.ends_with('\n') && head > 0 && text.lines().all(|line| commas(line) == head)
        }
        _ => false,
    }
}

/// Random numbers in [0, 1) that follow from a seed (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / 2_f64.powi(64)
    }
}

/// Ends of the killed runs of a case.
#[derive(Default)]
struct Ends {
    /// Runs that ended before the kill.
    done: u32,
    /// Killed runs that left all outputs as they were.
    old: u32,
    /// Killed runs that left all outputs as an undisturbed run makes them.
    new: u32,
    /// Killed runs that left some outputs old and some new, or files that hold times.
    other: u32,
}

/// Kills a command `kills` times, at times spread over its duration, and checks its outputs after
/// each kill, and its folder after an undisturbed run.
fn kill(here: &Path, case: &Case, kills: u32) -> Ends {
    let folder = here.join(case.name);
    fs::create_dir(&folder).unwrap();
    let words: Vec<&str> = case.words.iter().map(String::as_str).collect();
    let undisturbed = || {
        let start = Instant::now();
        let run = run(words[0], &folder, &words[1..]);
        assert_eq!(run.code, Some(0), "{}\n{}", run.line, run.err);
        start.elapsed()
    };
    let paths: Vec<_> = case.outputs.iter().map(|name| folder.join(name)).collect();
    let old: Vec<Content> = paths.iter().map(|path| earlier(here, path)).collect();
    let reset = || {
        for (path, old) in paths.iter().zip(&old) {
            restore(path, old);
        }
    };
    let once = || {
        reset();
        undisturbed()
    };
    // The shortest of a few runs: a kill that comes too late kills nothing.
    let lasts = (0..4).map(|_| once()).min().unwrap();
    let new: Vec<Content> = paths.iter().map(|path| content(path)).collect();
    let files = names(&folder);

    let seed = case.name.bytes().fold(1_u64, |seed, byte| {
        seed.wrapping_mul(31).wrapping_add(u64::from(byte))
    });
    let mut random = Random(seed);
    let mut ends = Ends::default();
    for _ in 0..kills {
        reset();
        let mut child = Command::new(fresh(words[0]))
            .args(&words[1..])
            .current_dir(&folder)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let after = lasts.mul_f64(1.05 * random.next());
        sleep(after);
        child.kill().unwrap();
        let is_done = child.wait().unwrap().code().is_some();
        let mut states = Vec::new();
        for ((path, old), new) in paths.iter().zip(&old).zip(&new) {
            let found = content(path);
            let name = path.display();
            let is_whole = match case.between {
                _ if found == *old || found == *new => true,
                Between::Never => false,
                Between::Timed => ends_well(path, &found),
                Between::NoManifest => {
                    // Each file is the old one, the new one, or a partial one, which the next run
                    // removes. The manifest is not there.
                    let of = |(name, bytes): (&String, &Vec<u8>)| {
                        let is_partial = name.starts_with(".airr-") && name.ends_with(".partial");
                        is_partial || [old, new].iter().any(|all| all.get(name) == Some(bytes))
                    };
                    !found.contains_key("captures.toml") && found.iter().all(of)
                }
            };
            assert!(is_whole, "{name}: cut short by a kill after {after:?}");
            states.push((found == *old, found == *new));
        }
        ends.done += u32::from(is_done);
        match (
            is_done,
            states.iter().all(|s| s.0),
            states.iter().all(|s| s.1),
        ) {
            (true, _, _) => {}
            (_, true, _) => ends.old += 1,
            (_, _, true) => ends.new += 1,
            _ => ends.other += 1,
        }
    }
    once();
    assert_eq!(names(&folder), files, "{}: something is left", case.name);
    ends
}

/// Returns what an output holds before a run: a text, an older campaign, or nothing.
fn earlier(here: &Path, path: &Path) -> Content {
    if path.extension().is_some() {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        return Content::from([(name, b"what was there before\n".to_vec())]);
    }
    if path.ends_with("old") {
        let folder = here.join("earlier");
        if !folder.exists() {
            let run = of_line(here, "fit simulate other.toml -o earlier");
            assert_eq!(run.code, Some(0), "{}", run.err);
        }
        return content(&folder);
    }
    Content::new()
}

/// Returns the paths of all that lies in a folder and in folders within it, sorted.
fn names(folder: &Path) -> Vec<PathBuf> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            names.extend(self::names(&path));
        }
        names.push(path);
    }
    names.sort();
    names
}

#[test]
#[ignore = "takes minutes: a hundred kills of every command; `make test-kills` runs it"]
fn hundred_kills_leave_whole_files() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let (mut tried, mut killed) = (0, 0);
    for case in cases(here) {
        let (name, line) = (case.name, case.words[..2].join(" "));
        let Ends {
            done,
            old,
            new,
            other,
        } = kill(here, &case, 100);
        println!("{name} ({line}): {old} old, {new} new, {other} other, {done} done before");
        tried += 100;
        killed += old + new + other;
    }
    println!("{tried} kills, {killed} while the programs ran");
    assert!(
        2 * killed > tried,
        "most kills came too late: {killed} of {tried}"
    );
}
