//! Properties that the elements must have in every use.

use super::element::{self, Stiffness, evaluate};
use super::{Assembly, BlockMesh, Material, graded_lines};
use crate::Law;
use crate::solver::{Grid, Multigrid, OWN, Solver, Stencil, Stop, column};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

fn noise(rng: &mut Pcg64Mcg, size: f64) -> f64 {
    size * (f64::from(rng.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0)
}

fn distorted_cube(rng: &mut Pcg64Mcg) -> [[f64; 3]; 8] {
    std::array::from_fn(|node| [0, 1, 2].map(|axis| f64::from(u8::from(node >> axis & 1 == 1)) + noise(rng, 0.15)))
}

fn entry(stiffness: &Stiffness, (a, i): (usize, usize), (b, j): (usize, usize)) -> f64 {
    stiffness[i][j][a][b]
}

#[test]
fn forces_and_stiffness_are_derivatives() {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    for (law, nu) in [(Law::NeoHookean, 0.35), (Law::NeoHookean, 0.49), (Law::Linear, 0.48)] {
        let material = Material::new(law, 0.6, nu);
        let nodes = distorted_cube(&mut rng);
        let rest: [[f64; 3]; 8] = std::array::from_fn(|_| [(); 3].map(|()| noise(&mut rng, 0.15)));
        let mut stiffness = [[[[0.0; 8]; 8]; 3]; 3];
        let (_, forces) = evaluate(&nodes, &rest, &material).unwrap();
        element::stiffness(&nodes, &rest, &material, &mut stiffness).unwrap();
        let scale = stiffness.as_flattened().as_flattened().as_flattened().iter().fold(0.0_f64, |m, k| m.max(k.abs()));
        let step = 1e-5;
        for (b, j) in (0..24).map(|n| (n / 3, n % 3)) {
            let moved = |by: f64| {
                let mut moved = rest;
                moved[b][j] += by;
                evaluate(&nodes, &moved, &material).unwrap()
            };
            let ((energy_up, up), (energy_down, down)) = (moved(step), moved(-step));
            let force = (energy_up - energy_down) / (2.0 * step);
            assert!((force - forces[b][j]).abs() < 1e-7 * scale, "{law:?} {nu}: {force}, {}", forces[b][j]);
            for (a, i) in (0..24).map(|n| (n / 3, n % 3)) {
                let slope = (up[a][i] - down[a][i]) / (2.0 * step);
                let tangent = entry(&stiffness, (a, i), (b, j));
                assert!((slope - tangent).abs() < 1e-7 * scale, "{law:?} {nu}: {slope}, {tangent}");
            }
        }
    }
}

#[test]
fn an_element_turned_inside_out_is_noticed() {
    let nodes = std::array::from_fn(|node| [0, 1, 2].map(|axis| f64::from(u8::from(node >> axis & 1 == 1))));
    let squashed = std::array::from_fn(|node| [0.0, 0.0, if node >> 2 == 1 { -1.2 } else { 0.0 }]);
    assert!(evaluate(&nodes, &squashed, &Material::new(Law::NeoHookean, 1.0, 0.3)).is_err());
}

/// A uniform strain that leaves the base at rest.
fn uniform([x, y, z]: [f64; 3], base_mm: f64) -> [f64; 3] {
    let _ = (x, y);
    [0.03, -0.02, 0.05].map(|slope| slope * (base_mm - z))
}

/// Solves for the inner nodes when `prescribed` moves those of the surface and the sides; `load` acts on all.
fn solve(
    assembly: &Assembly,
    prescribed: &dyn Fn([f64; 3]) -> [f64; 3],
    load: &[[f64; 3]],
    refinements: usize,
) -> Vec<[f64; 3]> {
    let grid = assembly.grid;
    let field = || vec![[0.0; 3]; grid.len()];
    let (mut displacement, mut forces) = (field(), field());
    let boundary = boundary_nodes(grid);
    for &(i, j, k) in &boundary {
        displacement[grid.index(i, j, k)] = prescribed(assembly.mesh.node(i, j, k));
    }
    let fixed: Vec<usize> = boundary.iter().map(|&(i, j, k)| grid.index(i, j, k)).collect();
    let project = |field: &mut [[f32; 3]]| fixed.iter().for_each(|&index| field[index] = [0.0; 3]);
    let lines = assembly.mesh.lines();
    let mut multigrid = Multigrid::new([lines[0], lines[1], &lines[2][..grid.nodes[2]]], lines[2][grid.nodes[2]]);
    let mut solver = Solver::new(grid);
    assembly.tangent_into(&displacement, multigrid.finest_mut()).unwrap();
    constrain(multigrid.finest_mut(), &fixed);
    multigrid.refresh();
    // Each solve takes a few digits off what is left.
    for _ in 0..refinements {
        assembly.forces_into(&displacement, &mut forces).unwrap();
        let right: Vec<_> = forces.iter().zip(load).map(|(f, l)| [0, 1, 2].map(|c| l[c] - f[c])).collect();
        let mut step = field();
        let outcome = solver.solve(
            &mut multigrid,
            (&right, &mut step),
            &project,
            Stop { goal: 0.0, tolerance: 1e-4, limit: 100 },
        );
        assert!(!outcome.is_indefinite);
        for (displacement, step) in displacement.iter_mut().zip(&step) {
            *displacement = [0, 1, 2].map(|c| displacement[c] + step[c]);
        }
    }
    displacement
}

/// Cuts nodes off from all others.
fn constrain(matrix: &mut Stencil, fixed: &[usize]) {
    let (slab, row) = (matrix.grid.slab(), matrix.grid.row());
    for &index in fixed {
        for (dx, dy, dz) in (0..27).map(|n: isize| (n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1)) {
            let near = index.cast_signed() + dx + dy * slab.cast_signed() + dz * row.cast_signed();
            let first = column([-dx, -dy, -dz]);
            matrix.rows[near.cast_unsigned()].iter_mut().for_each(|row| row[first..first + 3].fill(0.0));
        }
        matrix.rows[index] = std::array::from_fn(|r| std::array::from_fn(|c| if c == OWN + r { 1.0 } else { 0.0 }));
    }
}

fn boundary_nodes(grid: Grid) -> Vec<(usize, usize, usize)> {
    let [nx, ny, nz] = grid.nodes;
    let all = (0..ny).flat_map(|j| (0..nz).flat_map(move |k| (0..nx).map(move |i| (i, j, k))));
    all.filter(|&(i, j, k)| k == 0 || i == 0 || j == 0 || i == nx - 1 || j == ny - 1).collect()
}

#[test]
fn a_uniform_strain_passes_through_an_uneven_mesh() {
    let mut rng = Pcg64Mcg::seed_from_u64(7);
    let lines = || graded_lines([-2.0, 2.0], [-0.5, 0.7], 0.4, 1.3);
    let mut mesh = BlockMesh::new(lines(), lines(), vec![0.0, 0.3, 0.8, 1.5, 2.0]);
    let [columns, rows, layers] = mesh.cells();
    for (i, j, k) in (1..rows).flat_map(|j| (1..layers).flat_map(move |k| (1..columns).map(move |i| (i, j, k)))) {
        mesh.node_mut(i, j, k).iter_mut().for_each(|place| *place += noise(&mut rng, 0.06));
    }
    for law in [Law::Linear, Law::NeoHookean] {
        let assembly = Assembly::new(mesh.clone(), Material::new(law, 0.6, 0.48));
        let grid = assembly.grid;
        // The patch test: forces on inner nodes vanish, and the solution is the strain itself.
        let exact = |node: [f64; 3]| uniform(node, 2.0);
        let mut displacement = vec![[0.0; 3]; grid.len()];
        let inside: Vec<_> = {
            let boundary = boundary_nodes(grid);
            let [nx, ny, nz] = grid.nodes;
            let all = (0..ny).flat_map(|j| (0..nz).flat_map(move |k| (0..nx).map(move |i| (i, j, k))));
            all.inspect(|&(i, j, k)| displacement[grid.index(i, j, k)] = exact(assembly.mesh.node(i, j, k)))
                .filter(|node| !boundary.contains(node))
                .collect()
        };
        let mut forces = vec![[0.0; 3]; grid.len()];
        assembly.forces_into(&displacement, &mut forces).unwrap();
        let largest =
            |nodes: &mut dyn Iterator<Item = f64>| nodes.fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let scale = largest(&mut forces.as_flattened().iter().copied());
        let rest = largest(&mut inside.iter().flat_map(|&(i, j, k)| forces[grid.index(i, j, k)]));
        assert!(rest < 1e-12 * scale.max(1.0), "{law:?}: {rest} N is left of {scale} N");
        if law == Law::Linear {
            let solution = solve(&assembly, &exact, &vec![[0.0; 3]; grid.len()], 6);
            for (i, j, k) in inside {
                let (found, exact) = (solution[grid.index(i, j, k)], exact(assembly.mesh.node(i, j, k)));
                assert!((0..3).all(|c| (found[c] - exact[c]).abs() < 1e-12), "{found:?}, exact {exact:?}");
            }
        }
    }
}

/// A smooth displacement that leaves the base at rest, mm, over a block 2 mm wide and 1 mm thick.
fn smooth([x, y, z]: [f64; 3]) -> [f64; 3] {
    let rise = (1.0 - z) * (1.0 + 0.5 * z);
    [(1.3 * x + 0.4).sin() * (0.9 * y).cos() * rise, (x - 0.7 * y).cos() * rise, (0.8 * x + 1.1 * y).sin() * rise]
}

/// `−div σ` of the smooth displacement by central differences, N/mm³.
fn body_force(material: &Material, place: [f64; 3]) -> [f64; 3] {
    let step = 1e-3;
    let second = |i: usize, a: usize, b: usize| {
        let at = |da: f64, db: f64| {
            let mut moved = place;
            moved[a] += da * step;
            moved[b] += db * step;
            smooth(moved)[i]
        };
        if a == b {
            (at(1.0, 0.0) - 2.0 * at(0.0, 0.0) + at(-1.0, 0.0)) / (step * step)
        } else {
            (at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0)) / (4.0 * step * step)
        }
    };
    [0, 1, 2].map(|i| {
        let laplacian: f64 = (0..3).map(|a| second(i, a, a)).sum();
        let gradient_of_divergence: f64 = (0..3).map(|a| second(a, i, a)).sum();
        -material.shear_modulus * laplacian - (material.shear_modulus + material.lame) * gradient_of_divergence
    })
}

