//! Runs the program: what it prints and writes, that an error is one line and exit code 2, and what an interrupt does.

mod advise;
mod errors;
#[cfg(target_os = "linux")]
mod interrupted;
#[cfg(unix)]
mod mutations;
#[cfg(unix)]
#[cfg(unix)]
mod resources;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use glam::Vec3;
use raylanes::geom::{Hit, Ray};
use raylanes::kernels::triangle::Cramer;
use raylanes::tracer::{LoadedScene, Mode, Scene, SceneSource, block_order, checksum, trace, write_rays};

/// A temporary folder; it is removed at the end of the test.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("raylanes-cli-{test}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// The names in it, sorted.
    fn names(&self) -> Vec<String> {
        names(&self.0)
    }

    fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        fs::write(&path, content).unwrap();
        path
    }
}

fn names(folder: &Path) -> Vec<String> {
    let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(name).collect();
    names.sort();
    names
}

impl Drop for Folder {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).unwrap();
    }
}

fn raylanes(arguments: &[&str]) -> Output {
    program().args(arguments).output().unwrap()
}

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_raylanes"))
}

/// The lines of standard error, without the note about a slow build.
fn error_lines(stderr: &[u8]) -> Vec<String> {
    let text = String::from_utf8(stderr.to_vec()).unwrap();
    text.lines().filter(|line| !line.starts_with("note: built without")).map(String::from).collect()
}

fn succeeds(arguments: &[&str]) -> String {
    let output = raylanes(arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments:?}: {error}");
    String::from_utf8(output.stdout).unwrap()
}

/// Checks that the program fails: exit code 2, nothing on standard output, and one line on standard error that contains
/// all `words`.
fn fails(arguments: &[&str], words: &[&str]) {
    fails_in(Path::new("."), arguments, words);
}

/// [`fails`] in another current folder.
fn fails_in(folder: &Path, arguments: &[&str], words: &[&str]) {
    let output = program().args(arguments).current_dir(folder).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    assert_eq!(error.lines().count(), 1, "{arguments:?}: {error}");
    for word in words {
        assert!(error.contains(word), "{arguments:?}: {word} is not in: {error}");
    }
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// The four words of a hit in a hit file.
fn four_words(hit: &Hit<f32>) -> [u32; 4] {
    let [t, u, v, primitive, _] = hit.to_bits();
    [t, u, v, primitive]
}

#[test]
fn list_shows_kernels_and_claims() {
    let list = succeeds(&["list"]);
    for id in ["aabb/padded", "triangle/cramer", "instance/subtract_first/triangle/moller_trumbore", "conservative"] {
        assert!(list.contains(id), "{id} is not in\n{list}");
    }
}

#[test]
fn a_wrong_argument_is_an_error_that_says_what_was_expected() {
    fails(&["trace", "rooom"], &["rooom", "room", "terrain", "sphere", "OBJ"]);
    fails(&["trace", "terrain:7"], &["terrain", "7"]);
    fails(&["trace", "room:small", "--kernel", "triangle/woo"], &["triangle/woo", "triangle/cramer"]);
    fails(&["study", "nowhere.obj", "--quick"], &["nowhere.obj"]);
    for arguments in [
        &["trace", "room:small", "--size", "0x5"][..],
        &["trace", "room:small", "--size", "99999x99999"],
        &["trace", "room:small", "--mode", "warp"],
        &["trace", "room:small", "--repeat", "0"],
        &["trace", "room:small", "--threads", "1000000"],
        &["trace", "room:small", "--eye", "1,2,nan", "--look-at", "0,0,0"],
        &["render", "room:small"],
        &["paint"],
    ] {
        fails(arguments, &["raylanes: "]);
    }
}

#[cfg(not(feature = "peers"))]
#[test]
fn a_build_without_peers_says_how_to_build_with_them() {
    fails(&["study", "--peers"], &["--peers", "cargo run --release --features peers"]);
}

/// Another build needs cargo. What goes wrong with it is said before anything is measured.
#[cfg(all(unix, target_arch = "x86_64"))]
#[test]
fn a_build_that_cannot_be_made_is_an_error_that_says_why() {
    let folder = Folder::new("builds");
    let cargo =
        folder.file("cargo", "#!/bin/sh\necho 'warning: first' >&2\necho 'error: no such level' >&2\nexit 101\n");
    fs::set_permissions(&cargo, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    for (cargo, expected) in [
        (None, "--build: start the study with cargo: cargo run --release -- study --build ..."),
        (Some("/nowhere/cargo"), "cannot start /nowhere/cargo: No such file or directory"),
        (Some(text(&cargo)), "--build: cargo cannot build for x86-64-v3: error: no such level"),
    ] {
        let mut program = program();
        program.args(["study", "room:small", "--quick", "--build", "v3", "--out", "out"]).current_dir(&folder.0);
        program.env_remove("CARGO").env("CARGO_MANIFEST_DIR", &folder.0);
        program.envs(cargo.map(|cargo| ("CARGO", cargo)));
        let output = program.output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), said.trim_end()), (Some(2), &*format!("raylanes: {expected}")));
        assert!(!folder.0.join("out").exists(), "a folder was left behind");
    }
    fails(&["study", "--build", "v5"], &["v5", "v3"]);
}

