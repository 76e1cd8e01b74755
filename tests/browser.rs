//! The report as one page, in a real browser: everything is drawn, fits, and answers to the pointer, and nothing is loaded.
//! Without Chromium there is nothing to see, unless `RAYLANES_REQUIRE_BROWSER` says that there must be.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use raylanes::study::{self, Options};
use raylanes::tracer::SceneSource;

const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// `CHROME`, or the first of [`NAMES`] in the path.
fn browser() -> Option<PathBuf> {
    let folders = env::var_os("PATH").unwrap_or_default();
    let named = env::split_paths(&folders).flat_map(|folder| NAMES.map(|name| folder.join(name)));
    env::var_os("CHROME").map(PathBuf::from).or_else(|| named.into_iter().find(|file| file.is_file()))
}

/// What a script appended to the page writes into it, in a window that wide: `ok`, or what is wrong.
fn verdict(browser: &Path, page: &Path, width: u32) -> String {
    let profile = tempfile::tempdir().unwrap();
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"])
        .args(["--disable-background-networking", "--disable-component-update", "--virtual-time-budget=10000"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("--window-size={width},800"))
        .args(["--dump-dom", &format!("file://{}", page.display())])
        .output()
        .unwrap();
    let dom = String::from_utf8_lossy(&output.stdout);
    let verdict = dom.split_once("<pre id=\"verdict\">").and_then(|(_, rest)| rest.split_once("</pre>"));
    verdict.map_or_else(
        || panic!("no verdict at {width} pixels: {}", String::from_utf8_lossy(&output.stderr)),
        |(text, _)| text.to_owned(),
    )
}

#[test]
fn the_page_is_drawn_fits_and_answers_to_the_pointer() {
    let Some(browser) = browser() else {
        assert!(env::var_os("RAYLANES_REQUIRE_BROWSER").is_none(), "no browser in the path nor in CHROME");
        println!("skipped: no browser in the path nor in CHROME");
        return;
    };
    let scenes = vec![SceneSource::parse("room:small").unwrap()];
    let options = Options { scenes, quick: true, large: false, seed: 1, peers: false };
    let record = study::run(&options).unwrap();
    let folder = tempfile::tempdir().unwrap();
    study::write(&record, folder.path()).unwrap();
    let report = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    // First, so that no error comes before it.
    let (head, body) = report.split_once("<body>").unwrap();
    let watch = "<script>window.errors = []; addEventListener('error', event => errors.push(event.message));
        addEventListener('securitypolicyviolation', event => errors.push(`refused: ${event.blockedURI}`));</script>";
    let body = body.replace("</body>", &format!("<script>{}</script></body>", include_str!("browser.js")));
    let page = folder.path().join("tested.html");
    for width in [1280, 400] {
        std::fs::write(&page, format!("{head}<body>{watch}{body}")).unwrap();
        assert_eq!(verdict(&browser, &page, width), "ok", "{width} pixels wide");
    }
    // The test sees what it is there to see.
    for (from, to, complaint) in [
        ("</main>", "<img src=\"elsewhere.png\"></main>", "loaded or refused"),
        ("</main>", "<div style=\"width: 3000px\">wide</div></main>", "wider than the window"),
        ("tip.hidden = false;", "", "no tip"),
        ("<svg role", "<svg style=\"display: none\" role", "drawings without a size"),
        ("\"use strict\";", "\"use strict\"; nowhere();", "error"),
    ] {
        std::fs::write(&page, format!("{head}<body>{watch}{body}").replacen(from, to, 1)).unwrap();
        let verdict = verdict(&browser, &page, 1280);
        assert!(verdict.contains(complaint), "{complaint}: {verdict}");
    }
}
