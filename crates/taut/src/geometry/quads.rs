//! Vectors of 16 bytes each, so that any of them is loaded at once; the fourth number is whatever it is kept for.

use glam::{Mat4, Vec4};

use super::{Pool, Vectors, for_each_chunk};

/// Writes `vectors`, those of `first` and following, with zero as the fourth number.
pub fn fill_quads(quads: &mut [Vec4], vectors: &Vectors, first: usize, pool: &Pool) {
    for_each_chunk(quads, pool, |start, chunk| {
        let run = first + start..first + start + chunk.len();
        let [x, y, z] = vectors.columns().map(|column| &column[run.clone()]);
        chunk.iter_mut().zip(x.iter().zip(y).zip(z)).for_each(|(quad, ((x, y), z))| *quad = Vec4::new(*x, *y, *z, 0.0));
    });
}

/// The coordinates of four vectors, one by one.
#[inline(always)]
#[must_use]
pub fn by_axis([a, b, c, d]: [Vec4; 4]) -> [Vec4; 3] {
    let by_axis = Mat4::from_cols(a, b, c, d).transpose();
    [by_axis.x_axis, by_axis.y_axis, by_axis.z_axis]
}

/// Back from [`by_axis`], with zero as the fourth number.
#[inline(always)]
#[must_use]
pub fn by_vector([x, y, z]: [Vec4; 3]) -> [Vec4; 4] {
    let Mat4 { x_axis, y_axis, z_axis, w_axis } = Mat4::from_cols(x, y, z, Vec4::ZERO).transpose();
    [x_axis, y_axis, z_axis, w_axis]
}

/// From the quads `a` to the quads `b`, each coordinate of all four. Written out, as what follows is: `array::map` and closures
/// are not always inlined into a function that is compiled for wider registers, and a call costs more than the work.
#[inline(always)]
#[must_use]
pub fn differences(quads: &[Vec4], [a, b]: &[[u32; 4]; 2]) -> [Vec4; 3] {
    by_axis([
        quads[b[0] as usize] - quads[a[0] as usize],
        quads[b[1] as usize] - quads[a[1] as usize],
        quads[b[2] as usize] - quads[a[2] as usize],
        quads[b[3] as usize] - quads[a[3] as usize],
    ])
}

/// Square roots, the same on every machine.
#[inline(always)]
#[must_use]
pub fn roots(squares: Vec4) -> Vec4 {
    let [a, b, c, d] = squares.to_array();
    Vec4::new(a.sqrt(), b.sqrt(), c.sqrt(), d.sqrt())
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn vectors_come_out_as_they_went_in() {
        let vectors: Vectors = (0..6).map(|i| Vec3::new(1.0, 2.0, 3.0) * i as f32).collect();
        let mut quads = [Vec4::ONE; 4];
        fill_quads(&mut quads, &vectors, 2, &Pool::new(1));
        for (quad, index) in quads.iter().zip(2..) {
            assert_eq!(*quad, vectors.get(index).extend(0.0));
        }
        assert_eq!(by_axis(quads)[1], Vec4::new(4.0, 6.0, 8.0, 10.0));
        assert_eq!(by_vector(by_axis(quads)), quads);
    }
}