#[test]
fn an_error_in_a_mesh_names_file_line_and_value() {
    let folder = Folder::new("meshes");
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let ply = "ply\nformat ascii 1.0\nelement vertex 1000000000000000000\nproperty float x\nproperty float y\n\
               property float z\nelement face 1\nproperty list int int vertex_index\nend_header\n"
        .to_owned();
    for (name, content, words) in [
        ("nan.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", &["nan.obj:2", "nan"][..]),
        ("word.obj", "v 0 0 zero\n", &["word.obj:1", "zero"]),
        ("range.obj", &format!("{triangle}f 1 2 3\nf 1 2 9\n"), &["range.obj:5", "9"]),
        ("face.obj", &format!("{triangle}f 1 x 3\n"), &["face.obj:4", "f 1 x 3"]),
        ("none.obj", triangle, &["none.obj", "no triangles"]),
        ("empty.obj", "", &["empty.obj"]),
        ("large.ply", &format!("{ply}1e39 0 0\n"), &["large.ply:10", "infinite", "1e39 0 0"]),
        ("short.ply", &ply, &["short.ply", "vertex 0", "1000000000000000000"]),
        ("nan.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 nan 0\n", &["nan.stl:4", "vertex 0 nan 0"]),
    ] {
        let file = folder.file(name, content);
        fails(&["trace", text(&file)], words);
        fails(&["render", text(&file), "-o", text(&folder.0.join("out.png"))], words);
        assert!(!folder.0.join("out.png").exists());
    }
    fails(&["trace", text(&folder.0.join("missing.obj"))], &["missing.obj", "No such file"]);
    fs::create_dir(folder.0.join("folder.obj")).unwrap();
    fails(&["trace", text(&folder.0.join("folder.obj"))], &["folder.obj"]);
}

#[test]
fn an_incomplete_or_empty_ray_file_is_an_error() {
    let folder = Folder::new("rays");
    let cut = folder.file("cut.rays", [0; 100]);
    fails(&["trace", "room:small", "--rays", text(&cut)], &["cut.rays", "100"]);
    let empty = folder.file("empty.rays", []);
    fails(&["trace", "room:small", "--rays", text(&empty)], &["empty.rays", "no rays"]);
    fails(&["trace", "room:small", "--rays", text(&folder.0.join("missing"))], &["missing"]);
}

