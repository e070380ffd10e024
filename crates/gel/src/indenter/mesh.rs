//! A closed triangle mesh from an STL file, seen from its top.

use std::collections::HashMap;
use std::io::{Cursor, ErrorKind};
use std::path::Path;

use super::IndenterError;
use super::grid::HeightGrid;

/// Bytes of a binary STL before its triangles, and of a triangle.
const HEADER_BYTES: usize = 84;
const TRIANGLE_BYTES: usize = 50;

/// A mesh in the indenter's frame: its box is centred at the origin, its top faces the gel.
///
/// An STL file is viewed from above as in a drawing program: X to the right, Y up in the image, Z towards the viewer,
/// here the camera.
#[derive(Debug, Clone)]
pub(super) struct Mesh {
    /// Corners as x, y and the distance behind the foremost one, mm.
    triangles: Vec<[[f64; 3]; 3]>,
    half_extent_mm: [f64; 2],
}

impl Mesh {
    /// The closed mesh of a file whose unit is `scale` mm.
    pub(super) fn read(file: &Path, scale: f64) -> Result<Self, IndenterError> {
        let refused = |why: String| IndenterError::NoMesh { file: file.to_owned(), why };
        let bytes = super::read(file)?;
        let mut triangles = triangles(bytes).map_err(refused)?;
        if triangles.is_empty() {
            return Err(refused("there are no triangles".into()));
        }
        check_closed(&triangles, file)?;
        for corner in triangles.iter_mut().flatten() {
            *corner = [scale * corner[0], -scale * corner[1], -scale * corner[2]];
        }
        let range = |axis: usize| {
            let along = triangles.iter().flatten().map(|corner| corner[axis]);
            along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
        };
        let [x, y, height] = [0, 1, 2].map(range);
        let centre = [x[0].midpoint(x[1]), y[0].midpoint(y[1]), height[0]];
        for corner in triangles.iter_mut().flatten() {
            *corner = [0, 1, 2].map(|axis| corner[axis] - centre[axis]);
        }
        Ok(Self { triangles, half_extent_mm: [x, y].map(|[low, high]| 0.5 * (high - low)) })
    }

    /// Half the mesh's width along x and y, mm.
    pub(super) fn half_extent_mm(&self) -> [f64; 2] {
        self.half_extent_mm
    }

    /// Lowers the nodes of a grid to the mesh's foremost triangles over them.
    pub(super) fn over(&self, grid: &mut HeightGrid) {
        for triangle in &self.triangles {
            lower(grid, triangle);
        }
    }
}

