//! Projections of whole runs of springs at once, for vector registers.
//!
//! The springs of a run join the particles `a[i]` and `b[i]`; no particle is in a run twice. Particles carry their
//! position at the start of the step, x, and their displacement so far, d; the end of the step is x + d. Displacements
//! are kept apart from positions because they are small: in single precision the sum would round slow motion away.
//! Every run is a whole number of blocks long.

use crate::geometry::Vectors;

/// Lanes that are tested together: where none of them is over its limit, nothing is computed or stored.
pub(super) const BLOCK: usize = 8;

/// One end of the springs of a run.
pub(super) struct End<'a> {
    /// Positions at the start of the step [m].
    pub x: [&'a [f32]; 3],
    /// Displacements so far [m].
    pub d: [&'a mut [f32]; 3],
    /// Inverse masses, zero for what is held.
    pub w: &'a [f32],
}

/// When and how far a spring is pulled together, as parts of its greatest length R.
#[derive(Clone, Copy)]
pub(in super::super) struct Pull {
    /// Springs longer than this are pulled ..
    pub trigger: f32,
    /// .. to this length ..
    pub aim: f32,
    /// .. by this part of the way.
    pub part: f32,
}

/// Projects every spring of a run that is over its trigger.
#[inline(always)]
pub(super) fn project(a: End<'_>, b: End<'_>, limit: &[f32], pull: Pull) {
    let len = limit.len();
    let [ax, ay, az] = a.x.map(|values| &values[..len]);
    let [bx, by, bz] = b.x.map(|values| &values[..len]);
    let [au, av, aw] = a.d.map(|values| &mut values[..len]);
    let [bu, bv, bw] = b.d.map(|values| &mut values[..len]);
    let (wa, wb, limit) = (&a.w[..len], &b.w[..len], &limit[..len]);
    for start in (0..len).step_by(BLOCK) {
        let (mut y, mut square) = ([[0.0_f32; BLOCK]; 3], [0.0_f32; BLOCK]);
        let mut active = 0_u32;
        for lane in 0..BLOCK {
            let i = start + lane;
            y[0][lane] = (bx[i] - ax[i]) + (bu[i] - au[i]);
            y[1][lane] = (by[i] - ay[i]) + (bv[i] - av[i]);
            y[2][lane] = (bz[i] - az[i]) + (bw[i] - aw[i]);
            square[lane] = y[0][lane] * y[0][lane] + y[1][lane] * y[1][lane] + y[2][lane] * y[2][lane];
            let trigger = limit[i] * pull.trigger;
            active |= u32::from(square[lane] > trigger * trigger);
        }
        if active == 0 {
            continue;
        }
        for lane in 0..BLOCK {
            let i = start + lane;
            let length = square[lane].sqrt();
            let excess = if length > limit[i] * pull.trigger { length - limit[i] * pull.aim } else { 0.0 };
            // The floor keeps two held ends, and the empty lanes at the end of a run, from dividing by zero.
            let share = pull.part * excess / (length * (wa[i] + wb[i])).max(1e-30);
            let (share_a, share_b) = (share * wa[i], share * wb[i]);
            au[i] += share_a * y[0][lane];
            av[i] += share_a * y[1][lane];
            aw[i] += share_a * y[2][lane];
            bu[i] -= share_b * y[0][lane];
            bv[i] -= share_b * y[1][lane];
            bw[i] -= share_b * y[2][lane];
        }
    }
}

/// Largest (|X_uv + D_uv| / R)^2 of the run whose ends begin at `a` and `b`.
#[inline(always)]
pub(super) fn worst(x: &Vectors, d: &Vectors, a: usize, b: usize, limit: &[f32]) -> f32 {
    let len = limit.len();
    let [ax, ay, az] = [&x.x[a..a + len], &x.y[a..a + len], &x.z[a..a + len]];
    let [bx, by, bz] = [&x.x[b..b + len], &x.y[b..b + len], &x.z[b..b + len]];
    let [au, av, aw] = [&d.x[a..a + len], &d.y[a..a + len], &d.z[a..a + len]];
    let [bu, bv, bw] = [&d.x[b..b + len], &d.y[b..b + len], &d.z[b..b + len]];
    let mut worst = 0_i32;
    for i in 0..len {
        let px = (bx[i] - ax[i]) + (bu[i] - au[i]);
        let py = (by[i] - ay[i]) + (bv[i] - av[i]);
        let pz = (bz[i] - az[i]) + (bw[i] - aw[i]);
        let ratio = (px * px + py * py + pz * pz) / (limit[i] * limit[i]);
        // Non-negative floats order like their bits, and integer maxima vectorise.
        worst = worst.max(ratio.to_bits().cast_signed());
    }
    f32::from_bits(worst.cast_unsigned())
}
