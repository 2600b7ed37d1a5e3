//! Special functions for p-values, in double precision.

/// ln Gamma(x) for x > 0 \[Lanczos64\], to about 1e-13.
pub(crate) fn ln_gamma(x: f64) -> f64 {
    const G: f64 = 7.0;
    const C: [f64; 9] = [
        0.999_999_999_999_809_9,
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    if x < 0.5 {
        return (std::f64::consts::PI / (std::f64::consts::PI * x).sin()).ln() - ln_gamma(1.0 - x);
    }
    let x = x - 1.0;
    let sum = C[1..].iter().enumerate().fold(C[0], |s, (i, c)| s + c / (x + 1.0 + i as f64));
    let t = x + G + 0.5;
    0.5 * (2.0 * std::f64::consts::PI).ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

/// The upper regularised incomplete gamma function Q(a, x): by its series for x < a + 1, else by a continued fraction
/// [Press07, 6.2].
pub(crate) fn gamma_q(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let scale = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-16 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - scale * sum;
    }
    scale
        * lentz(x + 1.0 - a, |i| {
            let i = i as f64;
            (-i * (i - a), x + 2.0 * i + 1.0 - a)
        })
}

/// The regularised incomplete beta function I_x(a, b) [Press07, 6.4].
pub(crate) fn beta_i(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta_i(b, a, 1.0 - x);
    }
    let front =
        (ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * (1.0 - x).ln()).exp() / a;
    let fraction = lentz(1.0, |i| {
        let m = (i / 2) as f64;
        let coefficient = if i % 2 == 0 {
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        } else {
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        };
        (coefficient, 1.0)
    });
    front * fraction
}

/// 1 / (b0 + a1 / (b1 + a2 / (b2 + ...))) by Lentz's method; `next(i)` is (a_i, b_i).
fn lentz(b0: f64, next: impl Fn(u32) -> (f64, f64)) -> f64 {
    let keep = |v: f64| if v.abs() < 1e-300 { 1e-300 } else { v };
    let mut c = 1e300;
    let mut d = 1.0 / keep(b0);
    let mut value = d;
    for i in 1..10_000 {
        let (a, b) = next(i);
        d = 1.0 / keep(a * d + b);
        c = keep(b + a / c);
        let change = c * d;
        value *= change;
        if (change - 1.0).abs() < 1e-15 {
            break;
        }
    }
    value
}

/// Probability that a standard normal number has a magnitude larger than `z`.
pub(crate) fn normal_two_sided(z: f64) -> f64 {
    gamma_q(0.5, 0.5 * z * z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        let close =
            |a: f64, b: f64| assert!((a - b).abs() < 1e-9 * b.abs().max(1e-3), "{a} is not {b}");
        close(ln_gamma(5.0), 24f64.ln());
        close(ln_gamma(0.5), std::f64::consts::PI.sqrt().ln());
        // The tail of the chi^2 distribution with one degree of freedom at 3.841...: five per cent.
        close(gamma_q(0.5, 3.841_458_820_694_124 / 2.0), 0.05);
        close(gamma_q(5.0, 18.307_038_053_275_143 / 2.0), 0.05);
        close(normal_two_sided(1.959_963_984_540_054), 0.05);
        close(beta_i(2.0, 3.0, 0.4), 0.5248);
        close(beta_i(3.0, 2.0, 0.6), 1.0 - 0.5248);
    }
}
