//! Blocks of plays.

use crate::block::{Block, Wires};

/// One play: `max(u − r, min(u + r, p))`.
#[inline]
pub(crate) fn play(r: f64, u: f64, p: f64) -> f64 {
    (u - r).max((u + r).min(p))
}

/// One step of a block of plays.
pub(crate) fn step(block: &Block, p: &[f64], w: Wires, z: &mut [f64]) -> f64 {
    let u = w.drive;
    match block {
        Block::Plays { r, slope } => {
            let (linear, weights) = p.split_at(usize::from(*slope).min(p.len()));
            let mut y = w.x + linear.first().map_or(0.0, |g| g * u);
            for ((r, weight), z) in r.iter().zip(weights).zip(z) {
                *z = play(*r, u, *z);
                y += weight * (*z - u);
            }
            y
        }
        Block::SkewedPlays { r, centre, half } => {
            let place = (u - centre) / half;
            let mut y = w.x;
            for ((r, weight), z) in r.iter().zip(p).zip(z) {
                *z = play(*r, u, *z);
                y += weight * (*z - u) * place;
            }
            y
        }
        Block::CurvedPlays { r, w: weights, centre, half } => {
            let place = (u - centre) / half;
            let curvature = p.first().copied().unwrap_or(0.0);
            let mut y = w.x;
            for ((r, weight), z) in r.iter().zip(weights).zip(z.chunks_exact_mut(2)) {
                let wide = (r + curvature * r * place).max(0.0);
                z[0] = (u - wide).max((u + wide).min(z[0]));
                z[1] = play(*r, u, z[1]);
                y += weight * (z[0] - z[1]);
            }
            y
        }
        Block::BentPlays { r, w: weights, centre, half } => {
            let &[a, b, c, d] = p else { return w.x };
            let place = (u - centre) / half;
            let low = u + half * place * (a + b * place);
            let high = u + half * place * (c + d * place);
            let mut y = w.x;
            for ((r, weight), z) in r.iter().zip(weights).zip(z.chunks_exact_mut(2)) {
                z[0] = (low - r).max((high + r).min(z[0]));
                z[1] = play(*r, u, z[1]);
                y += weight * (z[0] - z[1]);
            }
            y
        }
        Block::GeneralisedPlay { centre, half } => {
            let (&[weight, constant, linear, square], [z]) = (p, z) else { return w.x };
            let place = (u - centre) / half;
            let width = half * (constant + place * (linear + place * square)).max(0.0);
            *z = play(width, u, *z);
            w.x + weight * (*z - u)
        }
        Block::BoucWen => {
            let (&[gain, width, turning], [h, before]) = (p, z) else { return w.x };
            let way = (u - *before) / width;
            *before = u;
            *h = turn(*h, way, turning);
            w.x - gain * width * *h
        }
        _ => w.x,
    }
}

/// The state h of a Bouc–Wen element after a way of its width, in parts of at most a tenth of it.
fn turn(mut h: f64, way: f64, turning: f64) -> f64 {
    let parts = (way.abs() / 0.1).ceil().clamp(1.0, 100.0);
    let d = way / parts;
    for _ in 0..parts as usize {
        h += d * (1.0 - (turning * (d * h).signum() + 1.0 - turning) * h * h);
    }
    h
}
