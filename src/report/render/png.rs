//! Pixels into a PNG file of few colours: small enough to be mailed.

use super::canvas::Canvas;
use super::colour::Rgb;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

/// Bits kept of each channel when colours are counted.
const BITS: u32 = 6;

/// The picture as a PNG file of at most `colours` (2 to 256) colours.
///
/// # Cost
/// O(pixels).
///
/// # Source
/// The palette is by median cut (Heckbert 1982), each colour the mean of its box.
pub fn encode(canvas: &Canvas, colours: usize) -> Vec<u8> {
    let (palette, table) = palette(canvas.pixels(), colours.clamp(2, 256));
    let pixels: Vec<u8> = canvas.pixels().iter().flat_map(|&c| palette[usize::from(table[bin(c)])]).collect();
    let mut out = Vec::new();
    // Few colours repeat whole pixels, which deflate packs best without a filter. Writing to memory cannot fail.
    let to = PngEncoder::new_with_quality(&mut out, CompressionType::Default, FilterType::NoFilter);
    let (width, height) = (canvas.width() as u32, canvas.height() as u32);
    let _ = to.write_image(&pixels, width, height, ExtendedColorType::Rgb8);
    out
}

/// Where a colour is counted.
fn bin([r, g, b]: Rgb) -> usize {
    let cut = |c: u8| (c >> (8 - BITS)) as usize;
    (cut(r) << (2 * BITS)) | (cut(g) << BITS) | cut(b)
}

/// A counted colour: how often, and the sums of its channels.
#[derive(Clone, Copy)]
struct Counted {
    bin: usize,
    count: u64,
    sum: [u64; 3],
}

impl Counted {
    fn mean(&self, channel: usize) -> u64 {
        self.sum[channel] / self.count.max(1)
    }
}

/// A palette of at most `colours`, and for each bin its place in it.
fn palette(pixels: &[Rgb], colours: usize) -> (Vec<Rgb>, Vec<u8>) {
    let mut place = vec![u32::MAX; 1 << (3 * BITS)];
    let mut counted: Vec<Counted> = Vec::new();
    for &c in pixels {
        let at = &mut place[bin(c)];
        if *at == u32::MAX {
            *at = counted.len() as u32;
            counted.push(Counted { bin: bin(c), count: 0, sum: [0; 3] });
        }
        let k = &mut counted[*at as usize];
        k.count += 1;
        k.sum = [0, 1, 2].map(|a| k.sum[a] + u64::from(c[a]));
    }
    let mut boxes = vec![counted];
    while boxes.len() < colours {
        let Some((at, channel)) = widest(&boxes) else { break };
        let mut low = boxes.swap_remove(at);
        low.sort_by_key(|k| (k.mean(channel), k.bin));
        let half: u64 = low.iter().map(|k| k.count).sum::<u64>() / 2;
        let mut seen = 0;
        let cut = low.iter().take_while(|k| {
            seen += k.count;
            seen <= half
        });
        let cut = cut.count().clamp(1, low.len() - 1);
        let high = low.split_off(cut);
        boxes.extend([low, high]);
    }
    let mut table = vec![0u8; 1 << (3 * BITS)];
    let mut palette = Vec::with_capacity(boxes.len());
    for (i, members) in boxes.iter().enumerate() {
        let count: u64 = members.iter().map(|k| k.count).sum();
        palette.push([0, 1, 2].map(|a| (members.iter().map(|k| k.sum[a]).sum::<u64>() / count.max(1)) as u8));
        members.iter().for_each(|k| table[k.bin] = i as u8);
    }
    (palette, table)
}

/// The box to cut next and the channel to cut it by: widest spread, weighted softly by how many pixels it holds.
fn widest(boxes: &[Vec<Counted>]) -> Option<(usize, usize)> {
    let mut best: Option<(f64, usize, usize)> = None;
    for (at, members) in boxes.iter().enumerate().filter(|(_, m)| m.len() > 1) {
        let count: u64 = members.iter().map(|k| k.count).sum();
        for channel in 0..3 {
            let means = members.iter().map(|k| k.mean(channel));
            let (least, most) = means.fold((u64::MAX, 0), |(a, b), m| (a.min(m), b.max(m)));
            let score = (most - least) as f64 * (count as f64).powf(0.22);
            if best.is_none_or(|b| score > b.0) {
                best = Some((score, at, channel));
            }
        }
    }
    best.map(|(_, at, channel)| (at, channel))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_decoder_reads_the_picture_back() {
        let mut canvas = Canvas::new(33, 20, [250, 251, 252]);
        canvas.disc([10.0, 10.0], 6.0, [200, 16, 32], 1.0);
        canvas.line([0.0, 19.0], [32.0, 0.0], 2.0, [0, 64, 128], 0.5);
        let file = encode(&canvas, 64);
        let back = image::load_from_memory(&file).unwrap().to_rgb8();
        assert_eq!((back.width(), back.height()), (33, 20));
        for (x, y, p) in back.enumerate_pixels() {
            let truth = canvas.at(x as usize, y as usize);
            // Soft edges make more colours than 64; the mean of a small box of them is near to each.
            assert!((0..3).all(|c| p.0[c].abs_diff(truth[c]) < 12), "{x},{y}: {p:?} {truth:?}");
        }
    }
}