/// Consistent nodal forces of the body force on a mesh of bricks.
fn load(assembly: &Assembly) -> Vec<[f64; 3]> {
    let (grid, gauss) = (assembly.grid, 0.5 / 3.0_f64.sqrt());
    let mut load = vec![[0.0; 3]; grid.len()];
    let [columns, rows, layers] = assembly.mesh.cells();
    for (i, j, k) in (0..rows).flat_map(|j| (0..layers).flat_map(move |k| (0..columns).map(move |i| (i, j, k)))) {
        let (low, high) = (assembly.mesh.node(i, j, k), assembly.mesh.node(i + 1, j + 1, k + 1));
        let size = [0, 1, 2].map(|c| high[c] - low[c]);
        for point in 0..8 {
            let share = [0, 1, 2].map(|c| 0.5 + if point >> c & 1 == 1 { gauss } else { -gauss });
            let force = body_force(&assembly.material, [0, 1, 2].map(|c| low[c] + share[c] * size[c]));
            for node in (0..8).filter(|node| k + (node >> 2) < grid.nodes[2]) {
                let weight: f64 = (0..3).map(|c| if node >> c & 1 == 1 { share[c] } else { 1.0 - share[c] }).product();
                let index = grid.index(i + (node & 1), j + (node >> 1 & 1), k + (node >> 2));
                for c in 0..3 {
                    load[index][c] += weight * force[c] * size[0] * size[1] * size[2] / 8.0;
                }
            }
        }
    }
    load
}

