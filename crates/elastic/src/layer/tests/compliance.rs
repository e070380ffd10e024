use super::super::compliance::Reduced;
use super::*;

const RATIOS: [f64; 5] = [0.0, 0.2, 0.35, 0.48, 0.499];

/// The state of a wave `e^{ikx}`, `k = μ = 1`, at a depth: `u_x = i V`, `u_z = W`, `σ_xz = i T`, `σ_zz = Z`.
type State = [f64; 4];

/// Its change with depth: Hooke's law for the displacements, equilibrium for the stresses.
fn change([v, w, t, z]: State, lambda: f64) -> State {
    let stiff = lambda + 2.0;
    let stretch = (z + lambda * v) / stiff;
    [t - w, stretch, stiff * v - lambda * stretch, t]
}

/// The states at the surface that the two free choices at the bonded base lead to, by the rule of Runge and Kutta.
fn shoot(q: f64, nu: f64) -> [State; 2] {
    let lambda = 2.0 * nu / (1.0 - 2.0 * nu);
    let steps = 4000;
    let step = -q / f64::from(steps);
    let moved = |state: State, by: f64, slope: State| std::array::from_fn(|i| state[i] + by * slope[i]);
    [[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]].map(|base: State| {
        (0..steps).fold(base, |state, _| {
            let first = change(state, lambda);
            let second = change(moved(state, 0.5 * step, first), lambda);
            let third = change(moved(state, 0.5 * step, second), lambda);
            let fourth = change(moved(state, step, third), lambda);
            std::array::from_fn(|i| state[i] + step / 6.0 * (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]))
        })
    })
}

#[test]
fn the_closed_form_solves_the_equations_of_the_layer() {
    for q in [0.01, 0.1, 0.3, 0.49, 0.51, 1.0, 2.0, 4.0, 8.0] {
        for nu in RATIOS {
            let [a, b] = shoot(q, nu);
            // Tractions t_x = −i T and t_z = −Z; displacements (V, W) by (T, Z).
            let determinant = a[2] * b[3] - a[3] * b[2];
            let by_t = [0, 1].map(|i| (a[i] * b[3] - b[i] * a[3]) / determinant);
            let by_z = [0, 1].map(|i| (b[i] * a[2] - a[i] * b[2]) / determinant);
            let reduced = Reduced::at(q, nu);
            let what = format!("q {q}, ν {nu}");
            assert_near(reduced.longitudinal, -by_t[0], 1e-9, &what);
            assert_near(reduced.normal, -by_z[1], 1e-9, &what);
            assert!((reduced.coupling + by_z[0]).abs() < 1e-9 * reduced.normal.abs(), "{what}");
            assert!((reduced.coupling + by_t[1]).abs() < 1e-9 * reduced.normal.abs(), "{what}");
        }
    }
}

#[test]
fn across_the_wave_it_is_plain_shear() {
    let layer = layer(0.35);
    let mu = layer.shear_modulus_mpa();
    for k in [1e-6, 0.01, 0.3, 5.0] {
        assert_near(layer.wave_compliance(k).transverse, (k * 10.0_f64).tanh() / (mu * k), 1e-14, "S");
    }
}

#[test]
fn long_waves_shear_and_compress_uniformly() {
    for nu in RATIOS {
        let layer = layer(nu);
        let mu = layer.shear_modulus_mpa();
        let shear = 10.0 / mu;
        let compression = 10.0 * (1.0 - 2.0 * nu) / (2.0 * mu * (1.0 - nu));
        for k in [0.0, 1e-200, 1e-20, 1e-6] {
            let wave = layer.wave_compliance(k);
            assert_near(wave.longitudinal, shear, 1e-7, "L");
            assert_near(wave.transverse, shear, 1e-7, "S");
            assert_near(wave.normal, compression, 1e-7, "N");
            assert!(wave.coupling.abs() <= 1e-4 * shear, "C {}", wave.coupling);
        }
        // The next term goes with q², and is most where the gel hardly compresses; at ν = 0 there is none.
        if nu > 0.0 {
            let [small, smaller] = [1e-2, 1e-3].map(|q| layer.wave_compliance(q / 10.0).normal / compression - 1.0);
            assert_near(small, 100.0 * smaller, 5e-3, "the second term");
        }
    }
}

