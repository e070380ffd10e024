//! The tables of the page, each from its own runs of the command.

use std::fmt::Display;
use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::ValueEnum;
use fingervision_evaluate::quantile;
use serde_json::Value;

use super::document::table;
use super::program::{Program, number, read};
use super::roofline::Limits;
use crate::instructions::{Entry, Record, Stage, millions, record_path};

/// Sensors and frames per second of each.
const LOADS: [(&str, &str); 4] = [("1", "90"), ("1", "45"), ("2", "45"), ("4", "90")];
const LOAD_SECONDS: &str = "10";
/// Columns and rows of the images, px.
const SIZES: [(usize, usize); 4] = [(320, 240), (640, 480), (960, 720), (1280, 960)];
/// How often the frames of the benchmark's press are repeated for tracking, forwards and backwards.
const REPETITIONS: usize = 17;
const PRESS_FRAMES: usize = 31;
/// Frames of the press that is simulated.
const SIMULATED_FRAMES: &str = "7";

/// A table of the page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Name {
    /// Flow, density and elastic depth of a frame.
    Frame,
    /// The same beside the usual Python pipeline, from the latest record.
    Peer,
    /// At rest against pressed, in instructions.
    Rest,
    /// Least times and measured times of each stage.
    Roofline,
    /// Several sensors at camera rate.
    Sensors,
    /// Images of several sizes.
    Sizes,
    /// Tracking a folder of images with one thread and with all.
    Track,
    /// Simulating a press on the draft mesh and the medium one.
    Simulate,
}

impl Name {
    pub(super) fn make(self, program: &Program) -> Result<String> {
        match self {
            Self::Frame => frame(program),
            Self::Peer => peer(),
            Self::Rest => rest(),
            Self::Roofline => roofline(program),
            Self::Sensors => sensors(program),
            Self::Sizes => sizes(program),
            Self::Track => track(program),
            Self::Simulate => simulate(program),
        }
    }
}

/// Cells as text.
fn row<const N: usize>(cells: [&dyn Display; N]) -> Vec<String> {
    cells.iter().map(ToString::to_string).collect()
}

fn ms(time_ms: f64) -> String {
    format!("{time_ms:.1}")
}

fn frame(program: &Program) -> Result<String> {
    let report = program.report(&["bench", "--frames", "150"])?;
    let of = |place: &str| number(&report, place);
    let (flow, live, exact) = (of("elastic_ms/flow")?, of("elastic_ms/live")?, of("elastic_ms/exact")?);
    let rows = [
        row([&"flow", &ms(flow), &"1"]),
        row([
            &"flow and density, filter, line",
            &ms(of("frame_ms/median")?),
            &format!("{:.2}", of("frame_ms/median")? / flow),
        ]),
        row([&"flow and elastic depth, live", &ms(flow + live), &format!("{:.2}", (flow + live) / flow)]),
        row([&"flow and elastic depth, exact", &ms(flow + exact), &format!("{:.2}", (flow + exact) / flow)]),
    ];
    let table = table(&["610×450 px, colour, one thread", "ms, median", "times flow"], &rows);
    let ratio = (flow + exact) / (flow + live);
    let (mean, last) = (of("epe_px/mean")?, of("epe_px/final")?);
    Ok(format!(
        "{table}\nExact takes {ratio:.2} times as long as live. Error of the flow: {mean:.4} px on average, {last:.4} px at the \
         end of the press."
    ))
}

