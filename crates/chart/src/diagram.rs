//! Block diagrams: what works on what, what it stores, and what it moves from and to a memory.

use super::{Colour, Words};

/// Blocks below each other, with a memory at the left that all of them reach.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagram {
    /// What the memory is called, and what is said of it.
    pub memory: [Words; 2],
    /// The blocks, each later than the one that it is after.
    pub blocks: Vec<DiagramBlock>,
}

/// A block of a diagram.
#[derive(Debug, Clone, PartialEq)]
pub struct DiagramBlock {
    /// What it is called.
    pub title: String,
    /// Lines under that; they are wrapped.
    pub lines: Vec<String>,
    /// The colour of its edge.
    pub colour: Colour,
    /// Whether it is part of a block above it.
    pub is_part: bool,
    /// The block whose results it works on, by its place in the list.
    pub after: Option<usize>,
    /// What it reads from the memory; empty for nothing.
    pub reads: String,
    /// What it writes to the memory; empty for nothing.
    pub writes: String,
    /// What it stores things in: names, and what is said of each.
    pub stores: Vec<[String; 2]>,
}
