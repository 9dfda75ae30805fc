//! Numbers as JSON can hold them, and as people read them.

use std::fmt;

/// `None` for what JSON has no number for.
pub(crate) fn finite(x: f32) -> Option<f32> {
    x.is_finite().then_some(x)
}

/// [`finite`] in double precision.
pub(crate) fn finite_f64(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

/// Six decimals; `-` for no number.
pub(crate) struct Fixed<T>(pub(crate) Option<T>);

impl<T: fmt::Display> fmt::Display for Fixed<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Some(x) => write!(f, "{x:.6}"),
            None => f.write_str("-"),
        }
    }
}

/// `1 triangle`, `40,000 triangles`; `noun` in the singular.
pub fn counted(number: usize, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{} {noun}{plural}", grouped(number as u64))
}

/// `995,328,000,000`.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> = digits
        .as_bytes()
        .rchunks(3)
        .rev()
        .filter_map(|group| str::from_utf8(group).ok())
        .collect();
    groups.join(",")
}

/// Four digits that count: a number to look at, not to compute with.
pub(crate) fn short(x: f32) -> String {
    match x.abs() {
        0.0 => "0".to_owned(),
        size if (1e-3..1e6).contains(&size) => {
            let decimals = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
            let fixed = format!("{x:.decimals$}");
            match fixed.contains('.') {
                true => fixed.trim_end_matches('0').trim_end_matches('.').to_owned(),
                false => fixed,
            }
        }
        _ => format!("{x:.3e}"),
    }
}

/// `(1, 2.5, 3)`.
pub(crate) fn point(p: [f32; 3]) -> String {
    format!("({})", p.map(short).join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_numbers_keep_four_digits_and_no_empty_decimals() {
        let cases = [
            (0.0, "0"),
            (278.0, "278"),
            (12.3456, "12.35"),
            (-0.5, "-0.5"),
            (0.012_345, "0.01235"),
            (123_456.0, "123456"),
            (1e-9, "1.000e-9"),
            (5e29, "5.000e29"),
        ];
        for (x, text) in cases {
            assert_eq!(short(x), text);
        }
    }
}