/// The latest record of the comparison with the Python pipeline.
fn peer() -> Result<String> {
    let folder = crate::workspace().join("benches/record");
    let mut records: Vec<PathBuf> = fs::read_dir(&folder)?.map(|entry| Ok(entry?.path())).collect::<Result<_>>()?;
    records.retain(|path| path.extension().is_some_and(|ending| ending == "json"));
    records.retain(|path| !path.file_stem().unwrap_or_default().to_string_lossy().ends_with("-elastic"));
    // Names without a time are older.
    let key = |path: &PathBuf| {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let parts: Vec<&str> = name.split('-').collect();
        let time = if parts.len() > 4 { parts[3].to_owned() } else { String::new() };
        (parts[..parts.len().min(3)].join("-"), time)
    };
    records.sort_by_key(key);
    let latest = records.pop().with_context(|| format!("{} has no record", folder.display()))?;
    let report = read(&latest)?;
    let of = |place: &str| number(&report, place);
    let median = |key| median_of_rounds(&report, key);
    let theirs = median("peer_ms")?;
    let mut rows =
        vec![row([&"OpenCV MEDIUM and splat", &ms(theirs), &"1", &format!("{:.4}", of("peer/epe_px/mean")?)])];
    let (fast, error) = (median("fast_ms")?, of("ours/epe_px/mean")?);
    let (faster, error) = (format!("{:.2}", theirs / fast), format!("{error:.4}"));
    rows.push(row([&"OpenCV FAST and splat", &ms(fast), &faster, &format!("{:.4}", of("fast/epe_px/mean")?)]));
    let times = format!("{:.2}", of("ratio/median")?);
    rows.push(row([&"flow and density", &ms(median("ours_ms")?), &times, &error]));
    // Timed in the last round alone, so compared with the peer of that round.
    if let (Ok(flow), Ok(live), Ok(last)) =
        (of("ours/elastic_ms/flow"), of("ours/elastic_ms/live"), of("peer/frame_ms/median"))
    {
        let both = flow + live;
        rows.push(row([&"flow and elastic depth, live", &ms(both), &format!("{:.2}", last / both), &error]));
    }
    let table =
        table(&["610×450 px, one thread", "ms, median", "faster than the peer, times", "error of the flow, px"], &rows);
    let ratio = of("ratio_fast/median")?;
    let name = latest.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let word = |place: &str| report.pointer(place).and_then(Value::as_str).unwrap_or("unknown").to_owned();
    let (cpu, set) = (word("/machine/cpu"), word("/ours/instruction_set"));
    Ok(format!(
        "{table}\nFrom `benches/record/{name}`, {cpu}, {set}. Flow and density are {ratio:.2} times as fast as the pipeline with FAST."
    ))
}

/// The median over the rounds of a record.
fn median_of_rounds(report: &Value, key: &str) -> Result<f64> {
    let rounds = report.pointer("/rounds").and_then(Value::as_array).context("the record has no rounds")?;
    let times: Vec<f32> = rounds.iter().map(|round| Ok(number(round, key)? as f32)).collect::<Result<_>>()?;
    Ok(quantile(times, 0.5))
}

fn rest() -> Result<String> {
    let record = Record::read(&record_path())?;
    let count = |stage| Ok::<_, anyhow::Error>(entry(&record, stage)?.instructions);
    let pairs = [
        ("flow", count(Stage::Rest)?, count(Stage::Flow)?),
        ("elastic depth, live", count(Stage::RestLive)?, count(Stage::Live)?),
        ("elastic depth, exact", count(Stage::RestExact)?, count(Stage::Exact)?),
    ];
    let [flow, live, exact] = pairs.map(|(_, rest, pressed)| (rest, pressed));
    let rows = pairs.into_iter().chain([
        ("flow and live depth", flow.0 + live.0, flow.1 + live.1),
        ("flow and exact depth", flow.0 + exact.0, flow.1 + exact.1),
    ]);
    let percent = |rest: u64, pressed: u64| format!("{:.0} %", 100.0 * rest as f64 / pressed as f64);
    let rows: Vec<_> = rows
        .map(|(name, rest, pressed)| {
            let counts = [rest, pressed].map(|count| format!("{:.1}", millions(count)));
            row([&name, &counts[0], &counts[1], &percent(rest, pressed)])
        })
        .collect();
    let heads = ["640×480 px, million instructions a frame", "at rest", "pressed", "at rest against pressed"];
    Ok(format!("{}\n{}, {}.", table(&heads, &rows), record.instruction_set, record.rustc))
}