#[test]
fn a_hit_file_holds_the_hits_in_the_order_of_the_ray_file() {
    let folder = Folder::new("hits");
    let source = SceneSource::parse("room:small").unwrap();
    let LoadedScene { world, view, .. } = source.load().unwrap();
    let mut rays = view.camera(40, 30).rays(40, 30);
    rays.truncate(1003);
    rays[5].dir = Vec3::NAN;
    rays[6] = Ray::INACTIVE;
    let expected = trace(&Scene::<Cramer<f32>>::new(world), &rays, Mode::Scalar);

    let (ray_file, hit_file) = (folder.0.join("in.rays"), folder.0.join("out.hits"));
    write_rays(&ray_file, &rays).unwrap();
    for (mode, threads) in [("scalar", "1"), ("single", "2"), ("packet", "2"), ("auto", "0")] {
        let json = succeeds(
            &[
                &["trace", "room:small", "--rays", text(&ray_file), "--hits", text(&hit_file), "--json"][..],
                &["--kernel", "cramer", "--mode", mode, "--threads", threads, "--repeat", "1"],
            ]
            .concat(),
        );
        let result: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(result["checksum"], format!("{:016x}", checksum(&expected)));
        assert_eq!(result["rays"], 1003);
        assert_eq!(result["hits"], expected.iter().filter(|hit| hit.mask).count());
        assert_eq!(result["kernel"], "triangle/cramer");
        for key in ["mrays_per_second", "build_seconds", "bytes_per_triangle"] {
            assert!(result[key].as_f64().unwrap() > 0.0, "{key}: {result}");
        }
        assert!(result["threads"].as_u64().unwrap() >= 1);
        assert_eq!(result["mode"], mode, "the mode that was asked for, even if auto chooses another");

        let bytes = fs::read(&hit_file).unwrap();
        let words = bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect::<Vec<_>>();
        assert_eq!(words.as_chunks::<4>().0, expected.iter().map(four_words).collect::<Vec<_>>());
    }
}

/// A scene of two instances of a closed mesh, the second one mirrored, and a sphere, traced from outside and inside.
#[test]
fn a_wide_hit_file_also_holds_instance_side_and_normal() {
    let folder = Folder::new("wide");
    let file = folder.file(
        "x.toml",
        "[[mesh]]\nname = 'm'\ngenerator = 'sphere:1e3'\n[[quadric]]\nname = 'q'\nsphere = { radius = 1 }\n\
         [[instance]]\nof = 'm'\n[[instance]]\nof = 'q'\ntransform = [{ translate = [3, 0, 0] }]\n\
         [[instance]]\nof = 'm'\ntransform = [{ scale = [-1, 2, 1] }, { translate = [-3, 0, 0] }]\n",
    );
    let LoadedScene { world, view, .. } = SceneSource::parse(text(&file)).unwrap().load().unwrap();
    let scene = Scene::<Cramer<f32>>::new(world);
    let mut rays = view.camera(40, 30).rays(40, 30);
    // From inside the sphere, and two that miss.
    rays.extend((0..40).map(|step| Ray::new(Vec3::X * 3.0, Vec3::new(1.0, step as f32 - 20.0, 3.0))));
    rays.extend([Ray::INACTIVE, Ray { dir: Vec3::NAN, ..rays[0] }]);
    let expected = trace(&scene, &rays, Mode::Scalar);
    let (ray_file, hit_file) = (folder.0.join("in.rays"), folder.0.join("out.hits"));
    write_rays(&ray_file, &rays).unwrap();
    let common = ["trace", text(&file), "--kernel", "cramer", "--repeat", "1", "--hits", text(&hit_file)];
    let wide = |more: &[&str]| -> Vec<[u32; 9]> {
        succeeds(&[&common[..], &["--hit-format", "wide"], more].concat());
        let bytes = fs::read(&hit_file).unwrap();
        let words = bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect::<Vec<_>>();
        words.as_chunks().0.to_vec()
    };
    let records = wide(&["--rays", text(&ray_file)]);
    assert_eq!(records.len(), rays.len());
    let mut seen = std::collections::HashMap::new();
    for ((record, hit), ray) in records.iter().zip(&expected).zip(&rays) {
        assert_eq!(record[..5], hit.to_bits());
        if !hit.mask {
            assert_eq!(record[1..], [0, 0, u32::MAX, u32::MAX, u32::MAX, 0, 0, 0]);
            continue;
        }
        let normal = Vec3::from([6, 7, 8].map(|word: usize| f32::from_bits(record[word])));
        assert_eq!(normal, scene.surface(ray, hit).normal);
        assert!(normal.is_normalized());
        assert_eq!(record[5], u32::from(normal.dot(ray.dir) < 0.0));
        *seen.entry((hit.instance, record[5])).or_insert(0) += 1;
    }
    // From outside: the front, but the back where a mirror turns the triangles over. From inside the back.
    for side in [(0, 1), (1, 1), (1, 0), (2, 0)] {
        assert!(seen[&side] > 20, "{side:?}: {seen:?}");
    }
    assert_eq!(seen.len(), 4, "{seen:?}");
    // The hits of a picture are row by row.
    let picture = wide(&["--size", "40x30"]);
    for (record, pixel) in records.iter().zip(block_order(40, 30)) {
        assert_eq!(picture[pixel as usize], *record);
    }
    let narrow = |more: &[&str]| {
        succeeds(&[&common[..], &["--rays", text(&ray_file)], more].concat());
        fs::read(&hit_file).unwrap()
    };
    assert_eq!(narrow(&[]), narrow(&["--hit-format", "narrow"]));
    fails(&[&common[..], &["--hit-format", "wide", "--any-hit"]].concat(), &["--hit-format wide", "--any-hit"]);
    fails(&["trace", text(&file), "--hit-format", "wide"], &["--hits"]);
    fails(&[&common[..], &["--hit-format", "broad"]].concat(), &["broad", "narrow", "wide"]);
}

