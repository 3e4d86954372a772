//! How far a sequence is from sorted.

/// Sequences up to this are sorted by insertion.
const SHORT: usize = 16;

/// Pairs of `values` of which the earlier is greater; sorts them. Linear where they are sorted.
pub(crate) fn count(values: &mut [u32], spare: &mut Vec<u32>) -> u64 {
    if values.len() <= SHORT {
        return insert(values);
    }
    let (left, right) = values.split_at_mut(values.len() / 2);
    let found = count(left, spare) + count(right, spare);
    if left[left.len() - 1] <= right[0] {
        return found;
    }
    found + merge(values, spare)
}

fn insert(values: &mut [u32]) -> u64 {
    let mut found = 0;
    for end in 1..values.len() {
        let value = values[end];
        let mut at = end;
        while at > 0 && values[at - 1] > value {
            values[at] = values[at - 1];
            at -= 1;
        }
        values[at] = value;
        found += (end - at) as u64;
    }
    found
}

/// Merges the sorted halves of `values`.
fn merge(values: &mut [u32], spare: &mut Vec<u32>) -> u64 {
    let middle = values.len() / 2;
    spare.clear();
    spare.extend_from_slice(&values[..middle]);
    let (mut left, mut right, mut found) = (0, middle, 0);
    for at in 0..values.len() {
        if left == middle {
            break;
        }
        if right < values.len() && values[right] < spare[left] {
            found += (middle - left) as u64;
            values[at] = values[right];
            right += 1;
        } else {
            values[at] = spare[left];
            left += 1;
        }
    }
    found
}