fn entry(record: &Record, stage: Stage) -> Result<&Entry> {
    record.entry(stage).with_context(|| format!("the record has no stage {stage}: cargo xtask instructions --update"))
}

/// The time of a stage in a report of one sensor at a low rate, ms.
fn stage_ms(stage: Stage, single: &Value, bench: &Value) -> Option<f64> {
    let of = |report: &Value, place: &str| number(report, place).ok();
    match stage {
        Stage::Jpeg => of(single, "stages_ms/decode/p50"),
        Stage::FlowGrey => Some(of(single, "stages_ms/flow/p50")? + of(single, "stages_ms/picture/p50")?),
        Stage::Live => of(single, "stages_ms/elastic/p50"),
        // These are of smaller images.
        Stage::Flow => Some(PIXELS_RATIO * of(bench, "elastic_ms/flow")?),
        Stage::Exact => Some(PIXELS_RATIO * of(bench, "elastic_ms/exact")?),
        Stage::Density => Some(PIXELS_RATIO * (of(bench, "frame_ms/median")? - of(bench, "elastic_ms/flow")?)),
        Stage::Reference | Stage::Rest | Stage::RestLive | Stage::RestExact => None,
    }
}

/// Pixels of the record's images over those of the benchmark's.
const PIXELS_RATIO: f64 = (640.0 * 480.0) / (610.0 * 450.0);

fn roofline(program: &Program) -> Result<String> {
    let record = Record::read(&record_path())?;
    let limits = Limits::measure();
    let single = program.report(&["bench", "--sensors", "1", "--threads", "1", "--rate", "20", "--seconds", "5"])?;
    let bench = program.report(&["bench", "--frames", "60"])?;
    let mut rows = Vec::new();
    for stage in Stage::ALL {
        let Entry { instructions, first_cache_bytes, second_cache_bytes, .. } = entry(&record, stage)?;
        let bytes = first_cache_bytes.zip(*second_cache_bytes);
        let (first, second) = bytes.unwrap_or((0, 0));
        let least = limits.least_ms(*instructions, first, second);
        let measured = stage_ms(stage, &single, &bench);
        let mib = |bytes: u64| format!("{:.1}", bytes as f64 / f64::from(1 << 20));
        rows.push(row([
            &stage,
            &format!("{:.1}", millions(*instructions)),
            &bytes.map_or("–".into(), |_| mib(first)),
            &bytes.map_or("–".into(), |_| mib(second)),
            &format!("{least:.2}"),
            &measured.map_or("–".into(), |measured| format!("{measured:.2}")),
            &measured.map_or("–".into(), |measured| format!("{:.1}", measured / least)),
        ]));
    }
    let heads = [
        "stage, 640×480 px",
        "million instructions",
        "MiB, first to second cache",
        "MiB, behind the second cache",
        "least time, ms",
        "measured, ms",
        "measured / least",
    ];
    let (clock, bandwidth) = (limits.clock_hz / 1e9, limits.memory_bytes_per_s / 1e9);
    Ok(format!(
        "{}\nClock {clock:.2} GHz, memory {bandwidth:.1} GB/s, counted with {}.",
        table(&heads, &rows),
        record.instruction_set
    ))
}

fn sensors(program: &Program) -> Result<String> {
    let mut rows = Vec::new();
    for (sensors, rate) in LOADS {
        let report = program.report(&["bench", "--sensors", sensors, "--rate", rate, "--seconds", LOAD_SECONDS])?;
        let of = |place: &str| number(&report, place);
        let stage = |name: &str| of(&format!("stages_ms/{name}/p50")).map_or("–".into(), ms);
        rows.push(row([
            &format!("{sensors} at {rate}"),
            &ms(of("sustained_rate")?),
            &of("dropped_frames")?,
            &ms(of("latency_ms/p50")?),
            &ms(of("latency_ms/p99")?),
            &stage("decode"),
            &stage("flow"),
            &stage("elastic"),
            &of("sensor_memory_mib").map_or("–".into(), ms),
            &of("cpus").map_or("–".into(), |cpus| format!("{cpus:.2}")),
        ]));
    }
    let heads = [
        "sensors at frames/s",
        "readings/s of each",
        "dropped",
        "latency p50, ms",
        "p99, ms",
        "decoding p50, ms",
        "flow p50, ms",
        "depth p50, ms",
        "MiB a sensor",
        "processors in use",
    ];
    Ok(format!("{}\nMotion JPEG of 640×480 px, live mode, {LOAD_SECONDS} s.", table(&heads, &rows)))
}

