//! Errors in arguments, names and outputs: one line, found before any work.

use crate::*;

#[test]
fn errors_in_arguments_have_no_usage() {
    fails(&["trace", "room", "--mode", "singel"], &["invalid value 'singel'", "scalar, single, packet", "'single'"]);
    fails(&["trace", "room", "--size", "a\n\nUsage: b"], &[r"'a\n\nUsage: b'", "expected WIDTHxHEIGHT"]);
    fails(&["render"], &["required arguments", "--out <OUT.png>", "<SCENE>"]);
    fails(&["trace", "room", &"-x".repeat(10_000)], &["unexpected argument"]);
    assert!(succeeds(&["--help"]).contains("Usage: ") && succeeds(&["--version"]).starts_with("raylanes "));
    assert!(succeeds(&["trace", "--help"]).contains("--any-hit"));
}

#[test]
fn a_name_is_shortened_and_cannot_disturb_the_terminal() {
    let folder = Folder::new("names");
    let name = format!("a\u{202e}b\n\u{1b}[2J{}.obj", "x".repeat(180));
    let file = folder.file(&name, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 1\n");
    let arguments = ["trace", text(&file), "--size", "8x8", "--repeat", "1"];
    let output = raylanes(&arguments);
    let (printed, error) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    for text in [&printed, &error] {
        assert!(!text.contains(['\u{202e}', '\u{1b}']) && text.lines().all(|line| line.len() < 400), "{text}");
    }
    assert!(error.contains(r"note: a\u{202e}b\n\u{1b}[2J") && error.contains("xxx…xxx"), "{error}");
    let missing = folder.0.join("y\u{2066}".repeat(20) + &"z".repeat(150));
    fails(&["trace", "room:small", "--rays", text(&missing)], &["cannot read ", "…zzz", "No such file"]);
    fails(&["trace", &"\u{200f}word".repeat(1000)], &[r"\u{200f}word", "not a scene"]);
    fails(&["render", "room:small", "-o", "o", "--kernel", &"k".repeat(5000)], &["kk…kk", "no such triangle kernel"]);
}

#[test]
fn thousands_of_remarks_are_a_few_lines() {
    let folder = Folder::new("remarks");
    let quadric = |number| format!("[[quadric]]\nname = 'q{number}'\nsphere = {{ radius = 1 }}\n");
    let quadrics: String = (0..3000).map(quadric).collect();
    let scene = folder.file("many.toml", quadrics + "[[instance]]\nof = 'q7'\n");
    let output = raylanes(&["trace", text(&scene), "--size", "8x8", "--repeat", "1"]);
    assert_eq!(error_lines(&output.stderr), ["note: many.toml: never placed: \"q0\" (and 2998 more)"]);
    let degenerate = folder.file("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 1\n");
    let mesh = |number| format!("[[mesh]]\nname = 'm{number}'\nfile = '{}'\n", text(&degenerate));
    let meshes: String = (0..100).map(mesh).collect();
    let scene = folder.file("meshes.toml", meshes + "[[instance]]\nof = 'm0'\n");
    let output = raylanes(&["trace", text(&scene), "--size", "8x8", "--repeat", "1"]);
    let lines = error_lines(&output.stderr);
    assert_eq!((lines.len(), &*lines[20]), (21, "note: meshes.toml: and 81 more remarks"));
}

#[test]
fn a_key_with_too_many_parts_has_its_line() {
    let folder = Folder::new("recursion");
    for (content, line) in [
        (format!("[camera]\neye = [0, 0, 0]\n\n{} = 1\nx = 2\n", ["a"; 3000].join(".")), 4),
        (format!("# comment\n[{}]\nb = 1\n", ["a"; 3000].join(".")), 2),
        (format!("\na = {}{}\n", "[".repeat(9999), "]".repeat(9999)), 2),
    ] {
        let file = folder.file("deep.toml", content);
        fails(&["trace", text(&file)], &[&format!("deep.toml:{line}: "), "recur"]);
    }
}

#[test]
fn an_input_is_not_written_over() {
    let folder = Folder::new("overwriting");
    let mtl = "newmtl m\nKd 1 0 0\n";
    let obj = "mtllib x.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    let toml = "[[mesh]]\nname = 'x'\nfile = 'x.obj'\n[[instance]]\nof = 'x'\n";
    let rays = [0; 64];
    let contents =
        [("x.mtl", mtl.as_bytes()), ("x.obj", obj.as_bytes()), ("x.rays", &rays), ("x.toml", toml.as_bytes())];
    for (name, content) in contents {
        folder.file(name, content);
    }
    fs::hard_link(folder.0.join("x.mtl"), folder.0.join("hard")).unwrap();
    let mut outputs = vec!["x.mtl", "x.obj", "x.toml", "hard"];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("x.obj", folder.0.join("soft")).unwrap();
        outputs.push("soft");
    }
    let refused = "it is also an input";
    for output in outputs {
        let name = format!("cannot write {output}: ");
        fails_in(&folder.0, &["render", "x.toml", "--size", "8x8", "-o", output], &[&name, refused]);
        fails_in(&folder.0, &["trace", "x.toml", "--size", "8x8", "--hits", output], &[&name, refused]);
    }
    fails_in(&folder.0, &["trace", "x.obj", "--rays", "x.rays", "--hits", "x.rays"], &["x.rays", refused]);
    // The second picture is an output too.
    fs::hard_link(folder.0.join("x.obj"), folder.0.join("y-compare")).unwrap();
    let compare = ["render", "x.obj", "--size", "8x8", "-o", "y", "--compare", "cramer"];
    fails_in(&folder.0, &compare, &["y-compare", refused]);
    fs::create_dir(folder.0.join("out")).unwrap();
    fs::hard_link(folder.0.join("x.mtl"), folder.0.join("out/report.md")).unwrap();
    fails_in(&folder.0, &["study", "x.obj", "--quick", "--out", "out"], &["report.md", refused]);
    for (name, content) in contents {
        assert_eq!(fs::read(folder.0.join(name)).unwrap(), content, "{name}");
    }
    assert!(!folder.0.join("y").exists());
}

