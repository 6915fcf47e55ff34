//! The page of an export for all who open it: names of its controls, a still picture where it cannot draw, its policy, and no control over another.

use crate::browser::Browser;
use crate::export::page_with;
use crate::sandbox::Sandbox;
use serde_json::json;

/// A sandbox with a page of a small export.
fn sandbox_with_page(more: &[&str]) -> Sandbox {
    let sandbox = Sandbox::with_small_surface().without_vulkan();
    page_with(&sandbox, "0.05", more);
    sandbox
}

#[test]
fn a_screen_reader_finds_the_names_of_all_controls_and_what_they_say() {
    let sandbox = sandbox_with_page(&[]);
    let mut browser = Browser::with(&sandbox, &[]);
    browser.open(&sandbox, "page.html");
    let tree = browser.call("Accessibility.getFullAXTree", json!({}));
    let names = |role: &str| -> Vec<String> {
        let nodes = tree["nodes"].as_array().unwrap().iter().filter(|node| node["role"]["value"] == role);
        let mut names: Vec<_> =
            nodes.map(|node| node["name"]["value"].as_str().unwrap_or_default().to_owned()).collect();
        names.sort();
        names
    };
    let sliders = [
        "Brightness of the studio",
        "Direction of the light",
        "Exposure",
        "Matt layer below",
        "Size of the light",
    ];
    assert_eq!(names("slider"), sliders);
    assert_eq!(names("checkbox"), ["A studio around it"]);
    let wrapped = "document.querySelectorAll('label :is(input, output)').length";
    assert_eq!(browser.value(wrapped), 0);
    let mut said = |id: &str| browser.value(&format!("element('{id}').getAttribute('aria-valuetext')"));
    assert_eq!(said("light"), "30 degrees from the normal, azimuth 56 degrees");
    assert_eq!([said("exposure"), said("spread"), said("pigment")], ["0.0 stops", "0.50°", "7 %"]);
    browser.value("state.light = [-0.5, 0]; element('exposure').value = 1.5; draw()");
    let mut said = |id: &str| browser.value(&format!("element('{id}').getAttribute('aria-valuetext')"));
    assert_eq!(said("light"), "30 degrees from the normal, azimuth 180 degrees");
    assert_eq!(said("exposure"), "+1.5 stops");
    assert_eq!(browser.value("element('exposure-value').value"), "+1.5 stops");
}

#[test]
fn a_page_runs_its_script_alone_and_loads_nothing() {
    let sandbox = sandbox_with_page(&[]);
    let mut browser = Browser::with(&sandbox, &[]);
    browser.open(&sandbox, "page.html");
    assert_eq!(browser.value("document.documentElement.dataset.state"), "drawn");
    browser.value("document.body.append(Object.assign(document.createElement('script'), { textContent: 'globalThis.foreign = 1' }))");
    assert_eq!(browser.value("typeof foreign"), "undefined");
    let loaded = "fetch('data:,x').then(() => 'loaded', () => 'refused')";
    assert_eq!(browser.value(loaded), "refused");
    // A script that was changed does not run.
    let page = String::from_utf8(sandbox.read("page.html")).unwrap();
    let changed = page.replace("const FOCAL = 3.2;", "const FOCAL = 3.3;");
    assert!(changed != page);
    sandbox.write("changed.html", changed);
    browser.load(&sandbox, "changed.html");
    assert_eq!(browser.value("document.documentElement.dataset.state ?? 'none'"), "none");
}

/// Width of the still picture, whether the controls show, and whether the facts do.
const FALLBACK: &str = "[document.getElementById('still').naturalWidth, \
     [...document.querySelectorAll('.live')].filter((e) => e.getClientRects().length).length, \
     document.querySelectorAll('#facts dt').length, \
     document.getElementById('still').getClientRects().length]";

#[test]
fn a_page_without_webgl_or_without_scripts_shows_a_still_picture() {
    let sandbox = sandbox_with_page(&[]);
    let mut browser = Browser::with(&sandbox, &["--disable-3d-apis"]);
    browser.open(&sandbox, "page.html");
    assert_eq!(browser.value("document.documentElement.dataset.state"), "failed");
    let [width, controls, facts, shown] = browser.numbers(FALLBACK);
    assert!(width >= 300.0 && facts >= 5.0, "{width} {facts}");
    assert_eq!([controls, shown], [0.0, 1.0]);
    let words = browser.value("document.getElementById('failure').innerText");
    assert!(words.as_str().unwrap().contains("WebGL 2"), "{words}");

    browser.call("Emulation.setScriptExecutionDisabled", json!({ "value": true }));
    browser.load(&sandbox, "page.html");
    assert_eq!(browser.numbers::<4>(FALLBACK), [width, 0.0, facts, 1.0]);
    let words = browser.value("document.querySelector('.frame noscript').innerText");
    assert!(words.as_str().unwrap().contains("JavaScript"), "{words}");
    drop(browser);
    // With both, the controls show and the still picture does not.
    let mut browser = Browser::with(&sandbox, &[]);
    browser.open(&sandbox, "page.html");
    let [_, controls, _, shown] = browser.numbers(FALLBACK);
    assert!(controls > 5.0 && shown == 0.0, "{controls} {shown}");
}