#[test]
fn the_default_is_an_exact_kernel_and_mode_auto() {
    let traced = |arguments: &[&str]| -> serde_json::Value {
        let common = ["trace", "sphere:small", "--size", "32x32", "--repeat", "1", "--json"];
        serde_json::from_str(&succeeds(&[&common, arguments].concat())).unwrap()
    };
    let result = traced(&[]);
    assert_eq!((&result["kernel"], &result["mode"]), (&"triangle/exact".into(), &"auto".into()));
    assert_eq!(result["checksum"], traced(&["--kernel", "triangle/exact", "--mode", "scalar"])["checksum"]);
    // The text has the same facts as JSON.
    let text = succeeds(&["trace", "sphere:small", "--size", "32x32", "--repeat", "1"]);
    for word in ["built in", "MB", "kernel triangle/exact, mode auto"] {
        assert!(text.contains(word), "{text}");
    }
}

#[test]
fn a_hit_file_of_a_picture_is_row_by_row() {
    let folder = Folder::new("rows");
    let hit_file = folder.0.join("picture.hits");
    // A sphere in the middle: the corners of the picture miss, its middle hits.
    succeeds(&["trace", "sphere:small", "--size", "50x30", "--hits", text(&hit_file), "--repeat", "1"]);
    let bytes = fs::read(&hit_file).unwrap();
    assert_eq!(bytes.len(), 50 * 30 * 16);
    let hit = |x: usize, y: usize| bytes[(y * 50 + x) * 16 + 12..][..4] != [0xff; 4];
    assert!(hit(25, 15) && !hit(0, 0) && !hit(49, 0) && !hit(0, 29) && !hit(49, 29));
    for y in 0..30 {
        let row: Vec<_> = (0..50).map(|x| hit(x, y)).collect();
        let edges = row.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!(edges == 0 || edges == 2, "the hits of row {y} are not consecutive: {row:?}");
    }
}

#[test]
fn render_writes_every_shade_in_the_requested_size() {
    let folder = Folder::new("pictures");
    for shade in ["lambert", "normals", "depth", "primitives", "instances", "ambient-occlusion"] {
        let out = folder.0.join(format!("{shade}.png"));
        succeeds(&["render", "room:small", "--size", "37x21", "--shade", shade, "-o", text(&out)]);
        let picture = image::open(&out).unwrap().to_rgb8();
        assert_eq!(picture.dimensions(), (37, 21));
        let first = picture.get_pixel(0, 0);
        // Even the one colour of an instance is darker where the surface is seen at an angle.
        assert!(picture.pixels().any(|pixel| pixel != first), "{shade} shows nothing");
    }
    let same = |mode: &str, threads: &str| {
        let out = folder.0.join("mode.png");
        succeeds(&["render", "room:small", "--size", "37x21", "--mode", mode, "--threads", threads, "-o", text(&out)]);
        fs::read(out).unwrap()
    };
    let scalar = same("scalar", "1");
    for (mode, threads) in [("single", "2"), ("packet", "2"), ("auto", "0")] {
        assert!(same(mode, threads) == scalar, "{mode}");
    }
}

