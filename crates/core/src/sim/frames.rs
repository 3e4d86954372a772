//! Many frames: parallel across frames, results in order, memory bounded.

use rayon::prelude::*;

/// Runs `work` on every item and hands the results to `each` in the order of the items.
///
/// At most as many items as there are worker threads are alive at a time, so a trace of any length
/// runs in constant memory. The order of results, and so everything made from them, does not depend
/// on the number of threads.
///
/// # Errors
/// The first error of an item, of its work or of `each`, in the order of the items; what was handed
/// on before it stays handed on.
pub fn in_order<T, R, E>(
    items: impl IntoIterator<Item = Result<T, E>>,
    work: impl Fn(T) -> Result<R, E> + Sync,
    mut each: impl FnMut(R) -> Result<(), E>,
) -> Result<(), E>
where
    T: Send,
    R: Send,
    E: Send,
{
    let mut items = items.into_iter();
    let width = rayon::current_num_threads().max(1);
    loop {
        let group: Vec<Result<T, E>> = items.by_ref().take(width).collect();
        if group.is_empty() {
            return Ok(());
        }
        let results: Vec<Result<R, E>> =
            group.into_par_iter().map(|item| item.and_then(&work)).collect();
        for result in results {
            each(result?)?;
        }
    }
}
