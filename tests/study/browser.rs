//! Tests the pages of a report in a real browser: all charts are drawn and fit, tooltips appear under the pointer, and
//! nothing is loaded. Without Chromium the test is skipped, or fails if `RAYLANES_REQUIRE_BROWSER` is set.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use raylanes::study;

use crate::RECORD;

const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// The browser: the file that `CHROME` names, or the first of [`NAMES`] in the path.
fn browser() -> Option<PathBuf> {
    let folders = env::var_os("PATH").unwrap_or_default();
    let named = env::split_paths(&folders).flat_map(|folder| NAMES.map(|name| folder.join(name)));
    env::var_os("CHROME").map(PathBuf::from).or_else(|| named.into_iter().find(|file| file.is_file()))
}

/// The errors that the script in the page finds in a window of this width, or `ok`.
fn verdict(browser: &Path, page: &str, width: u32) -> String {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, content: &str| std::fs::write(folder.path().join(name), content).unwrap();
    write("page.html", page);
    // A browser window may have a minimum width. A frame has none.
    write(
        "frame.html",
        &format!(
            "<iframe src=\"page.html\" style=\"width: {width}px; height: 800px; border: 0\"></iframe>
             <pre id=\"verdict\"></pre>
             <script>onmessage = event => document.getElementById('verdict').textContent = event.data</script>"
        ),
    );
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"])
        .args(["--disable-background-networking", "--disable-component-update", "--virtual-time-budget=10000"])
        .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
        .args(["--window-size=1400,900", "--dump-dom"])
        .arg(format!("file://{}", folder.path().join("frame.html").display()))
        .output()
        .unwrap();
    let dom = String::from_utf8_lossy(&output.stdout);
    let verdict = dom.split_once("<pre id=\"verdict\">").and_then(|(_, rest)| rest.split_once("</pre>"));
    match verdict {
        Some((text, _)) if !text.is_empty() => text.to_owned(),
        _ => panic!("no verdict at {width} pixels: {}", String::from_utf8_lossy(&output.stderr)),
    }
}

#[test]
fn the_page_is_drawn_fits_the_window_and_shows_tooltips() {
    let Some(browser) = browser() else {
        assert!(env::var_os("RAYLANES_REQUIRE_BROWSER").is_none(), "no browser in the path or in CHROME");
        println!("skipped: no browser in the path or in CHROME");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    study::write(&RECORD, folder.path()).unwrap();
    // This script comes first in the page, so that it sees every error.
    let watch = "<script>window.errors = []; addEventListener('error', event => errors.push(event.message));
        addEventListener('securitypolicyviolation', event => errors.push(`refused: ${event.blockedURI}`));</script>";
    let watched = |file: &str| {
        let page = std::fs::read_to_string(folder.path().join(file)).unwrap();
        let (head, body) = page.split_once("<body>").unwrap();
        let body = body.replace("</body>", &format!("<script>{}</script></body>", include_str!("browser.js")));
        format!("{head}<body>{watch}{body}")
    };
    let [answer, page] = ["report.html", "appendix.html"].map(watched);
    for width in [1280, 400] {
        assert_eq!(verdict(&browser, &answer, width), "ok", "{width} pixels wide");
        assert_eq!(verdict(&browser, &page, width), "ok", "{width} pixels wide");
    }
    // Each of these changes breaks the page, and the test must notice it.
    for (from, to, complaint) in [
        ("</main>", "<img src=\"elsewhere.png\"></main>", "loaded or refused"),
        ("</main>", "<div style=\"width: 3000px\">wide</div></main>", "wider than the window"),
        ("tip.hidden = false;", "", "no tip"),
        ("opacity: .15", "", "other series are not dimmed"),
        ("<svg role", "<svg style=\"display: none\" role", "drawings without a size"),
        ("\"use strict\";", "\"use strict\"; nowhere();", "nowhere is not defined"),
    ] {
        let verdict = verdict(&browser, &page.replacen(from, to, 1), 1280);
        assert!(verdict.contains(complaint), "{complaint}: {verdict}");
    }
}
