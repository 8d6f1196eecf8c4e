//! Draws that may need several tries: the first ones of many particles side by side, the last ones one by one.

use rand::RngExt;
use rand_distr::StandardNormal;

use super::needs::Needs;
use crate::Stream;
use crate::batch::by_widest_vectors;

/// Random numbers of one try: a standard normal one, and two that are uniform on `[0, 1)`. Those that [`Rejection::NEEDS`] does not name are 0.
#[derive(Debug, Clone, Copy)]
pub(in crate::equations) struct Try<T> {
    pub(in crate::equations) normal: T,
    pub(in crate::equations) uniforms: [T; 2],
}

impl<const W: usize> Try<&[f64; W]> {
    /// What one particle has of it.
    #[inline(always)]
    fn of(&self, lane: usize) -> Try<f64> {
        Try { normal: self.normal[lane], uniforms: self.uniforms.map(|uniform| uniform[lane]) }
    }
}

/// What a first try has come to where it is not accepted, in the place of a number; what is drawn is never negative.
pub(in crate::equations) const UNDECIDED: f64 = -1.0;

/// A way to draw a number of a distribution with up to two parameters by trying until a try is accepted.
pub(in crate::equations) trait Rejection {
    /// What a try takes.
    const NEEDS: Needs;

    /// Writes what a try of each particle has drawn: [`UNDECIDED`] where the quick tests do not say whether it is accepted, NaN where it is rejected or a parameter is out of
    /// range. Without branches, for vector instructions.
    fn quick<const W: usize>(a: &[f64; W], b: &[f64; W], random: &Try<&[f64; W]>, drawn: &mut [f64; W]);

    /// A draw, of which the first try is given; NaN where a parameter is out of range.
    fn draw(a: f64, b: f64, first: Try<f64>, stream: &mut Stream) -> f64;
}

/// Particles that are rejected and tried again side by side, if they are more than a quarter of it.
const AGAIN: usize = 8;

/// Writes draws of the first `particles`, of which the first try is given; the others hold anything.
#[inline(always)]
pub(in crate::equations) fn draw_all<M: Rejection, const W: usize>(
    a: &[f64; W],
    b: &[f64; W],
    first: &Try<&[f64; W]>,
    particles: usize,
    stream: &mut Stream,
    drawn: &mut [f64; W],
) {
    M::quick(a, b, first, drawn);
    // Few are left, and which ones is chance: a bit for each costs less than a branch for each.
    let mut left = by_widest_vectors(
        #[inline(always)]
        || {
            const { assert!(W <= 64) };
            let mut left = 0_u64;
            for (lane, drawn) in drawn.iter().enumerate() {
                let is_accepted = *drawn >= 0.0;
                left |= u64::from(!is_accepted) << lane;
            }
            left
        },
    );
    if particles < W {
        left &= (1 << particles) - 1;
    }
    let (mut rejected, mut count) = ([0; W], 0);
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        left &= left - 1;
        if drawn[lane] == UNDECIDED {
            drawn[lane] = alone::<M>(a[lane], b[lane], first.of(lane), stream);
        } else {
            rejected[count] = lane;
            count += 1;
        }
    }
    for lanes in rejected[..count].chunks(AGAIN) {
        if lanes.len() > AGAIN / 4 {
            again::<M, W>(a, b, lanes, drawn, stream);
        } else {
            for lane in lanes {
                drawn[*lane] = alone::<M>(a[*lane], b[*lane], fresh::<M>(stream), stream);
            }
        }
    }
}

/// Tries of some particles that were rejected: once side by side, and then one by one.
fn again<M: Rejection, const W: usize>(
    a: &[f64; W],
    b: &[f64; W],
    lanes: &[usize],
    drawn: &mut [f64; W],
    stream: &mut Stream,
) {
    let (mut normals, mut uniforms) = ([0.0; AGAIN], [[0.0; AGAIN]; 2]);
    let mut found = [f64::NAN; AGAIN];
    // Places without a particle do what the first one does.
    let [mut own_a, mut own_b] = [a, b].map(|of_all| [of_all[lanes[0]]; AGAIN]);
    for (at, lane) in lanes.iter().enumerate() {
        let fresh = fresh::<M>(stream);
        normals[at] = fresh.normal;
        [uniforms[0][at], uniforms[1][at]] = fresh.uniforms;
        [own_a[at], own_b[at]] = [a[*lane], b[*lane]];
    }
    let random = Try { normal: &normals, uniforms: uniforms.each_ref() };
    M::quick(&own_a, &own_b, &random, &mut found);
    for (at, lane) in lanes.iter().enumerate() {
        drawn[*lane] = match found[at] {
            accepted if accepted >= 0.0 => accepted,
            undecided if undecided == UNDECIDED => alone::<M>(own_a[at], own_b[at], random.of(at), stream),
            _ => alone::<M>(own_a[at], own_b[at], fresh::<M>(stream), stream),
        };
    }
}

/// A draw by itself. Its logarithms are fused multiplications, which a processor does at once where the function is compiled for them.
#[inline(never)]
fn alone<M: Rejection>(a: f64, b: f64, first: Try<f64>, stream: &mut Stream) -> f64 {
    by_widest_vectors(
        #[inline(always)]
        || M::draw(a, b, first, stream),
    )
}

/// Random numbers of another try.
fn fresh<M: Rejection>(stream: &mut Stream) -> Try<f64> {
    let normal = if M::NEEDS.normals > 0 { stream.sample(StandardNormal) } else { 0.0 };
    let mut uniforms = [0.0; 2];
    uniforms[..M::NEEDS.uniforms].fill_with(|| stream.random());
    Try { normal, uniforms }
}
