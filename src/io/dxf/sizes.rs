//! Which blocks of a graded file are read: a block is one piece in one size.

use super::block::{Block, Drawing};
use crate::{Error, Warning};

/// A block that was chosen, with the name of its piece.
pub struct Piece {
    pub name: String,
    pub block: Block,
}

/// Name and size of the piece in a block, by its texts or else by its name, `PIECE_SIZE`.
fn piece_of(block: &Block, sample: Option<&str>) -> (String, Option<String>) {
    let size = block.texts.get(&["size"]);
    let (stem, ending) = match block.name.rsplit_once('_') {
        Some((stem, ending)) if !stem.is_empty() => (stem, Some(ending)),
        _ => (block.name.as_str(), None),
    };
    let is_size = |s: &str| ending.is_some_and(|e| e.eq_ignore_ascii_case(s));
    let named_by_size = size.or(sample).is_some_and(is_size);
    let stem = if named_by_size { stem } else { &block.name };
    let name = block.texts.get(&["piece name"]).unwrap_or(stem);
    let size = size.or(ending.filter(|_| named_by_size));
    (name.to_owned(), size.map(str::to_owned))
}

/// The pieces of one size: that asked for, else the sample size.
pub fn choose(drawing: &Drawing, asked: Option<&str>, warnings: &mut Vec<Warning>) -> Result<Vec<Piece>, Error> {
    let sample = drawing.style.get(&["sample size"]);
    let blocks: Vec<Block> = placed(drawing);
    let known: Vec<(String, Option<String>)> = blocks.iter().map(|block| piece_of(block, sample)).collect();
    let mut sizes: Vec<&str> = Vec::new();
    for size in known.iter().filter_map(|(_, size)| size.as_deref()) {
        if !sizes.iter().any(|s| s.eq_ignore_ascii_case(size)) {
            sizes.push(size);
        }
    }
    let is = |size: &str| sizes.iter().copied().find(|s| s.eq_ignore_ascii_case(size.trim()));
    // Only the sample size has its corners and notches marked.
    let marked = || {
        let has_marks = |k: &usize| blocks[*k].points.iter().any(|mark| (2..=4).contains(&mark.layer));
        (0..blocks.len()).filter(has_marks).find_map(|k| known[k].1.as_deref())
    };
    let own = sample.and_then(is).or_else(marked).or(sizes.get(sizes.len() / 2).copied());
    let chosen = match asked {
        Some(asked) if !sizes.is_empty() => Some(is(asked).ok_or_else(|| unknown(asked, &sizes))?),
        Some(asked) => return Err(unknown(asked, &sizes)),
        None => own,
    };
    if let (Some(chosen), true, None) = (chosen, sizes.len() > 1, asked) {
        let why =
            if sample.and_then(is).is_some() { "the sample size" } else { "the one that has marks, or the middle one" };
        warnings.push(Warning(Error::new(
            format!("The file holds the sizes {}; {chosen} was read, {why}.", listed(&sizes)),
            "Ask for another with --size.",
        )));
    }
    let of_size = |k: usize, size: Option<&str>| match (known[k].1.as_deref(), size) {
        (None, _) => true,
        (Some(own), Some(size)) => own.eq_ignore_ascii_case(size),
        (Some(_), None) => false,
    };
    let mut taken: Vec<usize> = (0..blocks.len()).filter(|&k| of_size(k, chosen)).collect();
    // A piece that is the same in all sizes may be there in the sample size alone.
    let names: std::collections::HashSet<String> = taken.iter().map(|&k| known[k].0.to_lowercase()).collect();
    let mut same: Vec<usize> = (0..blocks.len()).filter(|&k| !names.contains(&known[k].0.to_lowercase())).collect();
    same.retain(|&k| of_size(k, own));
    if !same.is_empty() {
        let names: Vec<&str> = same.iter().map(|&k| known[k].0.as_str()).collect();
        warnings.push(Warning(Error::new(
            format!("The file has {} in size {} only, which was taken.", listed(&names), own.unwrap_or_default()),
            "Check whether the piece is the same in all sizes.",
        )));
    }
    taken.extend(same);
    taken.sort_unstable();
    let mut blocks: Vec<Option<Block>> = blocks.into_iter().map(Some).collect();
    let piece = |k: usize| blocks[k].take().map(|block| Piece { name: known[k].0.clone(), block });
    Ok(taken.into_iter().filter_map(piece).collect())
}

fn listed(words: &[&str]) -> String {
    const MOST: usize = 20;
    let more = if words.len() > MOST { ", ..." } else { "" };
    let short = |word: &&str| word.chars().take(40).collect::<String>();
    words.iter().take(MOST).map(short).collect::<Vec<_>>().join(", ") + more
}

fn unknown(asked: &str, sizes: &[&str]) -> Error {
    let known = match sizes {
        [] => "The file does not say of any size; leave the option out.".to_owned(),
        sizes => format!("The file has {}.", listed(sizes)),
    };
    Error::new(format!("There is no size \"{}\".", listed(&[asked])), known).within("--size")
}

/// More inserts than blocks are copies of a piece; more copies than these are damage.
const MOST_COPIES: usize = 1_000;

/// The blocks with outlines where they are inserted, in the order of the file. Names may be repeated or mangled: of several
/// blocks and inserts of one name the first belongs to the first. What is inserted nowhere lies where it is drawn.
fn placed(drawing: &Drawing) -> Vec<Block> {
    let mut inserts: std::collections::HashMap<&str, std::collections::VecDeque<usize>> = Default::default();
    for (k, insert) in drawing.inserts.iter().enumerate() {
        inserts.entry(&insert.block).or_default().push_back(k);
    }
    let mut alike: std::collections::HashMap<&str, usize> = Default::default();
    for block in drawing.blocks.iter().filter(|b| b.has_outline()) {
        *alike.entry(&block.name).or_default() += 1;
    }
    let mut placed = Vec::new();
    for block in drawing.blocks.iter().filter(|b| b.has_outline()) {
        let only = alike[block.name.as_str()] == 1;
        match inserts.get_mut(block.name.as_str()) {
            Some(waiting) if only && waiting.len() > 1 => {
                let room = MOST_COPIES.saturating_sub(placed.len());
                placed.extend(waiting.iter().take(room).map(|&k| block.inserted(&drawing.inserts[k])));
            }
            waiting => match waiting.and_then(|w| w.pop_front()) {
                Some(k) => placed.push(block.inserted(&drawing.inserts[k])),
                None => placed.push(block.clone()),
            },
        }
    }
    placed
}