#[test]
fn short_waves_see_a_half_space() {
    for nu in RATIOS {
        let (layer, half_space) = (layer(nu), half_space(nu));
        let mu = layer.shear_modulus_mpa();
        for k in [4.0, 29.0, 31.0, 1e3, 1e8, 1e300] {
            let wave = layer.wave_compliance(k);
            assert_eq!(half_space.wave_compliance(k), half_space.wave_compliance(k));
            for (value, expected) in [
                (wave.longitudinal, 1.0 - nu),
                (wave.transverse, 1.0),
                (wave.normal, 1.0 - nu),
                (wave.coupling, 0.5 * (1.0 - 2.0 * nu)),
            ] {
                assert_near(mu * k * value, expected, 1e-13, &format!("k {k}, ν {nu}"));
            }
            assert_near(half_space.wave_compliance(k).normal, wave.normal, 1e-13, "the half-space itself");
        }
    }
    assert!(half_space(0.3).wave_compliance(0.0).normal.is_infinite());
}

#[test]
fn the_matrix_is_hermitian_and_positive_definite() {
    for nu in RATIOS {
        for layer in [layer(nu), half_space(nu)] {
            for k in [1e-3_f64, 0.05, 0.2, 1.0, 7.0, 100.0] {
                for angle in [0.0_f64, 0.4, 2.0, 4.0] {
                    let u = layer.compliance([k * angle.cos(), k * angle.sin()]);
                    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                        assert!((u[i][j] - u[j][i].conj()).norm() < 1e-15 * u[0][0].norm());
                    }
                    // Leading minors.
                    let second = (u[0][0] * u[1][1] - u[0][1] * u[1][0]).re;
                    let wave = layer.wave_compliance(k);
                    let third = wave.transverse * (wave.longitudinal * wave.normal - wave.coupling.powi(2));
                    assert!(u[0][0].re > 0.0 && second > 0.0 && third > 0.0, "k {k}, ν {nu}");
                }
            }
        }
    }
}

#[test]
fn the_matrix_turns_with_the_wave() {
    let layer = layer(0.35);
    let along_x = layer.compliance([0.2, 0.0]);
    let wave = layer.wave_compliance(0.2);
    assert_near(along_x[0][0].re, wave.longitudinal, 1e-15, "xx");
    assert_near(along_x[1][1].re, wave.transverse, 1e-15, "yy");
    // Short waves of pressure draw the surface towards where they press: u_x leads by a quarter of a wave.
    let short = layer.compliance([3.0, 0.0]);
    assert!(short[0][2].im > 0.0 && short[2][0].im < 0.0);
    let (cos, sin) = (0.6, 0.8);
    let turned = layer.compliance([0.2 * cos, 0.2 * sin]);
    assert_near(turned[0][1].re, cos * sin * (wave.longitudinal - wave.transverse), 1e-13, "xy");
    assert_near(turned[1][2].im, sin * wave.coupling, 1e-13, "yz");
    assert_near(layer.compliance([0.0; 2])[1][1].re, wave_at_rest(&layer), 1e-15, "uniform");
}

fn wave_at_rest(layer: &Layer) -> f64 {
    layer.wave_compliance(0.0).transverse
}

#[test]
fn a_block_without_stiffness_or_sense_is_refused() {
    let error = Layer::new(&GelBlock { youngs_modulus_mpa: None, ..block(0.3) }).unwrap_err();
    assert_eq!(error, LayerError::NoModulus);
    let error = Layer::new(&GelBlock { thickness_mm: -1.0, ..block(0.3) }).unwrap_err();
    assert!(error.to_string().starts_with("thickness_mm is -1"), "{error}");
    assert!(Layer::half_space(&block(0.5)).is_err());
}
