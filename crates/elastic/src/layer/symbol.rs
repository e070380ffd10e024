//! A 3×3 matrix at every frequency, Hermitian, for real fields.

use std::f64::consts::TAU;

use fingervision_fourier::Complex64;

use super::Layer;
use super::half_space::Influence;
use super::transform::Transform;

/// The matrix at one frequency: `xz` and `yz` represent `i xz` and `i yz`, and the lower triangle is the conjugate.
pub(super) type Entry = Influence;

/// The matrices at all frequencies of a [`Transform`]'s spectrum, with the transform's scale taken out.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Symbol {
    entries: Vec<Entry>,
}

impl Symbol {
    /// The symbol of a convolution with an influence, which is given by the offset in cells for offsets within
    /// `columns` and `rows` of zero, for offsets of no negative part; the others follow from symmetry.
    pub(super) fn of_influence(
        transform: &mut Transform<f64>,
        (columns, rows): (usize, usize),
        influence: impl Fn(usize, usize) -> Influence,
    ) -> Self {
        let quadrant: Vec<_> = (0..rows)
            .flat_map(|row| (0..columns).map(move |column| (column, row)))
            .map(|(i, j)| influence(i, j))
            .collect();
        let (width, height) = (transform.width(), transform.height());
        let scale = 1.0 / (width * height) as f64;
        let mut entries = vec![Entry::default(); transform.columns() * height];
        let mut spectrum = transform.spectrum();
        for part in PARTS {
            let value = |column: usize, row: usize| {
                let (i, x_sign) = folded(column, width, part.odd_x);
                let (j, y_sign) = folded(row, height, part.odd_y);
                if i < columns && j < rows { x_sign * y_sign * (part.get)(&quadrant[j * columns + i]) } else { 0.0 }
            };
            transform.forward_into((width, height), value, &mut spectrum);
            // Odd along one axis: imaginary; along both or none: real.
            for (entry, value) in entries.iter_mut().zip(&spectrum) {
                let value = if part.odd_x == part.odd_y { value.re } else { value.im };
                *(part.get_mut)(entry) = scale * value;
            }
        }
        Self { entries }
    }

    /// The stiffness of a layer, the inverse of its compliance, MPa/mm, at the frequencies of a grid of this spacing.
    pub(super) fn of_stiffness(transform: &Transform<f64>, layer: &Layer, cell_mm: f64) -> Self {
        let (width, height) = (transform.width(), transform.height());
        let scale = 1.0 / (width * height) as f64;
        let entry = |column: usize, row: usize| {
            let kx = TAU * column as f64 / (width as f64 * cell_mm);
            let turned = if 2 * row > height { row as f64 - height as f64 } else { row as f64 };
            let ky = TAU * turned / (height as f64 * cell_mm);
            // An odd function along an axis vanishes at its highest frequency, which has no sign.
            let has_sign = [2 * column != width, 2 * row != height].map(|has| f64::from(u8::from(has)));
            stiffness(layer, [kx, ky], has_sign, scale)
        };
        let entries =
            (0..transform.columns()).flat_map(|i| (0..height).map(move |j| (i, j))).map(|(i, j)| entry(i, j)).collect();
        Self { entries }
    }

    /// The matrices, in the order of the spectrum.
    pub(super) fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Multiplies the spectra of the three components of a field.
    pub(super) fn multiply(&self, [x, y, z]: &mut [Vec<Complex64>; 3]) {
        let turned = |value: Complex64| Complex64::new(-value.im, value.re);
        for (entry, ((x, y), z)) in self.entries.iter().zip(x.iter_mut().zip(y.iter_mut()).zip(z.iter_mut())) {
            let (a, b, c) = (*x, *y, *z);
            *x = a * entry.xx + b * entry.xy + turned(c) * entry.xz;
            *y = a * entry.xy + b * entry.yy + turned(c) * entry.yz;
            *z = c * entry.zz - turned(a) * entry.xz - turned(b) * entry.yz;
        }
    }

    /// Multiplies the spectrum of the third component of a field by that component's entry alone.
    pub(super) fn multiply_normal(&self, z: &mut [Complex64]) {
        for (entry, z) in self.entries.iter().zip(z) {
            *z *= entry.zz;
        }
    }
}

fn stiffness(layer: &Layer, [kx, ky]: [f64; 2], has_sign: [f64; 2], scale: f64) -> Entry {
    let k = kx.hypot(ky);
    let wave = layer.wave_compliance(k);
    let (x, y) = if k > 0.0 { (kx / k, ky / k) } else { (1.0, 0.0) };
    let determinant = wave.longitudinal * wave.normal - wave.coupling * wave.coupling;
    // A half-space does not resist uniform traction.
    let over = |value: f64| if determinant.is_finite() { scale * value / determinant } else { 0.0 };
    let (longitudinal, normal, coupling) = (over(wave.normal), over(wave.longitudinal), -over(wave.coupling));
    let transverse = scale / wave.transverse;
    Entry {
        xx: x * x * longitudinal + y * y * transverse,
        xy: x * y * (longitudinal - transverse) * has_sign[0] * has_sign[1],
        yy: y * y * longitudinal + x * x * transverse,
        xz: x * coupling * has_sign[0],
        yz: y * coupling * has_sign[1],
        zz: normal,
    }
}

/// The absolute offset at a place of a periodic axis, and the sign of an odd function there.
fn folded(place: usize, length: usize, is_odd: bool) -> (usize, f64) {
    let is_negative = 2 * place > length;
    let sign = if is_odd && is_negative { -1.0 } else { 1.0 };
    (if is_negative { length - place } else { place }, sign)
}

/// One entry of the matrix and its symmetry.
struct Part {
    odd_x: bool,
    odd_y: bool,
    get: fn(&Influence) -> f64,
    get_mut: fn(&mut Entry) -> &mut f64,
}

const PARTS: [Part; 6] = [
    Part { odd_x: false, odd_y: false, get: |i| i.xx, get_mut: |i| &mut i.xx },
    Part { odd_x: true, odd_y: true, get: |i| i.xy, get_mut: |i| &mut i.xy },
    Part { odd_x: false, odd_y: false, get: |i| i.yy, get_mut: |i| &mut i.yy },
    Part { odd_x: true, odd_y: false, get: |i| i.xz, get_mut: |i| &mut i.xz },
    Part { odd_x: false, odd_y: true, get: |i| i.yz, get_mut: |i| &mut i.yz },
    Part { odd_x: false, odd_y: false, get: |i| i.zz, get_mut: |i| &mut i.zz },
];
