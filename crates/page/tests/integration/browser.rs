//! The page in a real browser. Skipped, with a message, where there is none.

use std::time::{Duration, Instant};

use crate::bench::Bench;
use crate::chromium::Chromium;

/// The most that the page may load, bytes.
const MOST_BYTES: f64 = 300e3;

/// A number that changes with what the canvas of a panel shows.
fn sum_of(panel: &str) -> String {
    format!(
        "(() => {{ const shown = document.querySelector('.{panel} canvas'), copy = document.createElement('canvas');
        copy.width = copy.height = 64; const context = copy.getContext('2d');
        context.drawImage(shown, 0, 0, 64, 64);
        return context.getImageData(0, 0, 64, 64).data.reduce((sum, value, i) => (sum * 31 + value) % 1e9, 0); }})()"
    )
}

const IS_LIVE: &str = "document.querySelector('#state').textContent === 'Live'";

/// Starts a browser with these options and opens the page. `None` if no browser is installed.
fn opened(options: &[&str]) -> Option<(Chromium, Bench)> {
    let mut browser = Chromium::start(options)?;
    let bench = Bench::start();
    browser.open(&bench.page.url());
    browser.wait_until(IS_LIVE);
    Some((browser, bench))
}

#[test]
fn the_map_moves_and_the_surface_turns() {
    let Some((mut browser, _bench)) = opened(&[]) else { return };
    let bytes = "performance.getEntries().reduce((sum, entry) => sum + (entry.encodedBodySize || 0), 0)";
    let bytes = browser.value(bytes).as_f64().unwrap();
    assert!(bytes > 20e3 && bytes < MOST_BYTES, "the page has {bytes} bytes");
    for panel in ["camera", "map"] {
        let first = browser.value(&sum_of(panel));
        browser.wait_until(&format!("{} !== {first}", sum_of(panel)));
    }
    // While paused nothing moves but what the user turns.
    browser.press(" ");
    browser.wait_until("document.querySelector('#state').textContent === 'Paused'");
    browser.value("new Promise(done => setTimeout(done, 300))");
    let still = browser.value(&sum_of("surface"));
    browser.value("new Promise(done => setTimeout(done, 300))");
    assert_eq!(browser.value(&sum_of("surface")), still, "the paused surface moves");
    browser.drag(".surface canvas", [60.0, 20.0]);
    browser.wait_until(&format!("{} !== {still}", sum_of("surface")));
    browser.press(" ");
    browser.wait_until(IS_LIVE);
    assert!(browser.page_errors.is_empty(), "{:?}", browser.page_errors);
}

#[test]
fn exposure_and_focus_are_below_the_image() {
    let Some((mut browser, _bench)) = opened(&[]) else { return };
    let shown = "document.querySelector('.panel.camera .bar').textContent";
    browser.wait_until(&format!(
        "/^mean level [1-9]\\d* of 255, \\d+\\.\\d % saturated, focus \\d+ % of the best$/.test({shown})"
    ));
}

#[test]
fn keys_record_and_a_refusal_is_shown() {
    let Some((mut browser, bench)) = opened(&[]) else { return };
    browser.press("r");
    browser.wait_until("document.querySelector('#recording').textContent.includes('touch.mcap')");
    browser.press("r");
    browser.wait_until("document.querySelector('#recording').textContent === ''");
    *bench.actions.refusal.lock().unwrap() = Some("the disk is full".into());
    browser.value("document.querySelector('#record').click()");
    browser.wait_until("document.querySelector('#events').textContent.includes('the disk is full')");
}

#[test]
fn a_new_zero_is_logged() {
    let Some((mut browser, _bench)) = opened(&[]) else { return };
    browser.press("z");
    browser.wait_until("document.querySelector('#events').textContent.includes('finger: re-zeroed at frame ')");
    browser.wait_until("document.querySelector('.health').textContent.length > 0");
}

#[test]
fn a_reload_and_a_lost_server_are_survived() {
    let Some((mut browser, mut bench)) = opened(&[]) else { return };
    browser.call("Page.reload", &serde_json::json!({}));
    browser.wait_until(IS_LIVE);
    bench.restart(|| browser.wait_until("document.querySelector('#state').textContent === 'Connection lost'"));
    browser.wait_until(IS_LIVE);
}

#[test]
fn nothing_is_cut_off_on_a_phone_or_in_the_dark() {
    let Some(mut browser) = Chromium::start(&[]) else { return };
    let bench = Bench::start();
    browser.resize(390, 844, "dark");
    browser.open(&bench.page.url());
    browser.wait_until(IS_LIVE);
    for (width, theme) in [(390, "dark"), (390, "light"), (1366, "light"), (1366, "dark")] {
        browser.resize(width, 844, theme);
        browser.wait_until(&format!("innerWidth === {width}"));
        assert_eq!(browser.value("document.documentElement.scrollWidth"), width, "{theme}");
        let brightness = "getComputedStyle(document.body).backgroundColor.match(/\\d+/g)[0] < 128";
        browser.wait_until(&format!("({brightness}) === {}", theme == "dark"));
    }
}

#[test]
fn a_browser_without_webgl_shows_the_rest() {
    let Some((mut browser, _bench)) = opened(&["--disable-3d-apis"]) else { return };
    browser.wait_until("document.querySelector('.surface .note').textContent.includes('no WebGL 2')");
    let first = browser.value(&sum_of("map"));
    browser.wait_until(&format!("{} !== {first}", sum_of("map")));
}

#[test]
fn a_browser_that_is_killed_leaves_tracking_alone() {
    let Some((browser, bench)) = opened(&[]) else { return };
    drop(browser);
    let handle = &bench.running.handles()[0];
    let (before, start) = (handle.counts().tracked, Instant::now());
    while handle.counts().tracked < before + 50 {
        assert!(start.elapsed() < Duration::from_mins(1), "{:?}", handle.counts());
        std::thread::sleep(Duration::from_millis(20));
    }
    bench.open().fields();
}
