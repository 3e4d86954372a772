//! "Did you mean".

/// Longer words are not compared: they are no typing errors.
const WORD_MAX: usize = 64;

/// The candidate that `word` is most likely a typo of, if one is near enough.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if word.len() > WORD_MAX {
        return None;
    }
    let plain = |s: &str| s.to_lowercase().replace(['_', ' '], "-");
    let word = plain(word);
    let distance = |c: &str| strsim::damerau_levenshtein(&word, &plain(c));
    let allowed = (word.chars().count() / 3).clamp(1, 4);
    let scored = candidates.into_iter().map(|c| (distance(c), c));
    let prefixed = |c: &str| word.chars().count() >= 3 && plain(c).starts_with(&word);
    scored.filter(|(d, c)| *d <= allowed || prefixed(c)).min_by_key(|(d, _)| *d).map(|(_, c)| c)
}

/// The candidates, those that are most like `word` first.
pub fn by_likeness<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let word: String = word.chars().take(WORD_MAX).collect();
    let mut all: Vec<&str> = candidates.into_iter().collect();
    let likeness = |candidate: &str| strsim::jaro_winkler(&word, candidate);
    all.sort_by(|a, b| likeness(b).total_cmp(&likeness(a)));
    all
}