#[test]
fn cheap_errors_come_before_the_work() {
    let folder = Folder::new("early");
    let begin = Instant::now();
    let bad = folder.file("bad.obj", "v 0 0 0\n");
    fs::create_dir(folder.0.join("directory")).unwrap();
    for (arguments, words) in [
        (&["study", text(&bad)][..], &["bad.obj", "no triangles"][..]),
        (&["study", "room", text(&folder.0.join("missing.toml"))], &["missing.toml", "No such file"]),
        (&["study", "--out", text(&bad.join("below"))], &["below", "Not a directory"]),
        (&["trace", "room:1e7", "--hits", "no/such/hits"], &["no/such/hits", "there is no directory"]),
        (&["trace", "room:1e7", "--hits", text(&folder.0.join("directory"))], &["directory"]),
        (&["render", "room:1e7", "-o", "no/such.png"], &["no/such.png", "there is no directory"]),
        (&["trace", "room:1e7", "--rays", "missing.rays"], &["missing.rays", "No such file"]),
        (&["trace", "room:1e7", "--kernel", "nonsense"], &["nonsense", "no such triangle kernel"]),
    ] {
        fails_in(&folder.0, arguments, words);
    }
    assert_eq!(folder.names(), ["bad.obj", "directory"]);
    assert!(begin.elapsed() < Duration::from_secs(20), "something was measured");
}

/// A picture is right, or one line says why there is none.
#[test]
fn a_view_without_a_picture_is_an_error() {
    let folder = Folder::new("views");
    let mesh = |name: &str, size: f32| {
        let half = size / 2.0;
        folder.file(name, format!("v -{half:e} 0 0\nv {half:e} 0 0\nv 0 {half:e} 0\nf 1 2 3\n"))
    };
    let (ordinary, tiny, huge) = (mesh("one.obj", 2.0), mesh("tiny.obj", 1e-20), mesh("huge.obj", 1e19));
    let trace = |scene: &'static str| ["trace", scene, "--size", "8x8", "--repeat", "1"];
    let fails_from = |eye: &str, look_at: &str, words: &[&str]| {
        fails(&[&trace("room:small")[..], &["--eye", eye, "--look-at", look_at]].concat(), words);
    };
    fails_from("1,2,3", "1,2,3", &["room:small", "no direction", "[1, 2, 3]"]);
    fails_from("1e38,0,0", "0,0,0", &["eye", "1e38"]);
    fails_from("0,0,0", "0,3e38,0", &["look-at", "3e38"]);
    fails_from("1e9,0,0", "0,0,0", &["times the scene's size away"]);
    for scene in [&tiny, &huge] {
        fails(&["trace", text(scene), "--size", "8x8"], &["the size of the scene", "scale the scene"]);
        // Rays of a file have their own directions and are traced.
        let rays = folder.0.join("one.rays");
        write_rays(&rays, &[Ray::new(Vec3::Z, Vec3::NEG_Z)]).unwrap();
        succeeds(&["trace", text(scene), "--rays", text(&rays), "--repeat", "1"]);
    }
    // A narrower field of view shows the triangle larger.
    let hits = |fov: &str| {
        let arguments = ["trace", text(&ordinary), "--size", "64x64", "--repeat", "1", "--json", "--fov", fov];
        let json: serde_json::Value = serde_json::from_str(&succeeds(&arguments)).unwrap();
        json["hits"].as_u64().unwrap()
    };
    assert!(hits("20") > 2 * hits("40"), "{} and {} hits", hits("20"), hits("40"));
}

#[cfg(unix)]
#[test]
fn a_study_refuses_a_scene_that_can_be_read_only_once() {
    let folder = Folder::new("once");
    std::os::unix::fs::symlink("/dev/null", folder.0.join("x.obj")).unwrap();
    fails_in(&folder.0, &["study", "x.obj", "--quick", "--out", "out"], &["x.obj", "not a pipe"]);
}
