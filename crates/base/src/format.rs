//! Numbers and text for people: prefixes, significant digits, columns.

/// Text of a CSV cell that no spreadsheet takes for a formula: a name that begins like one gets an
/// apostrophe in front. Numbers stay as they are.
pub fn spreadsheet_safe(text: String) -> String {
    let is_formula = text.starts_with(['=', '+', '-', '@', '\t', '\r']);
    if is_formula && text.parse::<f64>().is_err() { format!("'{text}") } else { text }
}

/// `0.00123` W is `1.23 mW`: three significant digits and an SI prefix.
pub fn engineering(x: f64, unit: &str) -> String {
    let (scaled, prefix) = prefixed(x);
    format!("{} {prefix}{unit}", significant(scaled))
}

/// `x` with the prefix that suits `like`, so that numbers on one screen can be compared: 0.000402 J
/// beside 0.00305 J is `0.402 mJ`.
pub fn engineering_like(x: f64, like: f64, unit: &str) -> String {
    let (factor, prefix) = prefix_of(like);
    format!("{} {prefix}{unit}", significant(x / factor))
}

/// An SI prefix that suits `x`, with its factor: `(1e-3, "m")` for 0.0012.
pub fn prefix_of(x: f64) -> (f64, &'static str) {
    const PREFIXES: [(f64, &str); 9] = [
        (1e12, "T"),
        (1e9, "G"),
        (1e6, "M"),
        (1e3, "k"),
        (1.0, ""),
        (1e-3, "m"),
        (1e-6, "µ"),
        (1e-9, "n"),
        (1e-12, "p"),
    ];
    let magnitude = x.abs();
    if magnitude == 0.0 || !magnitude.is_finite() {
        return (1.0, "");
    }
    // 0.9996 rounds to 1.00, so it belongs to the next prefix already.
    let fits = |&(factor, _): &(f64, &str)| magnitude >= factor * 0.9995;
    PREFIXES.into_iter().find(fits).unwrap_or((1e-12, "p"))
}

fn prefixed(x: f64) -> (f64, &'static str) {
    let (factor, prefix) = prefix_of(x);
    (x / factor, prefix)
}

/// Three significant digits without an exponent: `0.123`, `1.23`, `12.3`, `123`, `12345`.
pub fn significant(x: f64) -> String {
    let magnitude = x.abs();
    let digits = if magnitude == 0.0 || magnitude >= 99.95 {
        0
    } else if magnitude >= 9.995 {
        1
    } else if magnitude >= 0.9995 {
        2
    } else {
        3
    };
    format!("{x:.digits$}")
}

/// `1 frame`, `12 frames`, `2 entries`.
pub fn counted(n: impl std::fmt::Display, what: &str) -> String {
    let n = n.to_string();
    match what.strip_suffix('y').filter(|stem| !stem.ends_with(['a', 'e', 'o', 'u'])) {
        _ if n == "1" => format!("1 {what}"),
        Some(stem) => format!("{n} {stem}ies"),
        None => format!("{n} {what}s"),
    }
}

/// A frame rate that was set, not measured: `60`, `72`, `59.94`.
pub fn rate(fps: f64) -> String {
    let text = format!("{fps:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A span of time for people: seconds, minutes or hours.
pub fn time(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{} s", significant(s)),
        s if s < 5400.0 => format!("{} min", significant(s / 60.0)),
        s => format!("{} h", significant(s / 3600.0)),
    }
}

/// A share as a whole percentage; a positive share below half a percent is `<1`.
pub fn percent(share: f64) -> String {
    let p = share * 100.0;
    if p > 0.0 && p < 0.5 { "<1".into() } else { format!("{p:.0}") }
}

/// A unit of power that suits `most` watts: how many of it a watt is, and its name.
pub fn watt_unit(most: f64) -> (f64, String) {
    let (scale, prefix) = prefix_of(most);
    (scale.recip(), format!("{prefix}W"))
}

/// At most `width` characters; a longer text ends in `…`.
pub fn shortened(text: &str, width: usize) -> String {
    let clean: String = text.chars().map(|c| if c.is_control() { '?' } else { c }).collect();
    if clean.chars().count() <= width {
        return clean;
    }
    let kept: String = clean.chars().take(width.saturating_sub(1)).collect();
    format!("{kept}…")
}

/// At most `width` characters; a longer text has `…` in its middle, and keeps both ends.
pub fn shortened_inside(text: &str, width: usize) -> String {
    let clean: Vec<char> = text.chars().map(|c| if c.is_control() { '?' } else { c }).collect();
    if clean.len() <= width {
        return clean.into_iter().collect();
    }
    let kept = width.saturating_sub(1);
    let (head, tail) = (kept - kept / 2, kept / 2);
    let (head, tail) = (&clean[..head], &clean[clean.len() - tail..]);
    head.iter().chain(&['…']).chain(tail).collect()
}

/// A quantity as it was written, to three digits if it has more: `60.9 GB/s` for
/// `60.8874042881 GB/s`. What is no number with a unit, or has no fraction, stays.
pub fn rounded(text: &str) -> String {
    let (number, unit) = text.split_once(' ').unwrap_or((text, ""));
    let long = number.contains('.') && number.len() > 5;
    match number.parse::<f64>() {
        Ok(x) if long && x.abs() >= 0.1 => format!("{} {unit}", significant(x)).trim_end().into(),
        _ => text.to_owned(),
    }
}

/// Breaks `text` at spaces into lines of at most `width` characters; a longer word stays whole, and
/// `%` stays behind its number.
pub fn wrapped(text: &str, width: usize) -> String {
    let mut out = String::new();
    let mut column = 0;
    let mut words = text.split_whitespace().peekable();
    while let Some(word) = words.next() {
        let word = match words.next_if(|next| next.starts_with('%')) {
            Some(percent) => format!("{word} {percent}"),
            None => word.to_owned(),
        };
        let length = word.chars().count();
        if column > 0 && column + 1 + length > width {
            out.push('\n');
            column = 0;
        } else if column > 0 {
            out.push(' ');
            column += 1;
        }
        out.push_str(&word);
        column += length;
    }
    out
}
