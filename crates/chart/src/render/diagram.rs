//! The layout of block diagrams. Every text is measured before its box is drawn, so that a box is
//! as large as what is in it and nothing lies over anything else.

use super::scene::{Area, ScenePoint, Shape};
use super::{Align, Drawn, LINE, Page, TEXT, rgb, wrapped};
use crate::{Colour, Diagram, DiagramBlock, Words};

/// Between two blocks: room for an arrow.
const GAP: f64 = 26.0;
/// Around the texts of a box.
const PAD: f64 = 10.0;
/// Width of the coloured edge of a block.
const EDGE: f64 = 8.0;
/// Between two lines that pass blocks at their right.
const LANE: f64 = 16.0;
/// How far a part of a block is moved in.
const INDENT: f64 = 22.0;
/// Length of the head of an arrow.
const HEAD: f64 = 9.0;
/// Lines that one text has at most.
const MOST: usize = 12;

/// Left and right edges of what stands side by side.
struct DiagramColumns {
    memory: [f64; 2],
    block: [f64; 2],
    /// Where stores begin inside of a block.
    stores: f64,
}

/// A block with its wrapped texts.
struct MeasuredBlock {
    texts: Vec<Words>,
    /// Reads and writes.
    moves: [Vec<Words>; 2],
    stores: Vec<Vec<Words>>,
    height: f64,
}

/// Draws a diagram below `top`; returns where it ends.
pub(crate) fn draw(page: &Page, diagram: &Diagram, top: f64) -> Result<f64, String> {
    let lanes = lanes(&diagram.blocks);
    let most = lanes.iter().flatten().map(|lane| lane + 1).max().unwrap_or(0);
    let columns = columns(page, most);
    let measured: Vec<MeasuredBlock> =
        diagram.blocks.iter().map(|block| measure(block, &columns)).collect();
    let mut areas = Vec::new();
    let mut y = top;
    for (i, (block, of)) in diagram.blocks.iter().zip(&measured).enumerate() {
        let left = columns.block[0] + if block.is_part { INDENT } else { 0.0 };
        // Parts are near what they are of.
        y += match i {
            0 => 0.0,
            _ if block.is_part => GAP / 3.0,
            _ => GAP,
        };
        areas.push([left, y, columns.block[1], y + of.height]);
        y += of.height;
    }
    // A memory is at least as high as its name is long.
    let length = diagram.memory.iter().map(super::width).fold(0.0, f64::max);
    let end = areas.last().map_or(top, |area| area[3]).max(top + length + 2.0 * PAD);
    memory(page, &diagram.memory, [columns.memory[0], top, columns.memory[1], end])?;
    for ((block, of), area) in diagram.blocks.iter().zip(&measured).zip(&areas) {
        frame(page, block, of, *area, &columns)?;
        moves(page, of, *area, &columns)?;
    }
    for (i, block) in diagram.blocks.iter().enumerate() {
        let Some(after) = block.after else { continue };
        let ([left, bottom, right], to) =
            ([areas[after][0], areas[after][3], areas[after][2]], areas[i]);
        match lanes[i] {
            None => {
                let x = left.max(to[0]) + 60.0;
                arrow(page, &[(x, bottom), (x, to[1])])?;
            }
            Some(lane) => {
                let x = right + 14.0 + LANE * lane as f64;
                let from = bottom - 16.0 - 6.0 * lane as f64;
                arrow(page, &[(right, from), (x, from), (x, to[1] + 16.0), (to[2], to[1] + 16.0)])?;
            }
        }
    }
    Ok(end + 12.0)
}

/// The lane of each arrow that has to pass blocks; `None` where the block is the next one.
fn lanes(blocks: &[DiagramBlock]) -> Vec<Option<usize>> {
    let mut taken: Vec<(usize, usize, usize)> = Vec::new();
    let lane = |(i, block): (usize, &DiagramBlock)| {
        let after = block.after.filter(|after| after + 1 != i)?;
        let is_free = |lane: &usize| {
            taken.iter().all(|(other, from, to)| other != lane || i < *from || after > *to)
        };
        let lane = (0..=taken.len()).find(is_free)?;
        taken.push((lane, after, i));
        Some(lane)
    };
    blocks.iter().enumerate().map(lane).collect()
}

fn columns(page: &Page, lanes: usize) -> DiagramColumns {
    let (left, right) = (page.frame.left, page.frame.right);
    let gutter = if lanes > 0 { 14.0 + LANE * lanes as f64 } else { 0.0 };
    let (memory, moves) = if page.frame.is_narrow() { (58.0, 150.0) } else { (70.0, 310.0) };
    let start = left + memory + moves;
    let end = right - gutter;
    let stores = start + 0.54 * (end - start);
    DiagramColumns { memory: [left, left + memory], block: [start, end], stores }
}