/// Lowers the nodes under one triangle to it. A vertical triangle covers none; its neighbours contain its edge.
fn lower(grid: &mut HeightGrid, [a, b, c]: &[[f64; 3]; 3]) {
    let edge = |p: &[f64; 3], q: &[f64; 3], [x, y]: [f64; 2]| (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
    let area = edge(a, b, [c[0], c[1]]);
    let corner = grid.corner_mm();
    let counts = [grid.columns, grid.rows];
    let [columns, rows] = [0, 1].map(|axis| {
        let [low, high] = [f64::min, f64::max].map(|pick| pick(pick(a[axis], b[axis]), c[axis]) - corner[axis]);
        let first = (low / grid.step_mm - 1e-6).ceil().max(0.0) as usize;
        first..((high / grid.step_mm + 1e-6).floor().max(0.0) as usize + 1).min(counts[axis])
    });
    if area == 0.0 {
        return;
    }
    for row in rows {
        for column in columns.clone() {
            let node = grid.node_mm(column, row);
            let shares = [edge(b, c, node), edge(c, a, node), edge(a, b, node)].map(|share| share / area);
            // A node on the edge of two triangles belongs to both, whatever the rounding.
            if shares.iter().all(|&share| share >= -1e-9) {
                let height: f64 = shares.iter().zip([a, b, c]).map(|(share, corner)| share * corner[2]).sum();
                let kept = &mut grid.heights_mm[row * counts[0] + column];
                *kept = kept.min(height.max(0.0));
            }
        }
    }
}

/// The triangles of an STL file, binary or text.
fn triangles(mut bytes: Vec<u8>) -> Result<Vec<[[f64; 3]; 3]>, String> {
    let count =
        bytes.get(80..HEADER_BYTES).map(|count| u32::from_le_bytes(count.try_into().unwrap_or_default()) as usize);
    let is_text = bytes.starts_with(b"solid") && !bytes.contains(&0) && std::str::from_utf8(&bytes).is_ok();
    if is_text {
        let bodies =
            bytes.split(|&byte| byte == b'\n').filter(|line| line.trim_ascii().starts_with(b"endsolid")).count();
        if bodies > 1 {
            return Err(format!("it contains {bodies} solids, but must be a single one"));
        }
        // The reader recognises the text form by "solid" and a space.
        bytes.splice(0..5, *b"solid ");
    } else if let Some(count) = count {
        let length = count.checked_mul(TRIANGLE_BYTES).map(|length| length + HEADER_BYTES);
        if length.is_none_or(|length| length > bytes.len()) {
            let held = (bytes.len() - HEADER_BYTES) / TRIANGLE_BYTES;
            return Err(format!(
                "it is cut off, or not an STL: its header announces {count} triangles, but its size allows {held}"
            ));
        }
        // A binary header may begin with "solid " too.
        bytes[0] = b' ';
    } else {
        return Err("it is cut off, or not an STL".into());
    }
    let mut cursor = Cursor::new(bytes);
    let reader = stl_io::create_stl_reader(&mut cursor).map_err(|error| why(&error))?;
    reader.map(|triangle| corners(&triangle.map_err(|error| why(&error))?)).collect()
}

fn corners(triangle: &stl_io::Triangle) -> Result<[[f64; 3]; 3], String> {
    // Adding 0 makes 0 and −0 the same number, so that corners can be compared by their bits.
    let corners = triangle.vertices.map(|vertex| vertex.0.map(|value| f64::from(value) + 0.0));
    match corners.iter().flatten().find(|value| !value.is_finite()) {
        Some(value) => Err(format!("a coordinate is {value}")),
        None => Ok(corners),
    }
}

fn why(error: &std::io::Error) -> String {
    match error.kind() {
        ErrorKind::UnexpectedEof => format!("it is cut off: {error}"),
        _ => error.to_string(),
    }
}

/// Checks that every edge belongs to an even number of triangles. Triangles without area, with only one or two different
/// corners, do not count.
fn check_closed(triangles: &[[[f64; 3]; 3]], file: &Path) -> Result<(), IndenterError> {
    let mut edges: HashMap<[[u64; 3]; 2], bool> = HashMap::new();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|corner| corner.map(f64::to_bits));
        if a != b && b != c && c != a {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                let is_open = edges.entry([p.min(q), p.max(q)]).or_default();
                *is_open = !*is_open;
            }
        }
    }
    let open = edges.iter().filter(|&(_, &is_open)| is_open).map(|(edge, _)| edge);
    let Some(first) = open.clone().min() else { return Ok(()) };
    let [p, q] = first.map(|corner| corner.map(f64::from_bits));
    Err(IndenterError::OpenMesh {
        file: file.to_owned(),
        open_edges: open.count(),
        edges: edges.len(),
        triangles: triangles.len(),
        place: [0, 1, 2].map(|axis| p[axis].midpoint(q[axis])),
    })
}
/// Checks that a mesh is large enough to be sampled and not absurdly large.
pub(super) fn check_size(file: &Path, half_extent_mm: [f64; 2]) -> Result<(), IndenterError> {
    let [x, y] = half_extent_mm.map(|half| 2.0 * half);
    if (0.2..=1000.0).contains(&x) && (0.2..=1000.0).contains(&y) {
        return Ok(());
    }
    let why = format!(
        "it is {x} by {y} mm wide and would have to be 0.2 to 1000 mm; indenter.scale is the file's unit in mm"
    );
    Err(IndenterError::NoMesh { file: file.to_owned(), why })
}
