//! The paper's report and the accuracy benchmark, in their quick versions.

use std::fs;

use serde_json::Value;

use crate::workbench::Workbench;

fn numbers(bench: &Workbench, path: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(bench.path(path)).unwrap()).unwrap()
}

#[test]
fn the_quick_report_has_every_figure_and_its_numbers() {
    let bench = Workbench::new();
    let ended = bench.run("reproduce --quick --out report").expect_done();
    assert!(ended.out.contains("report/report.html"), "{}", ended.out);
    let page = fs::read_to_string(bench.path("report/report.html")).unwrap();
    for part in ["Figure 1b", "Figure 2", "Figure 4", "Figure 5", "Figure 6", "Figure 7", "Table I", "Frame rate"] {
        assert!(page.contains(part), "no {part}");
    }
    assert!(!page.contains("src=\"http") && !page.contains("<script"), "the page stands alone");
    let report = numbers(&bench, "report/report.json");
    let camera = &report["table_one"];
    let mean = |name: &str| camera[name]["mean_px"].as_f64().unwrap();
    assert!(mean("after") < 0.45 * mean("before"), "{camera}");
    assert!((mean("test") / mean("after") - 1.0).abs() < 0.1, "{camera}");
    assert!(camera["from_truth_px"].as_f64().unwrap() < 0.02, "{camera}");
    for indenter in report["indenters"][0]["errors"].as_array().unwrap() {
        let error = |name: &str| indenter[name]["everywhere_mm"].as_f64().unwrap();
        assert!(error("dense_clipped") < error("dots_clipped"), "{indenter}");
    }
    for policy in
        report["references"].as_array().unwrap().iter().flat_map(|press| press["policies"].as_array().unwrap())
    {
        assert!(policy["mean_px"].as_f64().unwrap() < 0.05, "{policy}");
    }
}

#[test]
fn the_quick_benchmark_scores_every_method_and_another_program() {
    let bench = Workbench::new();
    let case = "circle--default";
    // A board that slides is nowhere pressed in: depth is 0, what the method "nothing" says too.
    bench.run("simulate board --frames 2 --truth-only --out board").expect_done();
    fs::create_dir_all(bench.path("mine").join(case)).unwrap();
    fs::copy(bench.path("board/truth/depth.npy"), bench.path("mine").join(case).join("depth.npy")).unwrap();
    let ended = bench.run("evaluate --benchmark --quick --out bench --entry mine=mine").expect_done();
    assert!(ended.out.contains("density-perspective"), "{}", ended.out);
    let report = numbers(&bench, "bench/report.json");
    let cases = report["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 3);
    for case in cases {
        let names: Vec<&str> =
            case["scores"].as_array().unwrap().iter().map(|score| score["method"].as_str().unwrap()).collect();
        let own = ["nothing", "density", "density-origin", "density-perspective", "density-clipped", "dots", "elastic"];
        assert_eq!(names[..7], own, "{case}");
        assert_eq!(names.len(), if case["case"] == "circle--default" { 8 } else { 7 }, "{case}");
    }
    let circle = cases.iter().find(|found| found["case"] == case).unwrap();
    let [mine, nothing] = ["mine", "nothing"].map(|name| {
        let score = circle["scores"].as_array().unwrap().iter().find(|score| score["method"] == name).unwrap();
        ["everywhere_mm", "inside_mm", "border_mm", "outside_mm"].map(|region| score[region].as_f64().unwrap())
    });
    let furthest = mine.iter().zip(nothing).map(|(mine, nothing)| (mine - nothing).abs()).fold(0.0, f64::max);
    assert!(furthest < 1e-12, "{mine:?} {nothing:?}");
    assert!(mine[1] > 1.0, "a circle is pressed in by 2 mm: {mine:?}");
    assert!(bench.path("bench/cases").join(format!("{case}.toml")).exists());
    assert!(bench.path("bench/report.html").exists());
}

#[test]
fn an_entry_without_results_is_refused_before_anything_is_solved() {
    let bench = Workbench::new();
    fs::create_dir(bench.path("empty")).unwrap();
    let ended = bench.run("evaluate --benchmark --quick --out bench --entry mine=empty");
    ended.expect_failure("empty: it contains no result such as circle--default/depth.npy", "a folder for each case");
    assert!(!bench.path("bench").exists(), "nothing is begun");
}

#[test]
fn settings_of_the_tracker_are_checked_before_anything_is_solved() {
    let bench = Workbench::new();
    bench.folder("bench");
    bench.write("bench/report.html", "an earlier one");
    let set = |key: &str| bench.run(&format!("evaluate --benchmark --quick --out bench --overwrite --set {key}"));
    set("elastic.netwrok=false").expect_failure("elastic.netwrok", "elastic.network");
    set("gel.thickness_mm=-1").expect_failure("gel.thickness_mm = -1", "mm");
    assert_eq!(fs::read_to_string(bench.path("bench/report.html")).unwrap(), "an earlier one");
}