#[test]
fn the_error_falls_with_the_square_of_the_cell() {
    for nu in [0.3, 0.48] {
        let errors = [4, 8, 16].map(|cells: usize| {
            // Uneven, but refined evenly.
            let line = |n: usize| {
                let share = n as f64 / cells as f64;
                share + 0.1 * (std::f64::consts::TAU * share).sin() / std::f64::consts::TAU
            };
            let across = || (0..=cells).map(|n| 2.0 * line(n) - 1.0).collect::<Vec<_>>();
            let mesh = BlockMesh::new(across(), across(), (0..=cells / 2).map(|n| line(2 * n)).collect());
            let assembly = Assembly::new(mesh, Material::new(Law::Linear, 1.0, nu));
            let solution = solve(&assembly, &smooth, &load(&assembly), 3);
            let [nx, ny, nz] = assembly.grid.nodes;
            let nodes = (0..ny).flat_map(|j| (0..nz).flat_map(move |k| (0..nx).map(move |i| (i, j, k))));
            let squares = nodes.map(|(i, j, k)| {
                let (found, exact) = (solution[assembly.grid.index(i, j, k)], smooth(assembly.mesh.node(i, j, k)));
                (0..3).map(|c| (found[c] - exact[c]).powi(2)).sum::<f64>()
            });
            (squares.sum::<f64>() / (nx * ny * nz) as f64).sqrt()
        });
        let order = (errors[1] / errors[2]).log2();
        assert!(order >= 1.9, "ν {nu}: errors {errors:?} mm, order {order:.3}");
    }
}

#[test]
fn lines_grow_from_where_they_are_fine() {
    let lines = graded_lines([-15.0, 15.0], [-3.0, 5.0], 0.3, 1.2);
    assert_eq!(lines.first().zip(lines.last()), Some((&-15.0, &15.0)));
    let cells: Vec<f64> = lines.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(cells.iter().all(|cell| *cell > 0.1), "{cells:?}");
    assert!(cells.windows(2).all(|pair| pair[0] / pair[1] < 1.5 && pair[1] / pair[0] < 1.5), "{cells:?}");
    assert!(lines.iter().any(|line| (line + 3.0).abs() < 1e-9));
}