#[test]
fn compare_counts_and_marks_the_pixels_where_two_kernels_differ() {
    let folder = Folder::new("compare");
    let (out, marked) = (folder.0.join("out.png"), folder.0.join("out-compare.png"));
    let compare = |kernel: &str, other: &str| {
        let size = ["--size", "64x64", "--kernel", kernel, "--compare", other];
        let printed = succeeds(&[&["render", "sphere:small", "-o", text(&out)][..], &size].concat());
        let count: usize = printed.split(' ').next().unwrap().parse().unwrap();
        assert!(printed.contains("of 4096 pixels differ") && printed.contains("out-compare.png"), "{printed}");
        let picture = image::open(&marked).unwrap().to_rgb8();
        let coloured = picture.pixels().filter(|pixel| pixel.0.iter().any(|&byte| byte != pixel.0[0])).count();
        assert_eq!(coloured, count, "the number of marked pixels is the number printed");
        printed
    };
    assert!(compare("woop", "woop").starts_with("0 of") && compare("woop", "woop").contains("On 0 more pixels"));
    assert!(!compare("woop", "baldwin_weber").contains("On 0 more pixels"), "no t differs between two methods");
    for (kernel, other) in [("nonsense", "woop"), ("woop", "nonsense"), ("woop", "aabb/padded"), ("naive", "woop")] {
        let arguments = ["render", "sphere:small", "-o", "never.png", "--kernel", kernel, "--compare", other];
        fails(&arguments, &["kernel: expected one of", "triangle/woop"]);
    }
}

