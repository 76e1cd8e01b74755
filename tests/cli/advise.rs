//! `raylanes advise`: what it prints, the plan that `trace` follows, the pictures and the scene that it writes.

use crate::*;

/// Little time and few rays, and a need that so few rays can show to be met.
const QUICK: [&str; 4] = ["--budget", "0.5", "--max-wrong", "2000"];

fn advise(arguments: &[&str]) -> String {
    succeeds(&[&["advise"], arguments, &QUICK[..]].concat())
}

#[test]
fn advice_is_one_screen_that_ends_with_what_to_use() {
    let text = advise(&["room:small"]);
    let last = text.lines().last().unwrap();
    assert!(last.starts_with("Use: --kernel triangle/") && last.contains(" --mode "), "{text}");
    assert!(text.lines().count() < 50 && text.lines().all(|line| line.chars().count() <= 112), "{text}");
    for words in ["room:small: 1", "speed", "wrong", "A mode never changes a hit; another kernel may.", "confirms"] {
        // Long lines are broken.
        let whole = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(whole.contains(words), "{words} is not in\n{text}");
    }
}

#[test]
fn trace_and_render_follow_a_plan() {
    let folder = Folder::new("plan");
    let [plan, other] = ["plan.toml", "other.toml"].map(|name| folder.0.join(name));
    let json = advise(&["gallery", "--save", text(&plan), "--json"]);
    let advice: serde_json::Value = serde_json::from_str(&json).unwrap();
    let field = |name: &str| advice[name].as_str().unwrap_or_else(|| panic!("{name}: {json}")).to_owned();
    assert!(advice["reasons"].as_array().unwrap().len() > 3, "{json}");
    let traced = |arguments: &[&str]| {
        let printed =
            succeeds(&[&["trace", "gallery", "--size", "32x32", "--repeat", "1", "--json"], arguments].concat());
        let traced: serde_json::Value = serde_json::from_str(&printed).unwrap();
        ["kernel", "mode", "checksum"].map(|name| traced[name].as_str().unwrap().to_owned())
    };
    let by_plan = traced(&["--plan", text(&plan)]);
    let [kernel, quadric_kernel, mode] = ["kernel", "quadric_kernel", "mode"].map(field);
    assert_eq!(by_plan[..2], [kernel.clone(), mode.clone()]);
    assert_eq!(by_plan, traced(&["--kernel", &kernel, "--quadric-kernel", &quadric_kernel, "--mode", &mode]));
    // Another plan gives other hits, so the first one was really followed.
    fs::write(&other, "kernel = 'cramer'\nquadric_kernel = 'naive'\nmode = 'single'\n").unwrap();
    let [.., checksum] = traced(&["--plan", text(&other)]);
    assert_ne!(checksum, by_plan[2]);
    let [.., same] = traced(&["--kernel", "cramer", "--quadric-kernel", "naive", "--mode", "single"]);
    assert_eq!(checksum, same);
    let picture = folder.0.join("plan.png");
    succeeds(&["render", "gallery", "--size", "8x8", "-o", text(&picture), "--plan", text(&plan)]);
    fails(&["trace", "gallery", "--plan", text(&plan), "--kernel", "woop"], &["--plan", "cannot be used with"]);
    fails(&["trace", "gallery", "--plan", "no.toml"], &["cannot read no.toml"]);
    let bad = folder.file("bad.toml", "kernel = 'woop'\nquadric_kernel = 'round'\nmode = 'auto'\n");
    fails(&["render", "gallery", "-o", "o.png", "--plan", text(&bad)], &["bad.toml:2: \"round\"", "no such quadric"]);
}

#[test]
fn the_picture_of_wrong_pixels_is_written_and_counted() {
    let folder = Folder::new("wrong");
    let picture = folder.0.join("wrong.png");
    let text = advise(&["sphere:1000", "-o", text(&picture)]);
    assert!(text.lines().last().unwrap().contains("of 1048576 pixels, "), "{text}");
    assert!(image::open(&picture).is_ok());
}

#[test]
fn the_rays_of_a_file_are_those_that_count() {
    let folder = Folder::new("file-rays");
    let file = folder.0.join("down.rays");
    let rays: Vec<_> = (0..20_000)
        .map(|number| {
            let [x, z] = [number % 100, number / 100].map(|step| step as f32 * 0.01 - 0.5);
            Ray::new(Vec3::new(x, 4.0, z), Vec3::new(0.1 * z, -1.0, 0.1 * x))
        })
        .collect();
    write_rays(&file, &rays).unwrap();
    for any_hit in [&[][..], &["--any-hit"]] {
        let json = advise(&[&["room:small", "--json", "--rays", text(&file)], any_hit].concat());
        let advice: serde_json::Value = serde_json::from_str(&json).unwrap();
        let kernel = &advice["shapes"][0]["kernels"][0];
        assert!((1..=10_000).contains(&kernel["rays"].as_u64().unwrap()), "half of the rays: {kernel}");
        assert!((1..=10_000).contains(&advice["scored"]["rays"].as_u64().unwrap()), "the other half: {json}");
    }
    let nowhere: Vec<_> = rays.iter().map(|ray| Ray::new(ray.origin + Vec3::Y * 1e6, Vec3::Y)).collect();
    write_rays(&file, &nowhere[..9]).unwrap();
    fails(&["advise", "terrain:1000", "--rays", text(&file)], &["terrain:1000", "no ray hits anything"]);
    let mut broken = rays[..9].to_vec();
    broken.iter_mut().for_each(|ray| ray.origin.x = f32::NAN);
    write_rays(&file, &broken).unwrap();
    fails(&["advise", "room:small", "--rays", text(&file)], &["no ray hits anything"]);
    fs::write(&file, [0; 33]).unwrap();
    fails(&["advise", "room:small", "--rays", text(&file)], &["down.rays"]);
    write_rays(&file, &[]).unwrap();
    fails(&["advise", "room:small", "--rays", text(&file)], &["down.rays"]);
}

#[test]
fn the_simpler_scene_is_written_and_can_be_traced() {
    let folder = Folder::new("simpler");
    let scene = folder.0.join("simple.toml");
    advise(&["sphere:1e5", "--apply", text(&scene)]);
    let traced = succeeds(&["trace", text(&scene), "--size", "32x32", "--repeat", "1"]);
    assert!(traced.contains("0 triangles, 1 quadrics"), "{traced}");
    let none = folder.0.join("none.toml");
    fails(&[&["advise", "gallery", "--apply", text(&none)], &QUICK[..]].concat(), &["--apply", "nothing to write"]);
    assert_eq!(folder.names(), ["simple.toml"]);
}

#[test]
fn wrong_questions_are_errors() {
    fails(&["advise"], &["required arguments", "<SCENE>"]);
    fails(&["advise", "rooom"], &["rooom", "not a scene"]);
    fails(&["advise", "room", "--max-wrong=-1"], &["--max-wrong", "expected 0 to 1000000"]);
    fails(&["advise", "room", "--max-error", "0"], &["--max-error", "expected 1e-7 to 1"]);
    fails(&["advise", "room", "--budget", "nan"], &["--budget", "expected 0.1 to 3600 seconds"]);
    fails(&["advise", "room", "--any-hit"], &["--rays"]);
    fails(&["advise", "room", "--apply", "out.obj"], &["--apply", "ends in .toml"]);
    fails(&["advise", "room", "--save", "no/such/folder/plan.toml"], &["no/such/folder"]);
}