/// Mean difference of the codes of the still picture from those that the page draws, and the same with the still picture mirrored.
const DIFFERENCES: &str = "(() => {
    const still = element('still'), side = still.naturalWidth;
    const drawn = document.createElement('canvas'), kept = document.createElement('canvas');
    for (const name of ['clientWidth', 'clientHeight']) Object.defineProperty(drawn, name, { value: side });
    paint(drawn, SHAPE, 1);
    [kept.width, kept.height] = [side, side];
    kept.getContext('2d').drawImage(still, 0, 0);
    const [a, b] = [drawn, kept].map((canvas) => canvas.getContext('2d').getImageData(0, 0, side, side).data);
    const sums = [0, 0];
    let count = 0;
    for (let i = 0; i < side * side; i++) {
        const mirrored = i + side - 1 - 2 * (i % side);
        if (b[4 * i + 3] < 255 || b[4 * mirrored + 3] < 255) continue;
        count += 3;
        for (let c = 0; c < 3; c++) {
            sums[0] += Math.abs(a[4 * i + c] - b[4 * i + c]);
            sums[1] += Math.abs(a[4 * i + c] - b[4 * mirrored + c]);
        }
    }
    return [sums[0] / count, sums[1] / count, count / (3 * side * side)];
})()";

#[test]
fn the_still_picture_is_what_the_page_draws() {
    let sandbox = sandbox_with_page(&[]);
    let mut browser = Browser::with(&sandbox, &[]);
    browser.open(&sandbox, "page.html");
    let [off, mirrored, share] = browser.numbers(DIFFERENCES);
    eprintln!("{off} of 255 over {share} of the picture, mirrored {mirrored}");
    assert!(share > 0.3 && off < 4.0, "{off} over {share}");
    assert!(mirrored > 2.0 * off, "{mirrored}");
}

/// Pairs of texts and controls that overlap by more than a pixel, none of which is part of the other.
const OVERLAPS: &str = "(() => {
    const all = [...document.querySelectorAll('h1, h2, p, label, output, button, input, summary, dt, dd, li, pre, figure, .dome, #bar')];
    const boxes = all.map((e) => [e, e.getBoundingClientRect()]).filter(([e, box]) => box.width * box.height > 0 && e.getClientRects().length);
    const name = (e) => e.id || e.textContent.slice(0, 20) || e.tagName;
    const pairs = [];
    boxes.forEach(([a, p], i) => boxes.slice(i + 1).forEach(([b, q]) => {
        const across = Math.min(p.right, q.right) - Math.max(p.left, q.left), down = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top);
        if (across > 1 && down > 1 && !a.contains(b) && !b.contains(a)) pairs.push(`${name(a)} over ${name(b)}`);
    }));
    const cut = all.filter((e) => e.matches('button, label, output, h1, h2') && e.scrollWidth > e.clientWidth + 1 && e.clientWidth > 0);
    return [...pairs, ...cut.map((e) => `${name(e)} is cut`)].join('; ');
})()";

#[test]
fn no_control_lies_over_another_on_narrow_screens() {
    let sandbox = sandbox_with_page(&["--mesh", "plate"]);
    let mut browser = Browser::with(&sandbox, &[]);
    browser.open(&sandbox, "page.html");
    browser.value("document.querySelector('details').open = true");
    for width in [375, 800, 1280] {
        for scale in [1, 2] {
            browser.resize([width, 800], scale);
            assert_eq!(browser.value(OVERLAPS), "", "{width} pixels, scale {scale}");
            let [content, screen] = browser
                .numbers("[document.documentElement.scrollWidth, document.documentElement.clientWidth]");
            assert_eq!(content, screen, "{width} pixels, scale {scale}");
        }
    }
    browser.value("element('reset').style.marginTop = '-80px'");
    let overlaps = browser.value(OVERLAPS);
    assert!(overlaps.as_str().unwrap().contains("over reset"), "{overlaps}");
}