fn sizes(program: &Program) -> Result<String> {
    let mut rows = Vec::new();
    let mut middle = None;
    for (width, height) in SIZES {
        let profile = program.file("size.toml");
        fs::write(&profile, format!("[image]\nregion_of_interest = [0, 0, {width}, {height}]\n"))?;
        let report = program.report(&["bench", "--frames", "30", "--profile", &profile])?;
        let (time, error) = (number(&report, "frame_ms/median")?, number(&report, "epe_px/mean")?);
        let per_pixel = 1e6 * time / (width * height) as f64;
        rows.push((format!("{width}×{height}"), time, per_pixel, error));
        if width == 640 {
            middle = Some(per_pixel);
        }
    }
    let middle = middle.context("no size is 640 px wide")?;
    let rows: Vec<_> = rows
        .into_iter()
        .map(|(name, time, per_pixel, error)| {
            let relative = format!("{:.2}", per_pixel / middle);
            row([&name, &ms(time), &format!("{per_pixel:.1}"), &relative, &format!("{error:.4}")])
        })
        .collect();
    let heads = ["px", "flow and density, ms", "ns a pixel", "against 640×480", "error of the flow, px"];
    Ok(table(&heads, &rows))
}

fn track(program: &Program) -> Result<String> {
    let (press, film) = (program.folder.join("press"), program.folder.join("film"));
    program.report(&["bench", "--write-frames", &program.file("press")])?;
    fs::create_dir_all(&film)?;
    let there = 0..PRESS_FRAMES;
    let back = (1..PRESS_FRAMES - 1).rev();
    let frames: Vec<usize> = std::iter::repeat_n(there.chain(back), REPETITIONS).flatten().collect();
    for (number, frame) in frames.iter().enumerate() {
        fs::copy(press.join(format!("frames/{frame:06}.png")), film.join(format!("{number:06}.png")))?;
    }
    let (folder, out) = (program.file("film"), program.file("run"));
    let mut times = Vec::new();
    for threads in [Some("1"), None] {
        let threads: Vec<&str> = threads.map_or(Vec::new(), |threads| vec!["--threads", threads]);
        let arguments = ["track", &folder, "--out", &out];
        times.push(program.time_s(&[&arguments[..], &threads[..]].concat())?);
        // Not left to the next run: to delete gigabytes takes half a second.
        fs::remove_dir_all(program.folder.join("run"))?;
    }
    let rate = |time_s: f64| format!("{:.1}", frames.len() as f64 / time_s);
    let rows = [
        row([&"1", &rate(times[0]), &"1"]),
        row([&"as many as cores", &rate(times[1]), &format!("{:.2}", times[0] / times[1])]),
    ];
    let table = table(&["threads", "frames/s", "against one thread"], &rows);
    Ok(format!("{table}\n{} PNG images of 610×450 px, flow and density, start of the program included.", frames.len()))
}

fn simulate(program: &Program) -> Result<String> {
    let mut rows = Vec::new();
    for (mesh, option) in [("draft", "mesh.resolution=draft"), ("medium", "mesh.resolution=medium")] {
        let out = program.file(mesh);
        let arguments = ["simulate", "sphere", "--out", &out, "--frames", SIMULATED_FRAMES, "--no-cache"];
        let time_s = program.time_s(&[&arguments[..], &["--set", option]].concat())?;
        rows.push(row([&mesh, &format!("{time_s:.1}")]));
    }
    let table = table(&["mesh", "s"], &rows);
    Ok(format!("{table}\nA ball, 2 mm deep, {SIMULATED_FRAMES} frames, solved, rendered and written."))
}
