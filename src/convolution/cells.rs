//! Nodes of 4³ cells moved over neighbourhoods of 8³: what one word says of sixty-four moves at once.
//!
//! A node is one word, bit 16·z + 4·y + x; a neighbourhood eight, one a layer, bit 8·y + x.

use super::tree::Neighbourhood;

/// Cells x < 4, y < 4 of a layer.
const CORNER: u64 = 0x0F0F_0F0F;

/// Whether moves told by [`sweep`] are all of them.
#[inline(always)]
pub(super) fn all_met(met: &[u64; 4]) -> bool {
    met.iter().all(|m| m & CORNER == CORNER)
}

/// The cells of a node, one after the other.
#[inline(always)]
pub(super) fn set_bits(node: u64) -> impl Iterator<Item = [u32; 3]> {
    let mut rest = node;
    std::iter::from_fn(move || {
        let bit = (rest != 0).then(|| rest.trailing_zeros())?;
        rest &= rest - 1;
        Some([bit & 3, bit >> 2 & 3, bit >> 4])
    })
}

/// Unites, for each move r ∈ {0 … 3}³, whether a cell of the node moved by r meets one of the neighbourhood: layer r_z, bit
/// 8·r_y + r_x. Tells about how many moves of four layers that took.
#[inline(always)]
pub(super) fn sweep(node: u64, cells: &Neighbourhood, met: &mut [u64; 4]) -> u64 {
    let count = node.count_ones();
    if count < FEW {
        set_bits(node).for_each(|[x, y, z]| add_moved(cells, z as usize, 8 * y + x, met));
        return u64::from(count);
    }
    if node == !0 {
        // Cells that four along x, y and z meet; what wraps into another row is beyond all moves.
        let all = cells.map(|c| c | c >> 1).map(|c| c | c >> 2).map(|c| c | c >> 8).map(|c| c | c >> 16);
        for (layer, m) in met.iter_mut().enumerate() {
            *m |= all[layer] | all[layer + 1] | all[layer + 2] | all[layer + 3];
        }
        return 4;
    }
    // What each set of four cells along x meets.
    let mut fours = [[0; 8]; 16];
    for four in 1..16usize {
        let (rest, shift) = (four & (four - 1), four.trailing_zeros());
        for layer in 0..8 {
            fours[four][layer] = fours[rest][layer] | cells[layer] >> shift;
        }
    }
    for row in 0..16 {
        let four = &fours[(node >> (4 * row) & 0xF) as usize];
        for (layer, m) in met.iter_mut().enumerate() {
            *m |= four[(row >> 2) + layer] >> (8 * (row & 3));
        }
    }
    12
}

/// Nodes and neighbourhoods that have been swept: flat faces lie over each other in many equal pairs.
#[derive(Default)]
pub(super) struct Swept {
    round: u32,
    pairs: [(u64, u32, u32); 32],
}

impl Swept {
    #[inline(always)]
    pub fn forget(&mut self) {
        self.round += 1;
    }

    /// Whether a pair has been asked for since, as far as is remembered; remembers it.
    #[inline(always)]
    pub fn contains(&mut self, node: u64, number: u32) -> bool {
        let hash = (node ^ u64::from(number)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let pair = (node, number, self.round);
        std::mem::replace(&mut self.pairs[(hash >> 59) as usize], pair) == pair
    }
}

/// What finding a pair costs, in moves of four layers.
pub(super) const OF_PAIR: u64 = 4;

/// Below this number of cells they are swept one by one.
const FEW: u32 = 7;

#[inline(always)]
fn add_moved(cells: &Neighbourhood, z: usize, shift: u32, met: &mut [u64; 4]) {
    for (layer, m) in met.iter_mut().enumerate() {
        *m |= cells[z + layer] >> shift;
    }
}

/// The cells x < 4, y < 4 of four layers as bits 16·z + 4·y + x.
#[inline(always)]
pub(super) fn gathered(layers: [u64; 4]) -> u64 {
    let mut word = 0;
    for (z, layer) in layers.into_iter().enumerate() {
        let v = layer & CORNER;
        let v = (v | v >> 4) & 0x00FF_00FF;
        word |= ((v | v >> 8) & 0xFFFF) << (16 * z);
    }
    word
}
