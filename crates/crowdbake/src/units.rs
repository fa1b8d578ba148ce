//! Numbers as people read them: lengths with a fitting unit, shares in percent.

/// A length with about three digits: `1.72 m`, `12.3 mm`, `0.46 mm`, `4.6 µm`.
pub(crate) fn length(metres: f32) -> String {
    let mm = f64::from(metres) * 1e3;
    match mm.abs() {
        size if !size.is_finite() => "-".to_owned(),
        size if size >= 1e6 => format!("{:.0} m", mm / 1e3),
        size if size >= 1e3 => format!("{:.2} m", mm / 1e3),
        size if size >= 100.0 => format!("{mm:.0} mm"),
        size if size >= 1.0 => format!("{mm:.1} mm"),
        size if size >= 0.01 => format!("{mm:.2} mm"),
        size if size < 5e-5 => "0 mm".to_owned(),
        _ => format!("{:.1} µm", mm * 1e3),
    }
}

/// A share in percent: `100 %`, `6.8 %`, `0.25 %`.
pub(crate) fn percent(share: f64) -> String {
    let percent = share * 100.0;
    let text = match percent {
        p if p >= 99.95 => format!("{p:.0}"),
        p if p >= 1.0 => format!("{p:.1}"),
        p => format!("{p:.2}"),
    };
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text };
    format!("{text} %")
}

/// A count and what is counted: `1 clip`, `3 clips`.
pub(crate) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_choose_their_unit() {
        let found = [1.715, 0.0123, 0.000_46, 0.000_004_6, 1e-8, 0.25, f32::INFINITY].map(length);
        assert_eq!(found, ["1.72 m", "12.3 mm", "0.46 mm", "4.6 µm", "0 mm", "250 mm", "-"]);
    }

    #[test]
    fn one_is_not_many() {
        assert_eq!([0, 1, 2].map(|n| counted(n, "clip")), ["0 clips", "1 clip", "2 clips"]);
    }

    #[test]
    fn shares_show_no_idle_zeros() {
        assert_eq!([1.0, 0.5, 0.068, 0.0025, 0.0].map(percent), ["100 %", "50 %", "6.8 %", "0.25 %", "0 %"]);
    }
}
