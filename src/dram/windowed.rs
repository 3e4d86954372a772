//! Level `window`.
/// The memory as counts.
#[derive(Debug, Clone)]
pub struct Windowed;
