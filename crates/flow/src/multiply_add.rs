//! A product and a sum in one instruction, in loops that the compiler vectorises.

use fearless_simd::{Level, Simd};

/// `a · b + c`, rounded once if the instruction set of the caller has an instruction for it, otherwise twice: `f32::mul_add` would
/// then be a slow call. Registers have a method of their own.
#[inline(always)]
pub(crate) fn multiply_add<S: Simd>(simd: S, a: f32, b: f32, c: f32) -> f32 {
    if is_fused(simd.level()) { a.mul_add(b, c) } else { a * b + c }
}

/// Known when the caller is compiled.
#[inline(always)]
fn is_fused(level: Level) -> bool {
    #[cfg(target_arch = "x86_64")]
    return matches!(level, Level::Avx2(_) | Level::Avx512(_));
    #[cfg(target_arch = "aarch64")]
    return matches!(level, Level::Neon(_));
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    return false;
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::dispatch;

    #[test]
    fn a_product_is_added_at_every_level() {
        for level in crate::instruction_sets::levels() {
            for (a, b, c) in [(2.0, 3.0, 4.0), (-0.5, 8.0, 1.0), (1.0 + f32::EPSILON, 1.0 - f32::EPSILON, -1.0)] {
                let found = dispatch!(level, simd => multiply_add(simd, a, b, c));
                assert!((found - (a * b + c)).abs() <= f32::EPSILON * f32::EPSILON, "{level:?}: {a} {b} {c}: {found}");
            }
        }
    }
}
