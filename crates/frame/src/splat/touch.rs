//! Reading ahead of scattered numbers.

/// Reads a word of every cache line of the numbers that come next. Without arithmetic between the
/// reads their cache misses overlap, which what is done with the numbers is too long for.
#[inline(always)]
pub fn touch<'a>(numbers: impl Iterator<Item = &'a [f32]>) {
    const LINE: usize = 16;
    let mut sum = 0.0;
    for numbers in numbers {
        for line in numbers.chunks(LINE) {
            sum += line[0];
        }
        // Where numbers do not begin with a line, they end in one more.
        sum += numbers.last().copied().unwrap_or_default();
    }
    std::hint::black_box(sum);
}
