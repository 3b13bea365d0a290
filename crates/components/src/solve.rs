//! The root of a function of one variable in a bracket.

/// Most evaluations of the function in one search: three per bisection, 41 bisections.
pub const EVALUATIONS: usize = 123;

/// The argument between the limits at which the rising function `f` has the value `y`: regula falsi
/// (Illinois), with a bisection at every third step so that the bracket shrinks in any case.
#[must_use]
pub fn rising(y: f64, limits: [f64; 2], mut f: impl FnMut(f64) -> f64) -> f64 {
    let [mut low, mut high] = limits;
    let tolerance = 1e-12 * (high - low);
    let (mut below, mut above) = (f(low) - y, f(high) - y);
    if below >= 0.0 {
        return low;
    }
    if above <= 0.0 {
        return high;
    }
    let mut side = 0;
    for k in 0..EVALUATIONS - 2 {
        if high - low <= tolerance {
            break;
        }
        let secant = low - below * (high - low) / (above - below);
        let inside = secant > low && secant < high;
        let x = if k % 3 == 2 || !inside { low + 0.5 * (high - low) } else { secant };
        let residual = f(x) - y;
        if residual == 0.0 {
            return x;
        }
        if residual < 0.0 {
            (low, below) = (x, residual);
            above *= if side == -1 { 0.5 } else { 1.0 };
            side = -1;
        } else {
            (high, above) = (x, residual);
            below *= if side == 1 { 0.5 } else { 1.0 };
            side = 1;
        }
    }
    low + 0.5 * (high - low)
}

/// The root in the bracket of a function that is below zero at its low end and above at its high one,
/// from a guess and the function's slope: Newton's method, with a bisection wherever it would leave
/// the bracket or shrink it too slowly. Within 10⁻¹² of the bracket's width after at most 100
/// evaluations; near the root three to five.
#[must_use]
pub fn newton(limits: [f64; 2], guess: f64, mut f: impl FnMut(f64) -> [f64; 2]) -> f64 {
    let [mut low, mut high] = limits;
    let tolerance = 1e-12 * (high - low);
    let mut x = if guess > low && guess < high { guess } else { low + 0.5 * (high - low) };
    let mut last = high - low;
    for _ in 0..100 {
        let [value, slope] = f(x);
        if value < 0.0 {
            low = x;
        } else if value > 0.0 {
            high = x;
        } else {
            break;
        }
        let next = x - value / slope;
        let step = (next - x).abs();
        // Not faster than bisection, or out of the bracket, or no number.
        let newton = next > low && next < high && step < 0.5 * last;
        let next = if newton { next } else { low + 0.5 * (high - low) };
        last = if newton { step } else { high - low };
        let done = (next - x).abs() <= tolerance || high - low <= tolerance;
        x = next;
        if done {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_root_of_functions_with_corners_and_plateaus() {
        let corner = |x: f64| if x < 1.0 { 1e-3 * x } else { 5.0 * x - 4.999 };
        for y in [-0.05, 1e-6, 1e-3, 3.0, 100.0] {
            let x = rising(y, [-100.0, 150.0], corner);
            assert!((corner(x) - y).abs() < 5.0 * 250e-12, "{y}: {x}");
        }
        let x = rising(0.5, [-1e3, 1e3], |x: f64| (x - 2.0).powi(9));
        assert!(((x - 2.0).powi(9) - 0.5).abs() < 1e-7);
    }

    #[test]
    fn newton_finds_the_root_from_any_guess_and_across_corners() {
        let corner = |x: f64| {
            let [value, slope] = if x < 1.0 { [1e-3 * x, 1e-3] } else { [5.0 * x - 4.999, 5.0] };
            [value - 3.0, slope]
        };
        let falling_back = |x: f64| {
            let (e, r) = ((-x * x).exp(), x.signum());
            [x + r * (1.0 + e) - 2.5, 1.0 - 2.0 * x * r * e]
        };
        for guess in [-200.0, -99.0, 0.0, 1.0, 1.6, 149.0, f64::NAN] {
            let x = newton([-100.0, 150.0], guess, corner);
            assert!((x - 7.999 / 5.0).abs() < 250e-12, "{guess}: {x}");
            let x = newton([-5.0, 5.0], guess, falling_back);
            assert!(falling_back(x)[0].abs() < 1e-10, "{guess}: {x}");
        }
    }

    #[test]
    fn values_out_of_reach_give_the_nearest_limit() {
        assert_eq!(rising(9.0, [-1.0, 2.0], |x| x), 2.0);
        assert_eq!(rising(-9.0, [-1.0, 2.0], |x| x), -1.0);
    }
}
