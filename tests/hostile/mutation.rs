//! Damage to files, the same for a seed on any machine.

use carpaint::math::hash::pcg4d;

/// Numbers that texts do not expect.
const NUMBERS: &[&str] = &[
    "nan",
    "NaN",
    "inf",
    "-inf",
    "1e999",
    "-1e999",
    "1e308",
    "1e30",
    "1e-320",
    "-1",
    "0",
    "-0.0",
    "0.5",
    "",
    "1",
    "255",
    "65536",
    "2147483648",
    "4294967295",
    "9223372036854775808",
    "18446744073709551616",
    "99999999999999999999999999",
    "null",
    "\"x\"",
    "[]",
];
/// Sizes that headers do not expect.
const WORDS: &[u64] =
    &[0, 1, 0xff, 0x7fff, 0xffff, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 1 << 62, 1 << 63, u64::MAX];
const SIGNS: &[u8] = b"{}[](),:;=#\"'\\/-+.eE \t\r\n\0\xff\xc3";
/// Where headers are.
const HEAD: usize = 512;

/// Numbers out of a seed and a count.
pub struct Draw {
    seed: u32,
    count: u32,
}

impl Draw {
    pub fn new(seed: u32) -> Self {
        Self { seed, count: 0 }
    }

    pub fn below(&mut self, n: usize) -> usize {
        self.count += 1;
        pcg4d([self.seed, self.count, 0, 29])[0] as usize % n.max(1)
    }

    fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }

    /// A byte of a file; half of them in its header.
    fn place(&mut self, length: usize) -> usize {
        let reach = if self.below(2) == 0 { length.min(HEAD) } else { length };
        self.below(reach)
    }
}

/// A file after one to three accidents.
pub fn mutated(file: &[u8], seed: u32) -> Vec<u8> {
    let mut draw = Draw::new(seed);
    let mut out = file.to_vec();
    let is_text = !file.contains(&0) && std::str::from_utf8(file).is_ok();
    for _ in 0..1 + draw.below(3) {
        if is_text && draw.below(4) != 0 {
            text_accident(&mut out, &mut draw);
        } else {
            accident(&mut out, &mut draw);
        }
    }
    // Half of the PNGs with sums that are right again: what comes after them is to be tried, too.
    if out.starts_with(b"\x89PNG") && draw.below(2) == 0 {
        right_sums(&mut out);
    }
    out
}

/// Checksum of a PNG's chunk (ISO 3309).
pub fn crc(bytes: &[u8]) -> u32 {
    let step = |c: u32, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 };
    !bytes.iter().fold(!0, |c, b| (0..8).fold(c ^ u32::from(*b), step))
}

/// Sets the checksums of all chunks of a PNG.
pub fn right_sums(png: &mut [u8]) {
    let mut at = 8;
    while let Some(length) = png.get(at..).and_then(|rest| rest.first_chunk()) {
        let end = (at + 8).saturating_add(u32::from_be_bytes(*length) as usize);
        let Some(chunk) = png.get(at + 4..end) else { return };
        let sum = crc(chunk).to_be_bytes();
        let Some(place) = png.get_mut(end..end + 4) else { return };
        place.copy_from_slice(&sum);
        at = end + 4;
    }
}

fn accident(out: &mut Vec<u8>, draw: &mut Draw) {
    if out.is_empty() {
        return;
    }
    let at = draw.place(out.len());
    let block = at..out.len().min(at + 1 + draw.below(64));
    match draw.below(8) {
        0 | 1 => out[at] ^= 1 << draw.below(8),
        2 => out[at] = draw.of(&[0, 255, 0x7f, 0x80, 1]),
        3 => drop(out.drain(block)),
        4 => {
            let copy = out[block.clone()].to_vec();
            out.splice(block.end..block.end, copy);
        }
        5 => {
            let byte = draw.of(&[0, 255, b' ', b'9']);
            out.splice(at..at, std::iter::repeat_n(byte, block.len()));
        }
        6 => {
            let (word, size) = (draw.of(WORDS), draw.of(&[2, 4, 8]));
            let bytes = if draw.below(3) == 0 {
                word.to_be_bytes()[8 - size..].to_vec()
            } else {
                word.to_le_bytes()[..size].to_vec()
            };
            // Most formats keep words at even places.
            let at = at & !1;
            out.iter_mut().skip(at).zip(bytes).for_each(|(old, new)| *old = new);
        }
        _ => {
            let from = draw.place(out.len());
            let copy: Vec<u8> = out[from..].iter().copied().take(block.len()).collect();
            out.iter_mut().skip(at).zip(copy).for_each(|(old, new)| *old = new);
        }
    }
}

fn text_accident(out: &mut Vec<u8>, draw: &mut Draw) {
    let numbers = numbers(out);
    match draw.below(6) {
        0..=2 if !numbers.is_empty() => {
            let number = numbers[draw.below(numbers.len())].clone();
            out.splice(number, draw.of(NUMBERS).bytes());
        }
        3 if !out.is_empty() => {
            let at = draw.below(out.len());
            out[at] = draw.of(SIGNS);
        }
        4 => {
            let at = draw.below(out.len() + 1);
            let (sign, count) = (draw.of(SIGNS), draw.of(&[1, 2, 300]));
            out.splice(at..at, std::iter::repeat_n(sign, count));
        }
        // A line twice, or gone.
        _ => {
            let lines: Vec<&[u8]> = out.split_inclusive(|b| *b == b'\n').collect();
            let (line, times) = (draw.below(lines.len()), draw.of(&[0, 2, 40]));
            let repeated = |(k, text): (usize, &&[u8])| text.repeat(if k == line { times } else { 1 });
            *out = lines.iter().enumerate().flat_map(repeated).collect();
        }
    }
}

/// Where numbers stand in a text.
fn numbers(text: &[u8]) -> Vec<std::ops::Range<usize>> {
    let is_part = |k: usize| matches!(text[k], b'0'..=b'9' | b'.' | b'-' | b'+' | b'e');
    let mut found = Vec::new();
    let mut at = 0;
    while at < text.len() {
        let end = (at..text.len()).find(|k| !is_part(*k)).unwrap_or(text.len());
        if text[at..end].iter().any(u8::is_ascii_digit) {
            found.push(at..end);
        }
        at = end.max(at + 1);
    }
    found
}
