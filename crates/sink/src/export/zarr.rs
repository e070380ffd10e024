//! A Zarr group (version 2): a folder with an array for each field and each column of the table, a frame per chunk.
//!
//! The format is a few lines of JSON beside files of values, which Zarr, xarray and Dask read in parts. Dimensions have
//! names as xarray wants them.

use std::fs;
use std::io::Read;
use std::path::Path;

use super::RunArrays;
use crate::SinkError;

/// Level of the compression: the fastest.
const LEVEL: u8 = 1;

/// Writes a run as a Zarr group, which must not exist yet. The record of the run is its attribute `run.toml`.
///
/// # Errors
///
/// [`SinkError::Write`] if a file cannot be written, [`SinkError::Read`] if the run cannot be read.
pub fn write_zarr(run: &RunArrays, folder: &Path) -> Result<(), SinkError> {
    make(folder)?;
    write(&folder.join(".zgroup"), b"{\"zarr_format\": 2}")?;
    let record = format!("{{\"run.toml\": {}}}", json_text(&run.record));
    write(&folder.join(".zattrs"), record.as_bytes())?;
    for array in &run.arrays {
        let inside = folder.join(array.name);
        make(&inside)?;
        let mut chunk = array.shape.clone();
        if let Some(frames) = chunk.first_mut() {
            *frames = 1;
        }
        describe(&inside, &array.descr, &array.shape, &chunk)?;
        attributes(&inside, unit(array.name), dimensions(array.name, array.shape.len()))?;
        let mut values = array.values()?;
        let mut bytes = vec![0; array.frame_len() as usize];
        for frame in 0..array.shape.first().copied().unwrap_or(0) {
            let read = values.read_exact(&mut bytes);
            read.map_err(|error| SinkError::Read { path: array.path().to_owned(), error })?;
            let name = format!("{frame}{}", ".0".repeat(array.shape.len() - 1));
            write(&inside.join(name), &compressed(&bytes))?;
        }
    }
    for (name, column) in &run.table.columns {
        let inside = folder.join(name);
        make(&inside)?;
        let rows = column.rows() as u64;
        describe(&inside, &column.descr(), &[rows], &[rows.max(1)])?;
        attributes(&inside, "", &["frame"])?;
        if rows > 0 {
            write(&inside.join("0"), &compressed(&column.bytes()))?;
        }
    }
    Ok(())
}

/// A text as JSON writes it.
fn json_text(text: &str) -> String {
    let mut json = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => json.extend(['\\', letter]),
            '\n' => json.push_str("\\n"),
            // Tabs and other control letters are spaces in TOML, too.
            letter if letter.is_control() => json.push(' '),
            letter => json.push(letter),
        }
    }
    json.push('"');
    json
}

fn compressed(bytes: &[u8]) -> Vec<u8> {
    miniz_oxide::deflate::compress_to_vec_zlib(bytes, LEVEL)
}

/// `.zarray`: shape, type and storage of the values.
fn describe(folder: &Path, descr: &str, shape: &[u64], chunk: &[u64]) -> Result<(), SinkError> {
    let text = format!(
        "{{\"zarr_format\": 2, \"shape\": {shape:?}, \"chunks\": {chunk:?}, \"dtype\": \"{descr}\", \"order\": \"C\", \
         \"fill_value\": null, \"filters\": null, \"compressor\": {{\"id\": \"zlib\", \"level\": {LEVEL}}}}}"
    );
    write(&folder.join(".zarray"), text.as_bytes())
}

/// `.zattrs`: unit and names of the dimensions.
fn attributes(folder: &Path, unit: &str, dimensions: &[&str]) -> Result<(), SinkError> {
    let unit = if unit.is_empty() { String::new() } else { format!(", \"units\": \"{unit}\"") };
    let text = format!("{{\"_ARRAY_DIMENSIONS\": {dimensions:?}{unit}}}");
    write(&folder.join(".zattrs"), text.as_bytes())
}

fn unit(name: &str) -> &'static str {
    match name {
        "flow" | "deviation" => "px",
        "depth" | "depth_deviation" | "displacement" => "mm",
        "traction" => "MPa",
        _ => "",
    }
}

/// Names of the dimensions; tractions lie on a grid of their own.
fn dimensions(name: &str, count: usize) -> &'static [&'static str] {
    let all: &[&str] = match name {
        "traction" => &["frame", "cell_row", "cell_column", "xyz"],
        "flow" => &["frame", "row", "column", "xy"],
        _ => &["frame", "row", "column", "xyz"],
    };
    all.get(..count).unwrap_or(all)
}

fn make(folder: &Path) -> Result<(), SinkError> {
    fs::create_dir(folder).map_err(SinkError::writing(folder))
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), SinkError> {
    fs::write(path, bytes).map_err(SinkError::writing(path))
}