fn measure(block: &DiagramBlock, columns: &DiagramColumns) -> MeasuredBlock {
    let left = columns.block[0] + if block.is_part { INDENT } else { 0.0 };
    let stores_end = if block.stores.is_empty() { columns.block[1] } else { columns.stores };
    let room = stores_end - left - EDGE - 2.0 * PAD;
    let lines = block.lines.iter().filter(|line| !line.is_empty());
    let texts = wrapped(&Words::bold(block.title.as_str()), room, TEXT, MOST).into_iter();
    let notes = lines.flat_map(|line| wrapped(&Words::from(line.as_str()), room, TEXT, MOST));
    let texts: Vec<Words> = texts.chain(notes).collect();
    let room = columns.block[0] - columns.memory[1] - 2.0 * PAD - 6.0;
    let moved = |text: &String| match text.is_empty() {
        true => Vec::new(),
        false => wrapped(&Words::note(text.as_str()), room, TEXT, MOST),
    };
    let moves = [moved(&block.reads), moved(&block.writes)];
    let room = columns.block[1] - columns.stores - 3.0 * PAD;
    let store = |[name, size]: &[String; 2]| {
        let name = wrapped(&Words::from(name.as_str()), room, TEXT, MOST);
        name.into_iter().chain(wrapped(&Words::note(size.as_str()), room, TEXT, MOST)).collect()
    };
    let stores: Vec<Vec<Words>> = block.stores.iter().map(store).collect();
    let of_texts = 2.0 * PAD + LINE * texts.len() as f64;
    let of_moves: f64 = moves.iter().map(|lines| move_height(lines)).sum();
    let of_stores: f64 = stores.iter().map(|lines| store_height(lines) + PAD).sum::<f64>() + PAD;
    MeasuredBlock { texts, moves, stores, height: of_texts.max(of_moves).max(of_stores) }
}

fn move_height(lines: &[Words]) -> f64 {
    if lines.is_empty() { 0.0 } else { LINE * lines.len() as f64 + 2.0 * HEAD + 4.0 }
}

fn store_height(lines: &[Words]) -> f64 {
    LINE * lines.len() as f64 + PAD
}

/// The memory, with its name upwards.
fn memory(page: &Page, words: &[Words; 2], area: Area) -> Drawn {
    page.fill(area, Colour::GRID)?;
    outline(page, area, 1.5)?;
    let [l, t, r, b] = area;
    let middle = (l + r) / 2.0;
    for (words, x) in words.iter().zip([middle - LINE / 2.0, middle + LINE / 2.0]) {
        let width = super::width(words);
        let start = (x + super::font::MIDDLE * TEXT, (t + b + width) / 2.0);
        page.push(Shape::Text(super::Text {
            text: words.text.clone(),
            start,
            width,
            size: TEXT,
            bold: words.bold,
            upwards: true,
            fill: rgb(words.colour),
            halo: 0.0,
        }));
    }
    Ok(())
}

fn frame(
    page: &Page,
    block: &DiagramBlock,
    of: &MeasuredBlock,
    area: Area,
    columns: &DiagramColumns,
) -> Drawn {
    let [l, t, r, b] = area;
    page.fill(area, Colour::PAPER)?;
    page.fill([l, t, l + EDGE, b], block.colour)?;
    outline(page, area, if block.is_part { 1.0 } else { 2.0 })?;
    lines(page, &of.texts, (l + EDGE + PAD, t + PAD));
    let mut y = t + PAD;
    for store in &of.stores {
        let own = [columns.stores, y, r - PAD, y + store_height(store)];
        page.fill(own, Colour::GRID)?;
        lines(page, store, (own[0] + PAD, y + PAD / 2.0));
        y = own[3] + PAD;
    }
    Ok(())
}

/// What goes from the memory to a block, and back.
fn moves(page: &Page, of: &MeasuredBlock, area: Area, columns: &DiagramColumns) -> Drawn {
    let (from, to) = (columns.memory[1], area[0]);
    let mut y = area[1];
    for (words, is_write) in of.moves.iter().zip([false, true]) {
        if words.is_empty() {
            continue;
        }
        lines(page, words, (from + PAD, y));
        y += LINE * words.len() as f64 + HEAD;
        let ends = if is_write { [(to, y), (from, y)] } else { [(from, y), (to, y)] };
        arrow(page, &ends)?;
        y += HEAD + 4.0;
    }
    Ok(())
}

/// Lines of text, the upper left corner of the first at a point.
fn lines(page: &Page, words: &[Words], (x, y): ScenePoint) {
    for (i, line) in words.iter().enumerate() {
        page.text(line, (x, y + LINE * (i as f64 + 0.5)), Align::Left);
    }
}

fn outline(page: &Page, [l, t, r, b]: Area, width: f64) -> Drawn {
    page.line(&[(l, t), (r, t), (r, b), (l, b), (l, t)], Colour::NOTE, width)
}

/// A line whose last part, upright or level, ends in a head.
fn arrow(page: &Page, points: &[ScenePoint]) -> Drawn {
    let [.., from, to] = points else { return Ok(()) };
    let length = (to.0 - from.0).abs().max((to.1 - from.1).abs()).max(1.0);
    let (x, y) = ((to.0 - from.0) / length, (to.1 - from.1) / length);
    let back = (to.0 - HEAD * x, to.1 - HEAD * y);
    let mut shaft = points.to_vec();
    shaft.pop();
    shaft.push(back);
    page.line(&shaft, Colour::NOTE, 2.0)?;
    let side = HEAD / 2.0;
    let points =
        vec![*to, (back.0 - side * y, back.1 + side * x), (back.0 + side * y, back.1 - side * x)];
    page.push(Shape::Polygon { points, fill: rgb(Colour::NOTE) });
    Ok(())
}