#[test]
fn a_failed_write_is_an_error_and_leaves_nothing_behind() {
    let folder = Folder::new("unwritable");
    let nowhere = folder.0.join("no/such/folder/out.png");
    fails(&["render", "room:small", "--size", "8x8", "-o", text(&nowhere)], &["out.png"]);
    let file = folder.file("file", "kept");
    fails(&["study", "room:small", "--quick", "--out", text(&file.join("below"))], &["below"]);
    assert_eq!(fs::read_to_string(&file).unwrap(), "kept");
    assert_eq!(fs::read_dir(&folder.0).unwrap().count(), 1, "something was left behind");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_an_error() {
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_raylanes")).arg("list").stdout(Stdio::from(full)).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8(output.stderr).unwrap().contains("No space left"));
}

#[test]
fn closing_standard_output_early_is_no_error() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_raylanes"))
        .arg("list")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_record_goes_to_a_new_dated_folder() {
    let folder = Folder::new("record");
    // `CLICOLOR_FORCE` asks for colours even in a pipe.
    let mut program = program();
    let output = program.args(["study", "--quick", "--record", "first"]).current_dir(&folder.0);
    let output = output.env("CLICOLOR_FORCE", "1").env_remove("NO_COLOR").output().unwrap();
    assert_eq!((output.status.code(), error_lines(&output.stderr)), (Some(0), vec![]));
    let [record] = &names(&folder.0.join("reports"))[..] else { panic!("{:?}", names(&folder.0.join("reports"))) };
    let date = record.strip_suffix("-first").unwrap();
    assert!(date.len() == 10 && date.split('-').all(|part| part.parse::<u32>().is_ok()), "{date}");
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(printed.contains("\x1b[31m"), "{printed}");
    assert!(printed.lines().last().unwrap().starts_with(&format!("Written to reports/{record}: ")), "{printed}");
    let written = names(&folder.0.join("reports").join(record));
    for file in ["results.json", "report.md", "appendix.md", "on-scenes.svg", "speed-accuracy.svg", "scaling.svg"] {
        assert!(written.iter().any(|name| name == file), "{file}: {written:?}");
    }
    assert!(written.iter().all(|name| !name.starts_with('.')), "{written:?}");

    let first = ["study", "--quick", "--record", "first"];
    fails_in(&folder.0, &first, &[record, "exists", "never edited"]);
    assert_eq!((names(&folder.0.join("reports")).len(), folder.names()), (1, vec!["reports".to_owned()]));
}

#[test]
fn no_color_makes_the_table_plain_text() {
    let folder = Folder::new("plain");
    let mut program = program();
    let output = program.args(["study", "room:small", "--quick", "--out", "out"]).current_dir(&folder.0);
    let output = output.env("NO_COLOR", "1").env("CLICOLOR_FORCE", "1").output().unwrap();
    assert_eq!((output.status.code(), error_lines(&output.stderr)), (Some(0), vec![]));
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(!printed.contains('\x1b') && printed.contains("\nWritten to out: report.html"), "{printed}");
    assert!(names(&folder.0.join("out")).iter().any(|name| name == "results.json"));
}

#[test]
fn an_impossible_record_is_refused_before_the_study_starts() {
    let folder = Folder::new("refused");
    for name in ["", ".hidden", "a/b", "..", "a b", "ä"] {
        let mut program = program();
        let output = program.args(["study", "--quick", "--record", name]).current_dir(&folder.0).output().unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{name}: {error}");
        assert!(error.contains(&format!("'{name}'")) && error.contains("expected letters"), "{error}");
    }
    let both = raylanes(&["study", "--record", "a", "--out", "b"]);
    assert!(both.status.code() == Some(2) && String::from_utf8(both.stderr).unwrap().contains("--out"));
    let begin = Instant::now();
    fails_in(&folder.0, &["study", "--quick", "--record", &"x".repeat(300)], &["xxx", "too long"]);
    assert!(folder.names().is_empty());
    folder.file("reports", "a file");
    fails_in(&folder.0, &["study", "--quick", "--record", "a"], &["reports", "-a", "Not a directory"]);
    assert_eq!(folder.names(), ["reports"]);
    assert!(begin.elapsed() < Duration::from_secs(5), "the study was started");
}

/// The command that a study starts in processes of its own is not for users, but its errors are errors too.
#[test]
fn the_process_that_times_kernels_writes_lines_of_json() {
    let with = |rounds: &'static str| {
        [
            "time-kernels",
            "--seed",
            "1",
            "--rounds",
            rounds,
            "--picture",
            "16",
            "--scene-rounds",
            "1",
            "--",
            "sphere:1e3",
        ]
    };
    fails(&with("0"), &["--rounds", "0"]);
    fails(&["time-kernels", "--rounds", "1"], &["--seed"]);
    assert!(!succeeds(&["--help"]).contains("time-kernels"));
    let lines = succeeds(&with("2"));
    let lines: Vec<serde_json::Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    // Three rounds of single kernels, two of scenes: the first of each does not count.
    let shares: Vec<_> = lines[..5].iter().map(|line| line["done"].as_f64().unwrap()).collect();
    assert_eq!((lines.len(), shares[2], shares[4]), (6, 0.5, 1.0));
    let times = lines[5]["times"].as_array().unwrap();
    let named =
        |part: &str| -> Vec<_> { times.iter().filter(|job| job["name"].as_str().unwrap().contains(part)).collect() };
    let cramer: Vec<_> = named("triangle/cramer,");
    assert_eq!(cramer.len(), 6, "three widths on one thread and on two");
    assert!(cramer.iter().all(|job| job["checksum"] == cramer[0]["checksum"]));
    let scene = named("sphere:1e3, ");
    assert!(scene.len() >= 4 * 13 && scene.len() % 4 == 0, "every triangle kernel traces four sets of rays");
    for job in times {
        let rounds = if scene.contains(&job) { 1 } else { 2 };
        assert_eq!(job["ns"].as_array().unwrap().len(), rounds, "{job}");
    }
}
